"""Run the checks in parallel and report: results.json, results.csv and report.html."""

from __future__ import annotations

import os
import time
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd

from oblique_impact.errors import InputError
from oblique_impact.files import writing
from oblique_impact.progress import OnProgress, silent
from oblique_impact.scenario.messages import counted, did_you_mean
from oblique_impact.validation.checks.plots import tolerance_figure
from oblique_impact.validation.checks.registry import Check, CheckGroup, Evidence, all_checks
from oblique_impact.validation.report import Block, Cell, Column, Section, Table, Text, cell
from oblique_impact.validation.result import Result
from oblique_impact.validation.studies.parallel import map_parallel

_NUMBER = Column(within="tolerance")
_COLUMNS = {
    "id": Column(code=True),
    "quantity": Column(text=True),
    "computed": _NUMBER,
    "reference": _NUMBER,
    "unit": Column(),
    "error": Column(digits=2),
    "tolerance": Column(digits=2),
    "verdict": Column(),
}
_KINDS = {"pass": "pass", "fail": "fail"}


def select(only: Sequence[str] = (), quick: bool = False) -> list[Check]:
    """Return the checks whose id or group is in `only` (all if empty), without the slow ones if `quick`.

    Raises InputError for a name that is neither.
    """
    checks = list(all_checks().values())
    groups = list(dict.fromkeys(check.group.id for check in checks))
    for name in only:
        if name not in groups and name not in all_checks():
            meant = did_you_mean(name, [*groups, *all_checks()])
            raise InputError(
                f"--only {name}: should be a group ({', '.join(groups)}) or a check such as {checks[0].id}{meant}"
            )
    chosen = [check for check in checks if not only or check.id in only or check.group.id in only]
    return [check for check in chosen if not quick or check.mark == "quick"]


def evidence_of(check_id: str) -> Evidence:
    """Compute one check, in whatever process this is."""
    return all_checks()[check_id].evidence()


def rows_of(checks: Sequence[Check], evidence: Mapping[str, Evidence]) -> pd.DataFrame:
    """Return a row for each measurement, by its id, with the columns of results.json."""
    rows = [
        {
            "id": f"{check.id}.{m.name}" if m.name else check.id,
            "group": check.group.id,
            "problem": check.problem,
            "quantity": m.quantity,
            "computed": float(m.computed),
            "reference": float(m.reference),
            "unit": m.unit,
            "error": m.error,
            "tolerance": float(m.tolerance),
            "verdict": m.verdict,
            "source": m.source,
        }
        for check in checks
        for m in evidence[check.id].measurements
    ]
    return pd.DataFrame(rows).set_index("id")


def validate(
    out: str | os.PathLike[str] | None = None,
    only: Sequence[str] = (),
    quick: bool = False,
    workers: int | None = None,
    on_progress: OnProgress = silent,
) -> Result:
    """Run the chosen checks, and write report.html, results.json and results.csv.

    Parameters
    ----------
    out : path, optional
        Folder for the report; without it nothing is written.
    only : sequence of str
        Ids of checks or groups; empty: all.
    quick : bool
        Leave out the checks that are marked full: those that take more than two seconds.
    workers : int, optional
        Parallel processes; default: the cores.  With one, everything runs in this process.
    on_progress : callable, optional
        Called with a :class:`~oblique_impact.progress.Progress` before the first check and after each.

    Returns
    -------
    Result
        A row for each measurement, by its id; the verdict is "pass" or "fail".

    Raises
    ------
    InputError
        In one line, for an unknown name or a folder that cannot be written.

    Examples
    --------
    >>> from oblique_impact.validation import validate
    >>> validate(only=["rigid-impact"], quick=True, workers=1).failed.index.tolist()
    []
    """
    checks = select(only, quick)
    started = time.perf_counter()
    longest_first = [check.id for check in sorted(checks, key=lambda check: -check.seconds)]
    with writing(out):
        found = map_parallel(evidence_of, longest_first, workers, on_progress)
        evidence = dict(zip(longest_first, found, strict=True))
        result = _result(checks, evidence, time.perf_counter() - started)
        if out is not None:
            result.save(out)
    return result


def _result(checks: Sequence[Check], evidence: Mapping[str, Evidence], seconds: float) -> Result:
    def sections(result: Result) -> Iterator[Section]:
        """Yield a part for each group, with problems, measurements, references and pictures."""
        for group, own in _groups(result.frame):
            blocks = [block for check in checks if check.group == group for block in _blocks(check, evidence, own)]
            verdict = "fail" if (own["verdict"] == "fail").any() else "pass"
            yield Section(group.title, blocks, verdict, counted(len(own), "measurement"), opened=verdict == "fail")

    return Result(
        "Validation of oblique-impact",
        "The program is compared with closed forms, published tests, balances and other programs. A measurement "
        "passes when the absolute difference of computed and reference value is at most its tolerance.",
        "checks",
        rows_of(checks, evidence),
        _KINDS,
        _COLUMNS,
        seconds=seconds,
        overview=lambda result: _overview(result.frame),
        sections=sections,
    )


def _groups(frame: pd.DataFrame) -> list[tuple[CheckGroup, pd.DataFrame]]:
    """Return the groups, each with its rows."""
    groups = {check.group.id: check.group for check in all_checks().values()}
    return [(groups[str(name)], own) for name, own in frame.groupby("group", sort=False)]


def _overview(frame: pd.DataFrame) -> list[Block]:
    """Return table and picture of the groups."""
    rows, ratios = [], []
    for group, own in _groups(frame):
        failed, ratio = int((own["verdict"] == "fail").sum()), _ratios(own)
        worst = cell(float(np.max(np.nan_to_num(ratio, nan=np.inf), initial=0.0)), 2)
        verdict = "fail" if failed else "pass"
        numbers = [len(own), len(own) - failed, worst]
        rows.append([group.title, Cell(group.id, "code"), *numbers, Cell(verdict, verdict)])
        ratios.append((group.title, ratio))
    columns = ("group", "--only", "measurements", "passed", "largest error/tolerance", "verdict")
    return [Table(columns, rows, "Groups of checks."), tolerance_figure(ratios)]


def _ratios(rows: pd.DataFrame) -> np.ndarray[Any, Any]:
    """Error over tolerance; an exact demand that is met is 0."""
    error, tolerance = rows["error"].to_numpy(), rows["tolerance"].to_numpy()
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(error == 0.0, 0.0, error / tolerance)


def _blocks(check: Check, evidence: Mapping[str, Evidence], rows: pd.DataFrame) -> list[Block]:
    """Return the problem of a check, its measurements, their references and pictures."""
    mine = rows[[f"{name}.".startswith(f"{check.id}.") for name in rows.index]]
    sources = list(dict.fromkeys(mine["source"]))
    reference = Text(f"Reference: {'; '.join(filter(None, sources))}.", note=True)
    return [Table.of_frame(mine, check.problem, _COLUMNS, _KINDS), reference, *evidence[check.id].pictures]
