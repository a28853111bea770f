"""The paper's figures and claims as a call, `reproduce`, and as the command `oblique-impact reproduce`."""

from __future__ import annotations

import os
import time
from collections.abc import Mapping, Sequence
from contextlib import nullcontext
from dataclasses import dataclass
from pathlib import Path

from oblique_impact.files import prepare_folder, writing
from oblique_impact.progress import OnProgress, silent
from oblique_impact.validation.report.document import write_csv, write_file, write_json
from oblique_impact.validation.reproduction.cases import (
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
from oblique_impact.validation.reproduction.claims import Judged
from oblique_impact.validation.reproduction.diagrams import choices_diagram, robustness_diagram, sticking_diagram
from oblique_impact.validation.reproduction.material import Material
from oblique_impact.validation.reproduction.measures import Trio
from oblique_impact.validation.reproduction.pages import document
from oblique_impact.validation.reproduction.pictures import PLOTS, draw, summary
from oblique_impact.validation.reproduction.runs import Run, run_case
from oblique_impact.validation.reproduction.stick_pages import STICKING
from oblique_impact.validation.reproduction.tables import CLAIM_COLUMNS, claim_rows, results
from oblique_impact.validation.reproduction.unsaid import ALL_CLAIMS, Robustness, Studied, judge_combination
from oblique_impact.validation.studies.parallel import map_parallel

#: s of one core that the runs and figures take on a fast machine
SECONDS = 200.0


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
        return self.material.verdicts


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
            prepare_folder(folder / "figures")
        started = time.perf_counter()
        material = collect(workers, on_progress)
        computed = time.perf_counter() - started
        if folder is None:
            return Reproduction(material, computed)
        pictures = draw_all(material)
        times = [
            ("command", command or ""),
            ("simulations", f"{computed:.1f} s"),
            ("figures", f"{time.perf_counter() - started - computed:.1f} s"),
        ]
        write_all(folder, material, pictures, times)
        return Reproduction(material, computed, folder / "report.html")


def lines(result: Reproduction) -> list[str]:
    """Return the verdicts in lines, for a terminal."""
    verdicts = ", ".join(f"{count} {verdict}" for verdict, count in result.verdicts.items())
    shown = [f"  {judged.verdict:15s} {judged.claim.id}" for judged in result.claims]
    same = (
        f"{result.material.undiscriminating} of them reproduced by all combinations of what the paper leaves open"
    )
    return [*shown, f"{len(result.claims)} claims: {verdicts}; {same}; report: {result.report}"]


def compute(what: Case | Combination) -> Run | Robustness:
    """Do one task of the pool."""
    return run_case(what) if isinstance(what, Case) else judge_combination(what)


def collect(workers: int | None, on_progress: OnProgress = silent) -> Material:
    """Run every simulation and judge the claims."""
    varied, grid = list(variant_cases()), combinations()
    cases = [*main_cases(), *sticking_cases(), *(case for _, _, case in varied)]
    tasks: list[Case | Combination] = [*cases, *grid]
    names = [what.key if isinstance(what, Case) else what.label for what in tasks]
    found = map_parallel(compute, tasks, workers, on_progress, names)
    every: dict[str, Run] = {run.key: run for run in found if isinstance(run, Run)}
    points = [point for point in found if isinstance(point, Robustness)]
    studied = [Studied(variant, scheme, every[case.key]) for variant, scheme, case in varied]
    runs = {case.key: every[case.key] for case in cases[: len(cases) - len(varied)]}
    trios = {group: _trios(runs, group) for group in ("paper", "sticking", "rough")}
    judged = [
        Judged(claim, {scheme: claim.judge(trio) for scheme, trio in trios[claim.case].items()})
        for claim in ALL_CLAIMS
    ]
    return Material(trios["paper"], runs, judged, studied, points, _threshold(runs["paper/event/hybrid"]))


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


def draw_all(material: Material) -> dict[str, str]:
    """Draw every picture; SVG texts by the name of the file."""
    pictures = {plot.name: draw(plot, material.trios) for plot in PLOTS}
    pictures |= {"choices": choices_diagram(material.studied), "robustness": robustness_diagram(material)}
    for name, (key, title, _) in STICKING.items():
        run = material.runs[key]
        pictures[f"sticking-{name}"] = sticking_diagram(run, _windows(run, name), title)
    return pictures


def _windows(run: Run, name: str) -> list[tuple[float, float]]:
    """Windows (s) that show the macro-collisions of a run; half a page has room for one."""
    if name == "sticking":
        return [(run.macros[0].start - 0.02, run.macros[0].start + 0.2)]
    macros = run.macros[:1] if name == "rough" else run.macros[:2]
    return [(macro.start - 7e-4, min(macro.end, macro.start + 0.03) + 7e-4) for macro in macros]


def write_all(
    folder: Path, material: Material, pictures: Mapping[str, str], times: Sequence[tuple[str, str]]
) -> None:
    """Write the page, the tables and the pictures; each file appears whole or not at all."""
    figures = [row for plot in PLOTS for row in summary(plot, material.trios)]
    sensitivity = [item.flat() for item in material.studied]
    document(material, pictures, times).write(folder)
    write_json(folder / "results.json", results(material, figures))
    write_csv(folder / "claims.csv", CLAIM_COLUMNS, claim_rows(material))
    write_csv(folder / "sensitivity.csv", list(sensitivity[0]), [list(row.values()) for row in sensitivity])
    write_csv(folder / "figures.csv", list(figures[0]), [list(row.values()) for row in figures])
    for name, svg in pictures.items():
        write_file(folder / "figures" / f"{name}.svg", svg)
