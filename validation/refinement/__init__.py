"""Refinement studies: quantities of interest over elements, modes, steps or tolerances, and what they converge to.

`convergence`  observed order, Richardson limit, grid convergence index; the rule of the verdicts
`quantities`   one number of a run each, or the reason why the run does not have it
`ladders`      what is refined: axes, levels, ladders and studies as descriptions
`study`        runs them in parallel and judges them
`shipped`      the shipped studies
`figures`, `report`, `command`  pictures; HTML, JSON and CSV; the command line's words
"""
