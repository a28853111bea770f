"""Pictures of results.

`campbell.campbell_diagram`  frequencies of the spinning beam
`overview.overview_figure`   a run at a glance, one or several histories side by side
`export.command`             time series for ParaView: PVD, VTKHDF, XDMF
"""
