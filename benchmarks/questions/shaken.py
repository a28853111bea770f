"""A shaken strip, 2 mm from a stop; its first frequency is 13.37 Hz."""

from __future__ import annotations

import numpy as np

from questions.independent import Beam, shake
from questions.question import Question, Row, run

_STRIP = Beam(
    length=0.25,
    mass=7850.0 * 2e-5,
    stiffness=2.1e11 * 1.6666666666666667e-12,
    kelvin_voigt=2.4e-4,
    clamped=True,
    elements=32,
    modes=6,
)
_REST = """\
oblique-impact run shaken --set gravity=0 --set base.frequency=16 --set end_time=4 --out out/rest"""
_SWEPT = """\
oblique-impact run shaken --set gravity=0 --set base.frequency=15 --set base.sweep_rate=0.25 --set end_time=10 \\
    --set solver.output_interval=2.5e-4 --out out/swept"""


def _row(case: str, frequency: float, sweep: float, end: float) -> Row:
    keys = (f"base.frequency={frequency}", f"base.sweep_rate={sweep}", f"end_time={end}")
    history = run(_SWEPT, *keys) if sweep else run(_REST, keys[0], keys[2])
    other = shake(_STRIP, 5e3, 0.002, 2.0, frequency, sweep, end)
    swing = 1e3 * float(np.abs(history["deflection"].values).max())
    values: dict[str, tuple[float | None, float | None]] = {"largest swing (mm)": (swing, 1e3 * other.swing)}
    if other.contacts and history.contacts:
        values["last contact at (s)"] = history.contacts[-1].start, other.contacts[-1]
    return Row(case, values)


def swing() -> list[Row]:
    """At the resonance, above it, and swept slowly upwards."""
    return [
        _row("13.37 Hz, 4 s", 13.37, 0.0, 4.0),
        _row("15.5 Hz, 4 s", 15.5, 0.0, 4.0),
        _row("15 to 17.5 Hz in 10 s", 15.0, 0.25, 10.0),
    ]


def rest() -> list[Row]:
    """From rest below, at and above 16 Hz."""
    return [_row(f"{hertz:g} Hz, 4 s", hertz, 0.0, 4.0) for hertz in (15.5, 16.0, 16.5)]


_BESIDE = "six clamped modes over a one-sided spring, in SciPy (`benchmarks/questions/independent.py`)"

QUESTIONS = [
    Question(
        name="swing",
        title="A shaken strip beside a stop on one side: where is its swing largest?",
        guess="at its own frequency, 13.37 Hz, where the stop limits it",
        answer="far above: {0[largest swing (mm)]:.1f} mm there, {1[largest swing (mm)]:.1f} mm at 15.5 Hz, "
        "{2[largest swing (mm)]:.1f} mm in a slow sweep, which strikes up to 17.2 Hz",
        wrong=True,
        cost=35,
        price="the largest stress is looked for at the wrong frequency",
        why="A strip that strikes is turned early, so the stop stiffens it, the more the harder it strikes: its "
        "resonance lies above that of the free strip and moves on as the swing grows. So the swing follows a "
        "slow sweep upwards past 13.37 Hz without a peak there. It ends at a fold, beyond which the base no "
        "longer feeds what damping takes, and the strip falls back to a small swing that does not reach the stop.",
        command=_SWEPT,
        cases="shaken at",
        beside=_BESIDE,
        compute=swing,
        within=1e-2,
    ),
    Question(
        name="rest",
        title="A sweep finds the strip striking at 16 Hz in every period: does it, when it is shaken so from "
        "rest?",
        guess="yes, after the transient",
        answer="no: it touches once, at {1[last contact at (s)]:.2f} s, and never again; at 16.5 Hz not at all",
        wrong=True,
        cost=100,
        price="a test at one frequency finds no contact where a machine that runs up rattles",
        why="Where a strip without a stop would swing by less than the gap, but below the fold, there are two "
        "steady motions, one that strikes and one that does not. From rest the swing first beats to nearly twice "
        "the steady one: at 15.5 Hz that is far enough past the stop to be caught by the first, at 16 Hz it "
        "touches and falls back to the second. A sweep, a knock or a warm start finds the other: one run says "
        "nothing about it.",
        command=_REST,
        cases="shaken from rest at",
        beside=_BESIDE,
        compute=rest,
        within=1e-2,
    ),
]
