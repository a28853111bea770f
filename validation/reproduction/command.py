"""The paper's figures and claims as a call, `reproduce`, and as the command `oblique-impact reproduce`."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Sequence
from contextlib import nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from oblique_impact.errors import InputError
from oblique_impact.files import prepare_folder, writing
from oblique_impact.progress import OnProgress, silent
from validation.parallel import map_parallel, told
from validation.report.document import write_csv, write_file, write_json, write_report
from validation.report.provenance import call_text
from validation.reproduction.cases import (
    MODELS,
    SCHEMES,
    Case,
    Combination,
    case_key,
    combinations,
    main_cases,
    sticking_cases,
    threshold_cases,
    variant_cases,
)
from validation.reproduction.claims import VERDICTS, Judged, judge
from validation.reproduction.material import Drawings, Material
from validation.reproduction.measures import Trio
from validation.reproduction.pages import document
from validation.reproduction.pictures import PLOTS, Plot, draw, summary
from validation.reproduction.runs import Run, run_case, run_contact
from validation.reproduction.tables import CLAIM_COLUMNS, claim_rows, results
from validation.reproduction.unsaid import Robustness, all_claims, judge_combination, study

Task = tuple[str, Any]


@dataclass(frozen=True)
class Reproduction:
    """What came of the paper's claims and figures.

    Attributes
    ----------
    material : Material
        All runs, verdicts, variants and combinations of choices.
    seconds : float
        Wall time (s) of the simulations.
    report : Path or None
        The page, if one was written.
    """

    material: Material
    seconds: float
    report: Path | None = None

    @property
    def claims(self) -> Sequence[Judged]:
        """The paper's claims, each with what either scheme found and a verdict."""
        return self.material.judged

    @property
    def verdicts(self) -> dict[str, int]:
        """How many claims have which verdict: "reproduced", "partly", "not reproduced"."""
        return {verdict: sum(judged.verdict == verdict for judged in self.claims) for verdict in VERDICTS}


def reproduce(
    out: str | os.PathLike[str] | None = None,
    workers: int | None = None,
    on_progress: OnProgress = silent,
    command: str | None = None,
) -> Reproduction:
    """Run the paper's cases and judge its claims.

    Parameters
    ----------
    out : path, optional
        Folder for report.html, results.json, claims.csv, sensitivity.csv, figures.csv and, in figures/, the
        pictures of figures 2 to 16; without it nothing is drawn or written.
    workers : int, optional
        Parallel processes; default: the cores.  With one, everything runs in this process.
    on_progress : callable, optional
        Called with a :class:`~oblique_impact.progress.Progress` before the first and after each run.
    command : str, optional
        How to repeat it, for the report; default: this call.

    Returns
    -------
    Reproduction
        Claims with their verdicts, and the runs that they are judged by.

    Raises
    ------
    InputError
        In one line, before anything runs, if the folder cannot be written.

    Examples
    --------
    >>> from validation import reproduce
    >>> result = reproduce(out="out/reproduce")  # doctest: +SKIP
    >>> result.verdicts  # doctest: +SKIP
    {'reproduced': 19, 'partly': 9, 'not reproduced': 3}
    """
    with nullcontext() if out is None else writing(out) as folder:
        if folder is not None:
            _prepare_figures(folder)
        started = time.perf_counter()
        material = collect(workers, on_progress)
        computed = time.perf_counter() - started
        if folder is None:
            return Reproduction(material, computed)
        drawings = make_drawings(material)
        times = [
            ("command", command or call_text("reproduce", out=os.fspath(folder), workers=workers)),
            ("simulations", f"{computed:.1f} s"),
            ("figures", f"{time.perf_counter() - started - computed:.1f} s"),
        ]
        write_all(folder, material, drawings, times)
        return Reproduction(material, computed, folder / "report.html")


def lines(result: Reproduction) -> list[str]:
    """Return the verdicts in lines, for a terminal."""
    verdicts = ", ".join(f"{count} {verdict}" for verdict, count in result.verdicts.items())
    told = [f"  {judged.verdict:15s} {judged.claim.id}" for judged in result.claims]
    same = (
        f"{result.material.undiscriminating} of them reproduced by all combinations of what the paper leaves open"
    )
    return [*told, f"{len(result.claims)} claims: {verdicts}; {same}; report: {result.report}"]


def _prepare_figures(folder: Path) -> None:
    place = folder / "figures"
    if place.is_symlink():
        raise InputError(f"--out {folder}: figures leads elsewhere; the report is written into its folder only")
    prepare_folder(place)


def work(task: Task) -> Any:
    """Do one task of the pool: a run, a run of which only the contact is kept, or a combination of choices."""
    kind, what = task
    tasks: dict[str, Callable[[Any], Any]] = {
        "run": run_case,
        "contact": run_contact,
        "combination": judge_combination,
    }
    return tasks[kind](what)


