"""Studies: run many labelled scenarios, measure them into one pandas frame, analyse the frame.

`study`             runs and their rows, on disk and resumed, a row whatever happens: `run_study`
`quantities`        one number of a run each, or the reason why the run does not have it
`parallel`          processes of this machine, through joblib, or a Dask cluster
`convergence`       observed order, Richardson limit, grid convergence index, verdicts
`refinement`        levels of elements, modes, steps, stiffness, tolerances: `refine`; `series` and study files
`predictability`    sensitivity to the initial angle
`periodic`          steady state on a shaken base: period, impacts per period, stroboscopic samples
`fitting`           keys found from measured data: `fit`
`sweep`             a scenario over axes of its keys, from a TOML file; `design` of the runs; `maps` of the results
"""
