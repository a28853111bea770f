"""One report writer: a self-contained page, with its data as JSON and CSV.

A report is sections of text, tables and pictures:

    from oblique_impact.validation.report import Cell, Report, Section, Table, Text, picture

    with picture("Force over time.", width=9.2, height=3.4) as drawn:
        drawn.figure.add_subplot().plot(t, force)
    report = Report(
        "Title", "What this is about.", command="oblique-impact ...", seconds=1.5,
        facts=[("runs", "12")],
        overview=[Table(["quantity", "value (N)", "verdict"], [["force", 5.25, Cell("agrees", "pass")]]), drawn],
        sections=[Section("Runs", [Text("A paragraph."), Table.of_frame(frame)])],
    )
    report.write(folder, data={"force": 5.25}, table=frame)

writes report.html, results.json and results.csv into `folder`, each whole or not at all; versions, machine and
provenance are added to the page and to the JSON.  Cells of a table are texts, numbers (six digits; `cell` takes
others), None, or a `Cell`, whose kind "pass", "partly" or "fail" gives it colour and mark.  `number` formats a
number for reading.  `write_csv` and `write_file` write further files.

`document`    blocks, report, files
`figures`     figures as SVG that are the same from run to run
`provenance`  what made a report: command, versions, machine
"""

from oblique_impact.validation.report.document import (
    MARKS,
    Block,
    Cell,
    Fold,
    Item,
    Picture,
    Report,
    Section,
    Table,
    Text,
    cell,
    number,
    with_unit,
    write_csv,
    write_file,
)
from oblique_impact.validation.report.figures import FULL, HALF, new_figure, picture, to_svg
from oblique_impact.validation.report.provenance import provenance_data

__all__ = [
    "FULL",
    "HALF",
    "MARKS",
    "Block",
    "Cell",
    "Fold",
    "Item",
    "Picture",
    "Report",
    "Section",
    "Table",
    "Text",
    "cell",
    "new_figure",
    "number",
    "picture",
    "provenance_data",
    "to_svg",
    "with_unit",
    "write_csv",
    "write_file",
]