def collect(workers: int | None, on_progress: OnProgress = silent) -> Material:
    """Run every simulation and judge the claims."""
    named = [*main_cases(), *sticking_cases()]
    varied = list(variant_cases())
    grid = combinations()
    tasks: list[Task] = [
        *(("run", case) for case in named),
        *(("combination", combination) for combination in grid),
        *(("contact", case) for _, _, case in varied),
    ]
    results = map_parallel(work, tasks, workers, told(on_progress, [_name(task) for task in tasks]))
    runs: dict[str, Run] = {run.key: run for run in results[: len(named)]}
    points: list[Robustness] = results[len(named) : len(named) + len(grid)]
    studied = [
        study(variant, scheme, run)
        for (variant, scheme, _), run in zip(varied, results[len(named) + len(grid) :], strict=True)
    ]
    trios = {group: _trios(runs, group) for group in ("paper", "sticking", "rough")}
    judged = judge(all_claims(), trios)
    return Material(trios["paper"], runs, judged, studied, points, _threshold(runs["paper/event/hybrid"]))


def _name(task: Task) -> str:
    what: Case | Combination = task[1]
    return what.key if isinstance(what, Case) else what.label


def _trios(runs: dict[str, Run], group: str) -> dict[str, Trio]:
    """Return the three models by scheme; where friction is the point there is no frictionless run."""
    found = {}
    for scheme in SCHEMES:
        keys = [case_key(group, scheme, model) for model in MODELS]
        found[scheme] = Trio(*(runs.get(key, runs[keys[0]]) for key in keys))
    return found


def _threshold(run: Run) -> tuple[float, list[tuple[float, str]]]:
    """Try static coefficients around what the first reversal asks for: (ratio, (coefficient, what happened))."""
    first = next(check for check in run.checks if check.kind == "reversal")
    outcomes = []
    for case in threshold_cases(first.ratio):
        tried = run_case(case)
        check = min(tried.checks, key=lambda c: abs(c.time - first.time))
        outcomes.append((float(case.scenario.contact.mu_static), f"{check.kind} at {check.time:.6f} s"))
    return first.ratio, outcomes


def make_drawings(material: Material, plots: Sequence[Plot] = PLOTS) -> Drawings:
    """Draw every picture."""
    from validation.reproduction.diagrams import (
        choices_diagram,
        robustness_diagram,
        sticking_diagram,
    )

    studied, runs = material.studied, material.runs
    return Drawings(
        [(plot, draw(plot, material.trios)) for plot in plots],
        choices_diagram(studied),
        robustness_diagram(material),
        {
            name: sticking_diagram(runs[key], _windows(runs[key], name), title)
            for name, key, title in _STICKING_DIAGRAMS
        },
    )


_STICKING_DIAGRAMS = (
    ("event", "paper/event/hybrid", "The paper's case, event-located"),
    ("fixed-step", "paper/fixed-step/hybrid", "The paper's case, fixed-step as printed"),
    ("no-shortening", "no-shortening/fixed-step/hybrid", "Fixed-step, shortening of the contact point left out"),
    ("sticking", "sticking/event/hybrid", "Scenario sticking"),
    ("rough", "rough/event/hybrid", "The paper's slope, μ = 12"),
)


def _windows(run: Run, name: str) -> list[tuple[float, float]]:
    """Windows (s) that show the macro-collisions of a run; half a page has room for one."""
    if name == "sticking":
        return [(run.macros[0].start - 0.02, run.macros[0].start + 0.2)]
    macros = run.macros[:1] if name == "rough" else run.macros[:2]
    return [(macro.start - 7e-4, min(macro.end, macro.start + 0.03) + 7e-4) for macro in macros]


def write_all(folder: Path, material: Material, drawings: Drawings, times: Sequence[tuple[str, str]]) -> None:
    """Write the page, the tables and the pictures; each file appears whole or not at all."""
    figures = [row for plot, _ in drawings.figures for row in summary(plot, material.trios)]
    sensitivity = [item.flat() for item in material.studied]
    write_report(folder, document(material, drawings, times))
    write_json(folder, "results.json", results(material, figures))
    write_csv(folder, "claims.csv", CLAIM_COLUMNS, claim_rows(material))
    write_csv(folder, "sensitivity.csv", list(sensitivity[0]), [list(row.values()) for row in sensitivity])
    write_csv(folder, "figures.csv", list(figures[0]), [list(row.values()) for row in figures])
    pictures = {plot.name: svg for plot, svg in drawings.figures}
    pictures |= {"choices": drawings.choices, "robustness": drawings.robustness}
    pictures |= {f"sticking-{name}": svg for name, svg in drawings.sticking.items()}
    for name, svg in pictures.items():
        write_file(folder / "figures" / f"{name}.svg", svg)
