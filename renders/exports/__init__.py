"""Time series of the deformed beam for ParaView, PyVista and meshio, and tables, from a history alone.

`selection`  which samples become frames
`parts`      the meshes of a frame with their results, and field data
`writers`    PVD, XDMF and CSV
`command`    the call `export`, and the command of the same name
"""
