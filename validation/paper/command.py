"""The call `reproduce`, behind `oblique-impact reproduce`: figures, claims with their verdicts, and the report."""

from __future__ import annotations

import os
import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd

from oblique_impact.files import save_text, writing
from oblique_impact.history.history import History
from oblique_impact.progress import OnProgress, silent
from oblique_impact.scenario.scenario import Scenario
from oblique_impact.validation.paper import measures
from oblique_impact.validation.paper.figures import PLOTS, draw
from oblique_impact.validation.paper.measures import MODELS, NAN, SCHEMES, Models
from oblique_impact.validation.paper.rules import CLAIMS, NOT, PARTLY, REPRODUCED, VERDICTS
from oblique_impact.validation.report import MARKS, Block, Cell, Report, Section, Table, Text, listed
from oblique_impact.validation.report.parameters import differing, parameters
from oblique_impact.validation.studies.parallel import map_parallel
from oblique_impact.validation.studies.study import same_warnings

#: s of one core that the runs and figures take on a fast machine
SECONDS = 150.0
#: kinds of cells of the report
_KINDS = {REPRODUCED: "pass", PARTLY: "partly", NOT: "fail"}


@dataclass(frozen=True, repr=False)
class Reproduction:
    """The paper's claims with their verdicts, and the runs behind them.

    Attributes
    ----------
    claims : DataFrame
        A row for each claim: `id`, `place`, `paper` and `rule` in words; `verdict`, "reproduced" if by both
        schemes, "not reproduced" if by neither, else "partly"; for each scheme `verdict_...` and `ours_...`, what
        it found; how many combinations of open choices give which verdict, `combinations_...`, None for claims on
        other cases than the paper's; `discriminates`, whether some of them does not reproduce it.
    runs : dict
        Histories by group/scheme/model, without what varies along the beam.
    combinations : DataFrame
        What each combination of open choices does to the second macro-collision (SI units), and the verdict of
        each claim by its id.
    seconds : float
        Wall time (s) of the simulations.
    """

    claims: pd.DataFrame
    runs: dict[str, History]
    combinations: pd.DataFrame
    seconds: float

    def __repr__(self) -> str:
        """Return how many claims have which verdict."""
        return f"<Reproduction: {self.counts}>"

    def _repr_html_(self) -> str:
        """Show the claims in a notebook."""
        return Report(_TITLE, _LEAD, overview=_overview(self))._repr_html_()

    def to_dataframe(self) -> pd.DataFrame:
        """Return a row for each claim: `claims`."""
        return self.claims

    @property
    def verdicts(self) -> dict[str, int]:
        """Number of claims of each verdict: "reproduced", "partly", "not reproduced"."""
        found = self.claims["verdict"].tolist()
        return {verdict: found.count(verdict) for verdict in VERDICTS}

    @property
    def counts(self) -> str:
        """The same in words."""
        counted = ", ".join(f"{count} {verdict}" for verdict, count in self.verdicts.items())
        return f"{len(self.claims)} claims: {counted}"

    @property
    def undiscriminating(self) -> int:
        """Number of claims that every combination of open choices reproduces."""
        return int((~self.claims["discriminates"].astype(bool)).sum())


def reproduce(
    out: str | os.PathLike[str] | None = None,
    workers: int | None = None,
    on_progress: OnProgress = silent,
) -> Reproduction:
    """Run the paper's cases and judge its claims.

    Parameters
    ----------
    out : path, optional
        Folder for report.html, results.json, claims.csv, combinations.csv and, in figures/, figures 2 to 16;
        without it nothing is drawn or written.
    workers : int, optional
        Parallel processes; default: the cores.  With one, everything runs in this process.
    on_progress : callable, optional
        Called with a :class:`~oblique_impact.progress.Progress` before the first and after each run.

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
    >>> from oblique_impact.validation import reproduce
    >>> result = reproduce(out="out/reproduce")  # doctest: +SKIP
    >>> result.verdicts  # doctest: +SKIP
    {'reproduced': 19, 'partly': 9, 'not reproduced': 3}
    """
    started = time.perf_counter()
    named, grid = measures.cases(), measures.combinations()
    tasks: list[Scenario | dict[str, Any]] = [*named.values(), *grid]
    with writing(out):
        found: list[Any] = map_parallel(_compute, tasks, workers, on_progress, [*named, *map(str, grid)])
        runs: dict[str, History] = dict(zip(named, found, strict=False))
        combined = pd.DataFrame(found[len(named) :])
        result = Reproduction(judge_claims(runs, combined), runs, combined, time.perf_counter() - started)
        if out is not None:
            write_report(result, Path(out))
    return result


