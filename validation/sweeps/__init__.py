"""Sweeps: a base scenario over axes of its keys, in parallel, resumable, into one table.

`keys`      what can be swept: keys of a scenario, their units and types
`design`    axes, tables and samples, and the values of each run
`plan`      a sweep file, read and checked: everything that can be refused is refused here
`work`      one run in a process of its own: a row, whatever happens
`pool`, `cluster`   run rows on processes of this machine, or on a Dask cluster
`store`     the folder: lock, fingerprint, finished rows, histories
`table`     the Parquet table
`figures`, `report`, `command`  pictures; HTML; the command line's words
"""
