"""Run the checks in parallel and report: results.json, results.csv and report.html."""

from __future__ import annotations

import os
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from oblique_impact.errors import InputError
from oblique_impact.files import writing
from oblique_impact.progress import OnProgress, silent
from oblique_impact.scenario.messages import counted, did_you_mean
from oblique_impact.validation.checks.plots import tolerance_figure
from oblique_impact.validation.checks.registry import Check, CheckGroup, Evidence, all_checks
from oblique_impact.validation.report import (
    Block,
    Cell,
    Report,
    Section,
    Table,
    Text,
    cell,
    number_within,
    shown_unit,
)
from oblique_impact.validation.studies.parallel import map_parallel


@dataclass(frozen=True, repr=False)
class Result:
    """One measurement of a check: a row of results.json."""

    id: str
    group: str
    problem: str
    quantity: str
    computed: float
    reference: float
    unit: str
    error: float
    tolerance: float
    verdict: str
    source: str

    @property
    def check(self) -> str:
        """Id of the check that the measurement belongs to."""
        return f"{self.group}.{self.id.removeprefix(f'{self.group}.').partition('.')[0]}"

    def __repr__(self) -> str:
        """Return verdict, error and tolerance in a line."""
        return f"<{self.id}: {self.verdict}, error {self.error:.2g} {self.unit}, tolerance {self.tolerance:.2g}>"


class Results(list[Result]):
    """The measurements of the checks that ran, in their order."""

    def __repr__(self) -> str:
        """Return how many there are, and those that fail."""
        failed = [result for result in self if result.verdict == "fail"]
        return "\n".join([f"<Results: {counts(self)}>", *(f"  {result!r}" for result in failed)])

    def _repr_html_(self) -> str:
        """Show the head of the report in a notebook."""
        return Report(_TITLE, counts(self), overview=_overview(self))._repr_html_()

    def to_dataframe(self) -> pd.DataFrame:
        """Return a row for each measurement, as in results.csv."""
        return pd.DataFrame([asdict(result) for result in self])


_TITLE = "Validation of oblique-impact"


def counts(results: Sequence[Result]) -> str:
    """Return how many checks and measurements there are and how many fail, for page and console."""
    checks, failed = len({result.check for result in results}), sum(r.verdict == "fail" for r in results)
    numbers = f"{counted(checks, 'check')}, {counted(len(results), 'measurement')}"
    return f"{numbers}: {f'{failed} fail' if failed else 'all pass'}"


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


def results_of(checks: Sequence[Check], evidence: dict[str, Evidence]) -> Results:
    """Rows of all measurements."""
    return Results(
        Result(
            f"{check.id}.{m.name}" if m.name else check.id,
            check.group.id,
            check.problem,
            m.quantity,
            float(m.computed),
            float(m.reference),
            m.unit,
            m.error,
            float(m.tolerance),
            m.verdict,
            m.source,
        )
        for check in checks
        for m in evidence[check.id].measurements
    )


def validate(
    out: str | os.PathLike[str] | None = None,
    only: Sequence[str] = (),
    quick: bool = False,
    workers: int | None = None,
    on_progress: OnProgress = silent,
) -> Results:
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
    Results
        A list with a `Result` for each measurement; ``verdict`` is "pass" or "fail".

    Raises
    ------
    InputError
        In one line, for an unknown name or a folder that cannot be written.

    Examples
    --------
    >>> from oblique_impact.validation import validate
    >>> results = validate(only=["rigid-impact"], quick=True, workers=1)
    >>> [result.id for result in results if result.verdict == "fail"]
    []
    """
    checks = select(only, quick)
    started = time.perf_counter()
    longest_first = [check.id for check in sorted(checks, key=lambda check: -check.seconds)]
    with writing(out):
        found = map_parallel(evidence_of, longest_first, workers, on_progress)
        evidence = dict(zip(longest_first, found, strict=True))
        seconds = time.perf_counter() - started
        results = results_of(checks, evidence)
        if out is not None:
            table = results.to_dataframe()
            _report(checks, evidence, results, seconds).write(Path(out), {"checks": table}, table)
    return results


def _report(
    checks: Sequence[Check], evidence: dict[str, Evidence], results: Sequence[Result], seconds: float
) -> Report:
    sections = []
    for group, own in _groups(results).items():
        failed = any(result.verdict == "fail" for result in own)
        blocks = [block for check in checks if check.group == group for block in _blocks(check, evidence, own)]
        count = counts(own).partition(":")[0]
        sections.append(Section(group.title, blocks, "fail" if failed else "pass", count, opened=failed))
    return Report(
        _TITLE,
        f"{counts(results)}. The program is compared with closed forms, published tests, balances and other "
        "programs. A measurement passes when the absolute difference of computed and reference value is at "
        "most its tolerance.",
        seconds,
        overview=_overview(results),
        sections=sections,
        filtered=True,
    )


def _groups(results: Sequence[Result]) -> dict[CheckGroup, list[Result]]:
    """Return the measurements of each group."""
    found: dict[CheckGroup, list[Result]] = {}
    for result in results:
        found.setdefault(all_checks()[result.check].group, []).append(result)
    return found


def _overview(results: Sequence[Result]) -> list[Block]:
    """Return table and picture of the groups."""
    rows, ratios = [], []
    for group, own in _groups(results).items():
        failed, ratio = sum(result.verdict == "fail" for result in own), _ratios(own)
        numbers = [len({result.check for result in own}), len(own), len(own) - failed]
        worst = cell(float(np.max(np.nan_to_num(ratio, nan=np.inf), initial=0.0)), 2)
        verdict = "fail" if failed else "pass"
        rows.append([group.title, Cell(group.id, "code"), *numbers, worst, Cell(verdict, verdict)])
        ratios.append((group.title, ratio))
    columns = ("group", "--only", "checks", "measurements", "passed", "largest error/tolerance", "verdict")
    return [Table(columns, rows, "Groups of checks."), tolerance_figure(ratios)]


def _ratios(results: Sequence[Result]) -> np.ndarray[Any, Any]:
    """Error over tolerance; an exact demand that is met is 0."""
    pairs = [(r.error, r.tolerance) for r in results]
    return np.array(
        [0.0 if error == 0.0 else error / tolerance if tolerance else np.inf for error, tolerance in pairs]
    )


def _blocks(check: Check, evidence: dict[str, Evidence], results: Sequence[Result]) -> list[Block]:
    """Return the problem of a check, its measurements, their references and pictures."""
    mine = [result for result in results if result.check == check.id]
    rows = [
        [
            Cell(r.id, "code"),
            r.quantity,
            # to the second digit of the tolerance, in nine digits or so at most
            *(
                Cell(number_within(value, max(r.tolerance, 1e-8 * abs(value))), "number")
                for value in (r.computed, r.reference)
            ),
            shown_unit(r.unit),
            *(cell(value, 2) for value in (r.error, r.tolerance)),
            Cell(r.verdict, r.verdict),
        ]
        for r in mine
    ]
    columns = ("id", "quantity", "computed", "reference", "unit", "error", "tolerance", "verdict")
    sources = list(dict.fromkeys(r.source for r in mine if r.source))
    reference = Text(f"Reference: {'; '.join(sources)}." if sources else "", note=True)
    return [Table(columns, rows, check.problem, wide=(1,)), reference, *evidence[check.id].pictures]