def judge_claims(runs: Mapping[str, History], combined: pd.DataFrame) -> pd.DataFrame:
    """Judge each claim on the runs of its case; `combined` has its verdict in each combination, by its id."""
    rows = []
    for claim in CLAIMS:
        row = {name: getattr(claim, name) for name in ("id", "place", "paper", "rule")} | {"verdict": PARTLY}
        for scheme in SCHEMES:
            keys = [f"{claim.case}/{scheme}/{model}" for model in MODELS]
            # where friction is the point there is no frictionless run
            found = claim.judge(Models(*(runs.get(key, runs[keys[0]]) for key in keys)))
            suffix = scheme.replace("-", "_")
            row[f"verdict_{suffix}"], row[f"ours_{suffix}"] = found
        if row["verdict_fixed_step"] == row["verdict_event"]:
            row["verdict"] = row["verdict_event"]
        judged = list(combined.get(claim.id, []))
        for verdict in VERDICTS:
            row[f"combinations_{verdict.replace(' ', '_')}"] = judged.count(verdict) if judged else None
        row["discriminates"] = not judged or judged.count(REPRODUCED) < len(judged)
        rows.append(row)
    return pd.DataFrame(rows, dtype=object)


def lines(result: Reproduction) -> list[str]:
    """Return the verdicts in lines, for a terminal."""
    shown = [f"  {claim.verdict:15s} {claim.id}" for claim in result.claims.itertuples()]
    same = f"{result.undiscriminating} of them reproduced by all combinations of what the paper leaves open"
    return [*shown, f"{result.counts}; {same}"]


def _compute(task: Scenario | dict[str, Any]) -> History | dict[str, Any]:
    """Return the run of a scenario; of a combination of choices its second macro-collision and verdicts."""
    if isinstance(task, Scenario):
        return measures.run_light(task)
    models = Models(*(measures.run_light(measures.paper(model=model, **task)) for model in MODELS))
    second = next(iter(measures.collisions(models.hybrid)[1:2]), (NAN, NAN))
    start, duration = measures.longest(measures.sticks(models.hybrid, second))
    return {
        **{name.rpartition("__")[2]: value for name, value in task.items()},
        "second_start": second[0],
        "second_end": second[1],
        "longest_stick_start": start,
        "longest_stick": duration,
        **{claim.id: claim.judge(models)[0] for claim in CLAIMS if claim.case == "paper"},
    }


# --- report


def write_report(result: Reproduction, folder: Path) -> None:
    """Write report.html, results.json, claims.csv, combinations.csv and the figures.

    Raises InputError if a file cannot be written.
    """
    claims, grid = result.claims, result.combinations
    schemes = {scheme: Models(*(result.runs[f"paper/{scheme}/{model}"] for model in MODELS)) for scheme in SCHEMES}
    pictures = {plot.number: draw(plot, schemes) for plot in PLOTS}
    for figure, picture in pictures.items():
        save_text(folder / "figures" / f"fig{figure:02d}.svg", picture.svg)
    for name, frame in (("claims", claims), ("combinations", grid)):
        save_text(folder / f"{name}.csv", frame.to_csv(index=False, lineterminator="\n"))
    page = Report(
        _TITLE,
        _LEAD,
        result.seconds,
        facts=_ASSUMED,
        overview=_overview(result),
        sections=[
            Section("Figures 2 to 16", [Text(_ABOUT_FIGURES), *pictures.values()]),
            Section("What the paper leaves open", [_choices(grid)]),
            Section("The runs", _runs(result)),
            *parameters(_scenarios(result)),
            Section("Stick, and the limits of this reproduction", [Text(text) for text in _LIMITS]),
        ],
    )
    runs = {
        key: {
            "outcome": run.outcome.label,
            "macro_collisions": run.macro_collisions,
            "energy": run.balance,
            "warnings": run.summary["warnings"],
            "scenario": run.scenario,
        }
        for key, run in result.runs.items()
    }
    page.write(folder, {"claims": claims, "combinations": grid, "runs": runs})


def _overview(result: Reproduction) -> list[Block]:
    """Return what was found, and the table of the claims."""
    claims = result.claims
    missed = " ".join(claims["paper"][claims["verdict"] == NOT]) or "none."
    return [
        Text(
            f"{result.counts}. {result.undiscriminating} of them, marked =, do not discriminate: all "
            f"{len(result.combinations)} combinations of open choices reproduce them."
        ),
        Text(f"Not reproduced: {missed}"),
        Text(_RULES),
        _claims(claims),
    ]


def _scenarios(result: Reproduction) -> dict[str, Scenario | None]:
    """Return the scenarios of the paper's case by scheme/model."""
    names = {key: key.removeprefix("paper/") for key in result.runs if key.startswith("paper/")}
    return {name: result.runs[key].scenario for key, name in names.items()}


def _claims(claims: pd.DataFrame) -> Table:
    rows = []
    for place, claim in enumerate(claims.to_dict("records"), start=1):
        found = [(claim[f"verdict_{name}"], claim[f"ours_{name}"]) for name in ("fixed_step", "event")]
        counts = [claim[f"combinations_{verdict.replace(' ', '_')}"] for verdict in VERDICTS]
        counted = "–" if counts[0] is None else "\u00a0/\u00a0".join(map(str, counts))
        rows.append(
            [
                place,
                f"{claim['paper']} ({claim['place']})",
                *(f"{MARKS[_KINDS[verdict]]} {text}" for verdict, text in found),
                Cell(claim["rule"], "dim"),
                Cell(claim["verdict"], _KINDS[claim["verdict"]]),
                Cell(counted if claim["discriminates"] else f"=\u00a0{counted}", "number"),
            ]
        )
    columns = ["", "the paper says", *SCHEMES.values(), "rule", "verdict", "all choices"]
    caption = "The sign says what each scheme finds; = marks claims that do not discriminate"
    return Table(columns, rows, caption, wide=(1, 2, 3, 4))


