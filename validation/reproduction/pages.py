"""The report: claims, figures, open choices, stick and why not, as one document."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import astuple
from itertools import chain
from math import isnan

from oblique_impact.validation.report.document import (
    MARKS,
    Block,
    Cell,
    Picture,
    Report,
    Section,
    Table,
    Text,
    number,
    number_cells,
)
from oblique_impact.validation.reproduction.cases import MODELS, SCHEMES
from oblique_impact.validation.reproduction.claims import NOT, PARTLY, REPRODUCED, moment
from oblique_impact.validation.reproduction.material import Material
from oblique_impact.validation.reproduction.motions import STICK
from oblique_impact.validation.reproduction.pictures import PLOTS
from oblique_impact.validation.reproduction.stick_pages import sticking_blocks
from oblique_impact.validation.reproduction.unsaid import CollisionRow, Studied

KINDS = {REPRODUCED: "pass", PARTLY: "partly", NOT: "fail"}

_CAPTIONS = {
    "lambda_tau": "Impulses of the impacts are not part of a force; the frictionless model has none.",
    "lambda_n": "Impulses of the impacts are not part of a force: they are in the table of runs.",
    "tip_x": "Inertial axes through O: the paper calls (X_F, Y_F) the position of P in the inertial system and "
    "gives O₁ in it, although its Sec. 2 names the floating axes OXY; those are in Figs. 10f to 13f.",
    "shortening": "If OXY means the floating axes: the foreshortening of the beam at P, zero before the impact.",
    "slip": "Position of P along the slope, measured from O₁.",
}


def document(material: Material, pictures: Mapping[str, str], times: Sequence[tuple[str, str]]) -> Report:
    """Put the report together."""
    return Report(
        "The paper's figures and claims, from our runs",
        "W. Yuan, L. Li, D. G. Zhang, J. Z. Hong: New method for oblique impact dynamics research of a flexible "
        "beam with large overall motion considering impact friction force. Acta Mechanica Sinica 32(4), 2016. "
        "Only the paper's text was available, not its curves: what it says is compared with what we compute.",
        facts=_assumptions(),
        times=times,
        overview=_overview(material),
        sections=[
            Section("Claims", _claims(material)),
            Section("Figures 2 to 16", _figures(pictures)),
            Section("What the paper leaves unsaid", _choices(material, pictures)),
            Section("All open choices at once", _robustness(material, pictures)),
            Section("Stick: where it can and cannot occur", sticking_blocks(material, pictures)),
            Section("The runs", _runs(material)),
            Section("Limits of this reproduction", _limits()),
        ],
    )


def _assumptions() -> list[tuple[str, str]]:
    return [
        (
            "as printed",
            "RK4, 0.1 ms in flight and 1 µs in contact, Baumgarte 10 and 1000, stick judged at each step",
        ),
        ("event-located", "the same equations, order 8, adaptive, every transition located in time"),
        (
            "assumed (*)",
            "two clamped modes, x_F = L, g = 9.8 m/s², Z'' + 2χZ' + β²Z = 0, v₀, v₁ = 0.001, 0.01 m/s",
        ),
    ]


def _overview(material: Material) -> list[Block]:
    judged = material.judged
    text = ", ".join(f"{count} {verdict}" for verdict, count in material.verdicts.items())
    missed = " ".join(judged_.claim.statement for judged_ in judged if judged_.verdict == NOT) or "none."
    return [
        Text(f"{len(judged)} claims: {text}."),
        Text(
            f"{material.undiscriminating} of them, marked =, do not discriminate: they are reproduced by all "
            f"{len(material.grid)} combinations of what the paper leaves open."
        ),
        Text(f"Not reproduced: {missed}"),
        Text(
            "Each claim is judged by a rule on numbers, once on the fixed-step runs (the algorithm as printed) "
            "and once on the event-located ones (the same equations, solved accurately). Reproduced means by "
            "both, not reproduced by neither, partly everything between. The last column of the claims counts "
            "how often each is reproduced / partly / not reproduced over all combinations of what the paper "
            "leaves open."
        ),
    ]


def _claims(material: Material) -> list[Block]:
    rows: list[list[Cell]] = []
    for place, judged in enumerate(material.judged, start=1):
        claim, counts = judged.claim, material.counts(judged.claim.id)
        found = [judged.findings[scheme] for scheme in SCHEMES]
        shown = "\u00a0/\u00a0".join(map(str, counts.values())) or "–"
        head = [*number_cells(place), Cell(f"{claim.statement} ({claim.place})")]
        texts = [Cell(f"{MARKS[KINDS[finding.verdict]]} {finding.text}") for finding in found]
        verdict = [Cell(claim.rule, "dim"), Cell(judged.verdict, KINDS[judged.verdict])]
        counted = number_cells(shown if material.discriminates(claim.id) else f"=\u00a0{shown}")
        rows.append([*head, *texts, *verdict, *counted])
    columns = ["", "the paper says", SCHEMES["fixed-step"], SCHEMES["event"], "rule", "verdict", "all choices"]
    caption = (
        "What the paper says, what we get (the sign says what each scheme finds), and by which rule it is judged; "
        "= marks claims that do not discriminate"
    )
    return [Table(columns, rows, caption, wide=(1, 2, 3, 4))]


def _figures(pictures: Mapping[str, str]) -> list[Block]:
    blocks: list[Block] = [
        Text(
            "The same scales for both schemes (except friction); a thick line for the hybrid model, so that the "
            "others show on top of it. What vibrates faster than a picture can show is drawn as the range of its "
            "values with their mean in it. Figures with a letter are additions: enlargements (a) and floating "
            "axes (f)."
        )
    ]
    for plot in PLOTS:
        caption = f"Fig. {plot.number}. {plot.title} ({plot.unit}). {_CAPTIONS.get(plot.variable, '')}".strip()
        alternative = f"{plot.title} of the three models over time, fixed-step above, event-located below"
        blocks.append(Picture(pictures[plot.name], caption, alternative, half=True))
    return blocks


def _choices(material: Material, pictures: Mapping[str, str]) -> list[Block]:
    blocks: list[Block] = [
        Text(
            "One choice is changed at a time; * marks what we assume elsewhere. Bars are stays in contact (the "
            "upper one fixed-step, the lower one event-located), ticks are rebounds, dots reversals of slip."
        ),
        Picture(pictures["choices"], "The first and the second macro-collision for every value of every choice."),
    ]
    for choice in dict.fromkeys(item.variant.choice for item in material.studied):
        title = f"{choice[:1].upper()}{choice[1:]}"
        blocks.append(Text(f"{title}. {_effect(material.studied, choice)}"))
        blocks.append(_choice_table([item for item in material.studied if item.variant.choice == choice], title))
    return blocks


def _choice_table(studied: Sequence[Studied], title: str) -> Table:
    each = ["from (s)", "to (s)", "impulse (N s)", "reversal (s)", "stick (µs)"]
    columns = ["value", "scheme", *(f"{n}: {name}" for n in (1, 2) for name in each)]
    rows = [
        [Cell(item.label), Cell(item.scheme, "dim"), *chain(*map(_collision_cells, item.collisions))]
        for item in studied
    ]
    model = studied[0].run.scenario.contact.friction
    return Table(columns, rows, f"{title}; {model} model; 1, 2: macro-collisions")


def _collision_cells(row: CollisionRow) -> list[Cell]:
    start, end, reversal = (moment(time).removesuffix(" s") for time in (row.start, row.end, row.reversal))
    return number_cells(start, end, number(row.normal_impulse, 4), reversal, number(1e6 * row.stick_time, 3))


def _effect(studied: Sequence[Studied], choice: str) -> str:
    """Say what a choice does to both macro-collisions, in numbers."""
    parts = []
    for scheme in dict.fromkeys(item.scheme for item in studied if item.variant.choice == choice):
        rows = [item for item in studied if item.variant.choice == choice and item.scheme == scheme]
        if len(rows) < 2:
            continue
        impulse = [item.collisions[0].normal_impulse for item in rows]
        second = [item.collisions[1].start for item in rows if item.collisions[1].contacts]
        parts.append(
            f"{scheme}: impulse of the first collision {number(min(impulse), 4)} to {number(max(impulse), 4)} N "
            f"s, second collision from {moment(min(second))} to {moment(max(second))}"
        )
    return f"{'; '.join(parts)}." if parts else ""


def _robustness(material: Material, pictures: Mapping[str, str]) -> list[Block]:
    grid = material.grid
    inside = sum(point.second[0] <= STICK <= point.second[1] for point in grid)
    long = [point for point in grid if point.second[3] >= 1e-4]
    # a combination without a second collision (NaN) is the farthest
    nearest = min(grid, key=lambda p: (isnan(p.second[0]), max(p.second[0] - STICK, STICK - p.second[1], 0.0)))
    stick = f"stays judged as stick of 0.1 ms or more occur in it in {len(long)} of the combinations"
    if long:
        stick += f", the latest from {moment(max(point.second[2] for point in long))}"
    return [
        Text(
            f"{len(grid)} combinations: 1 to 4 clamped modes, g = 9.8 and 9.81 m/s², with and without the contact "
            "point's shortening, both forms of Baumgarte's equation (fixed-step only), both schemes; three models "
            f"each. In {inside} of them the second macro-collision is under way at 0.699 s (nearest: "
            f"{nearest.combination.label}, {moment(nearest.second[0])} to {moment(nearest.second[1])}); {stick}."
        ),
        Picture(pictures["robustness"], "How many combinations of open choices give which verdict."),
    ]


def _runs(material: Material) -> list[Block]:
    collisions, ledgers = [], []
    for scheme, trio in material.trios.items():
        for model, run in zip(MODELS, trio, strict=True):
            name = [Cell(f"{model}, {scheme}")]
            for k, macro in enumerate(run.macros, start=1):
                start, end, contacts, *rest = astuple(macro)
                cells = number_cells(k, f"{start:.6f}", f"{end:.6f}", contacts, *rest, digits=5)
                collisions.append([*name, *cells])
            ledgers.append([*name, *number_cells(*(run.energy[key] for key in _LEDGER), digits=5)])
    return [
        Table(
            ["run", "no.", "from (s)", "to (s)", "contacts", "normal (N s)", "friction (N s)", "peak (N)"],
            collisions,
            "Macro-collisions: contacts less than 0.03 s apart; impulses include those of the impacts",
        ),
        Table(
            ["run", *(key.replace("_", " ") for key in _LEDGER)],
            ledgers,
            "Energy ledger (J); lost scheme is the work of Baumgarte's terms, negative where they push a tip "
            "out that was noticed below the slope",
        ),
    ]


_LEDGER = ("initial", "final", "lost_impact", "lost_friction", "lost_scheme", "unaccounted")


def _limits() -> list[Block]:
    return [
        Text(
            "The fixed-step algorithm notices a contact up to one free step late, 0.4 mm below the slope; its "
            "Baumgarte terms then push the tip out and do work on the beam. From the second macro-collision on, "
            "the results of the printed step sizes are shaped by that: compare the integrators, and the column "
            "lost scheme."
        ),
        Text(
            "With a rigid stop nothing after the first macro-collision converges as modes are added: agreement "
            "or disagreement at 0.699 s depends on the number of modes, which the paper does not give. A "
            "statement about the second macro-collision is one about a discretized beam."
        ),
        Text(
            "No run can decide whether the hybrid model is more consistent with real movement, or whether its "
            "motion switch is: that takes a measurement."
        ),
    ]
