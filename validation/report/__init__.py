"""Reports: self-contained HTML with its tables as JSON and CSV, and figures in one style.

`document`   what a report consists of, and how it is written
`figures`    figures as SVG that is the same from run to run
`provenance` what made a report: command, versions, machine
"""