def _choices(grid: pd.DataFrame) -> Table:
    """Return what becomes of the second macro-collision in all combinations of open choices."""
    verdicts = grid.filter([claim.id for claim in CLAIMS])
    shown = grid.drop(columns=verdicts.columns).assign(claims_reproduced=(verdicts == REPRODUCED).sum(axis=1))
    shown["shortening"] = shown["shortening"].map({True: "in gap and slip", False: "left out"})
    times = ("second_start", "second_end", "longest_stick_start", "longest_stick")
    shown.attrs["units"] = dict.fromkeys(times, "s") | {"gravity": "m/s²"}
    headings = {name: name.replace("_", " ") for name in shown}
    caption = (
        "All combinations, three models each (Baumgarte's form matters to fixed steps only): the second "
        "macro-collision, the longest stick in it, claims reproduced"
    )
    return Table.of_frame(shown, caption, digits=4, columns=headings)


def _runs(result: Reproduction) -> list[Block]:
    runs = {name: result.runs[f"paper/{name}"] for name in _scenarios(result)}
    macros = pd.DataFrame({"run": key, **macro} for key, run in runs.items() for macro in run.macro_collisions)
    macros.attrs["units"] = {"start": "s", "end": "s", "peak_force": "N"}
    macros.attrs["units"] |= {"normal_impulse": "N s", "tangential_impulse": "N s"}
    ledgers = pd.DataFrame({"run": key, **run.balance} for key, run in runs.items())
    shown = ("run", "initial", "final", "lost_impact", "lost_friction", "lost_scheme", "unaccounted")
    warned = same_warnings((name, "\n".join(run.summary["warnings"])) for name, run in runs.items())
    about = (
        "what the scheme takes is the work of Baumgarte's terms, negative where they push a tip out of the slope"
    )
    return [
        differing(_scenarios(result)),
        Table.of_frame(macros, "Macro-collisions: contacts less than 0.03 s apart, impacts included", digits=5),
        Table.of_frame(ledgers[[*shown]], f"Energy balance (J); {about}", digits=4),
        Table(["warning", "runs"], [[text, listed(found)] for text, found in warned], "Warnings.", wide=(0, 1)),
    ]


_TITLE = "The paper's figures and claims, from our runs"
_LEAD = (
    "W. Yuan, L. Li, D. G. Zhang, J. Z. Hong: New method for oblique impact dynamics research of a flexible beam "
    "with large overall motion considering impact friction force. Acta Mechanica Sinica 32(4), 2016. Only the "
    "paper's text was available, not its curves: what it says is compared with what we compute."
)
_ASSUMED = [
    ("as printed", "RK4, 0.1 ms in flight and 1 µs in contact, Baumgarte 10 and 1000, stick judged at each step"),
    ("event-located", "the same equations, order 8, adaptive, every transition located in time"),
    ("assumed", "two clamped modes, x_F = L, g = 9.8 m/s², Z'' + 2χZ' + β²Z = 0, v₀, v₁ = 0.001, 0.01 m/s"),
]
_RULES = (
    "Each claim is judged by its rule on the runs of both schemes. Reproduced means by both, not reproduced by "
    "neither, partly everything between. The last column of the claims counts how often each is reproduced / "
    "partly / not reproduced over all combinations of what the paper leaves open."
)
_ABOUT_FIGURES = (
    "The same scales for both schemes (except friction). What vibrates faster than a picture can show is drawn as "
    "the range of its values with their mean in it."
)
_LIMITS = (
    "The tip sticks at an instant if its slip velocity is 0, and the forces that would hold it (the solution of "
    "both constraints) push, λn > 0, and lie in the friction cone, |λτ|/λn ≤ μ_s. A beam that does not stretch "
    "can move its tip only across the line from the pin, so a contact that holds the tip acts along that line: "
    "with an angle b between line and slope |λτ|/λn is about cot|b|, 10.7 here, against μ = 0.3. The algorithm "
    "as printed judges by the forces alone (Sec. 5.3) and finds stick where the slip velocity passes an extreme, "
    "though the tip does not rest then.",
    "The fixed-step algorithm notices a contact up to one free step late, 0.4 mm below the slope; its Baumgarte "
    "terms then push the tip out and do work on the beam. From the second macro-collision on, that "
    "shapes the results of the printed step sizes.",
    "With a rigid stop nothing after the first macro-collision converges as modes are added: agreement or "
    "disagreement at 0.699 s depends on the number of modes, which the paper does not give.",
    "No run can decide whether the hybrid model is more consistent with real movement, or whether its motion "
    "switch is: that takes a measurement.",
)
