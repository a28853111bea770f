"""Time series of the deformed beam for ParaView and its kin, from a history alone.

`selection.Selection`   which samples become frames, and the increasing times they carry
`scene.Scene`           what every frame shows: parts with their results, and field data
`pvd`, `vtkhdf`, `xdmf`, `csv` one writer a format: ``write(scene, target, advance)``
`command`               options of the command line, progress, messages
"""
