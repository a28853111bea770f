"""Time series of the deformed beam for ParaView, PyVista and meshio, and tables, from a history alone.

`command`  the call `export`, which chooses the samples, and the command of the same name
`parts`    the meshes of a frame with their results, and field data
`writers`  PVD, XDMF and CSV
"""
