"""Sweeps: a base scenario over axes of its keys, in parallel, resumable, into one table.

`keys`      what can be swept: keys of a scenario, their units and types
`design`    axes, tables and samples, and the values of each run
`plan`      a sweep file, read and checked: everything that can be refused is refused here
`store`     the folder: lock, fingerprint, finished rows, histories
`table`     the Parquet table
`figures`, `report`, `command`  pictures; HTML; the command line's words
"""
