"""A clamped strip that rests on what it strikes: a stop with a preload, an edge under its span."""

from __future__ import annotations

import numpy as np

from questions.independent_strip import Spring, Strip
from questions.question import Question, Row, run

_LENGTH, _BENDING, _MASS = 0.25, 0.35, 0.157  # of the case `shaken`: m, N m^2, kg/m

#: a stop three times as stiff as the strip at its tip, pressed in by 1 mm, 50 mN
_STIFFNESS, _PRESSED, _DAMPING = 200.0, 1e-3, 2.4e-4  # N/m, m, s

_ROUTES = """\
oblique-impact run shaken --set base.acceleration=1 --set base.frequency=19 --set gravity=0 \\
    --set initial.state=plucked --set initial.place=0.25 --set initial.deflection=5e-3 \\
    --set "slope.origin=[-0.001, 0.25]" --set "slope.extent=[]" --set contact.stiffness=200 \\
    --set discretization.modes=4 --set solver.output_interval=5e-4 --set end_time=6 --out out/routes"""

_EDGE = """\
oblique-impact run shaken --set base.acceleration=0 --set base.frequency=0 --set gravity=0 \\
    --set initial.angle=0 --set initial.state=plucked --set initial.place=0.25 --set initial.force=-0.2 \\
    --set beam.kelvin_voigt=1e-4 --set discretization.method=fem --set discretization.modes=16 \\
    --set discretization.elements=20 --set slope.enabled=false --set contact.where=anywhere \\
    --set "obstacles=[{kind='point', origin=[0.15, -1e-8], stiffness=1e6}]" \\
    --set solver.output_interval=5e-5 --set end_time=0.04 --out out/edge-pluck"""


def _swing(frequency: float, shaken: float, start: str) -> float:
    """Return half of the range of the tip (m) over the last four periods, as the program has it."""
    undisturbed = ["initial.state=equilibrium", "initial.place=0", "initial.deflection=0"] if start == "rest" else []
    history = run(_ROUTES, f"base.frequency={frequency}", f"base.acceleration={shaken}", *undisturbed)
    times, tip = history["time"].values, history["tip_x"].values
    return float(np.ptp(tip[times > times[-1] - 4.0 / frequency])) / 2.0


def _other_swing(frequency: float, shaken: float, start: str) -> float:
    """Return the same of modes of small bending."""
    strip = Strip(_LENGTH, _BENDING, _MASS, 10, 4, kelvin_voigt=_DAMPING)
    tip = strip.row(10)
    pressed = _STIFFNESS * np.outer(tip, tip)
    rest = np.linalg.solve(np.diag(strip.squares) + pressed, _STIFFNESS * _PRESSED * tip)
    # held farther from the stop by a force at the tip: the stop carries nothing there
    held = tip / strip.squares
    state = rest if start == "rest" else held * (5e-3 + rest @ tip) / (held @ tip)
    times, states, _ = strip.march(
        (state, np.zeros(4)),
        [Spring(10, _STIFFNESS, _PRESSED)],
        6.0,
        1.0 / (100.0 * frequency),
        harmonic=(-shaken * strip.uniform(), 2.0 * np.pi * frequency),
        after=6.0 - 4.0 / frequency,
    )
    return float(np.ptp(states[1:, :4] @ tip)) / 2.0


def routes() -> list[Row]:
    """Return the swing of the tip at 19 Hz, from rest and from a pluck."""
    rows = []
    for start in ("rest", "a pluck by 5 mm"):
        two = _swing(19.0, 1.0, start), _other_swing(19.0, 1.0, start)
        rows.append(Row(start, {"swing of the tip (mm)": (1e3 * two[0], 1e3 * two[1])}))
    return rows


def leaning() -> list[Row]:
    """Return the swing of the tip over what shakes it, at four frequencies, started by a pluck."""
    rows = []
    for frequency in (25.5, 22.0, 20.0, 19.0, 13.4):
        values = {}
        for shaken in (0.05, 1.0):
            start = "rest" if shaken < 0.1 else "a pluck"
            two = (f(frequency, shaken, start) / shaken for f in (_swing, _other_swing))
            values[f"swing over shaking of {shaken:g} m/s² (mm s²/m)"] = tuple(1e3 * one for one in two)
        rows.append(Row(f"{frequency:g} Hz", values))  # type: ignore[arg-type]
    return rows


def edge() -> list[Row]:
    """Return moments at the root and over the edge, pulled and let go."""
    strip = Strip(_LENGTH, _BENDING, _MASS, 20, 16, kelvin_voigt=1e-4)
    whole = strip.K.copy()
    whole[24, 24] += 1e6
    pull = -0.2 * np.eye(42)[40]
    bent = np.zeros(42)
    bent[strip.free] = np.linalg.solve(whole[np.ix_(strip.free, strip.free)], pull[strip.free])
    _, states, _ = strip.march((strip.amplitudes(bent), np.zeros(16)), [Spring(12, 1e6)], 0.04, 1e-5)
    others = states[:, :16] @ strip.moment_row(0, 0.0)
    history = run(_EDGE)
    moments = history.section_forces()["moment"].values[:, 0]
    over = 0.2 * 0.1  # the force times its lever: in closed form its half comes to the root, with the other sign
    rows = [
        Row("pulled", {"moment at the root (N mm)": (1e3 * float(moments[0]), 1e3 * over / 2.0)}),
        Row("let go, largest", {"moment at the root (N mm)": (1e3 * moments.max(), 1e3 * others.max())}),
        Row("let go, least", {"moment at the root (N mm)": (1e3 * moments.min(), 1e3 * others.min())}),
    ]
    return rows


QUESTIONS = [
    Question(
        name="leaning",
        title="A shaken strip rests on a stop with a preload. To which side does its resonance lean as it is "
        "shaken harder?",
        guess="upwards, as with every stop, which stiffens",
        answer="downwards, from 25.5 towards 17.5 Hz: shaken harder, it swings at 19 Hz "
        "{3[swing over shaking of 1 m/s² (mm s²/m)]:.1f} for {3[swing over shaking of 0.05 m/s² (mm s²/m)]:.2f} "
        "mm per m/s²",
        wrong=True,
        cost=2300,
        price="a resonance that is sought above and waits below",
        why="As long as the preload holds, the stop is a support, and the strip has 25.5 Hz. Shaken harder it "
        "leaves the stop for a part of each period, in which it has the 13.4 Hz of the free strip: it softens. "
        "It never comes to these: of swings that are large against the preload half a period is of each kind, "
        "2/(1/25.5 + 1/13.4) = 17.5 Hz.",
        command=_ROUTES,
        cases="frequency",
        beside="modes of small bending (`independent_strip.py`)",
        compute=leaning,
        within=2e-2,
    ),
    Question(
        name="routes",
        title="The same strip, shaken with 1 m/s² at 19 Hz, is calm on its stop. Somebody plucks it. Does it "
        "come back to calm?",
        guess="yes, after some periods",
        answer="no: it goes on with {1[swing of the tip (mm)]:.2f} mm, from rest it has "
        "{0[swing of the tip (mm)]:.2f} mm",
        wrong=True,
        cost=2300,
        price="a machine that is calm until it is touched",
        why="At 19 Hz the strip on its stop is far below its resonance, and small. The strip that leaves its "
        "stop is at its resonance, and large enough to go on leaving it. Both motions are stable; the start "
        "decides which is seen, and a sweep from below sees the calm one until the preload is gone.",
        command=_ROUTES,
        cases="from",
        beside="modes of small bending (`independent_strip.py`)",
        compute=routes,
        within=1e-2,
    ),
    Question(
        name="edge-pluck",
        title="A strip rests on an edge, its tip is pulled down over it and let go. Is the moment at the clamp "
        "ever larger than while it was pulled?",
        guess="no, a release only gives back",
        answer="{1[moment at the root (N mm)]:.1f} N mm after {0[moment at the root (N mm)]:.1f} N mm",
        wrong=True,
        cost=160,
        price="a fatigue life from the moment of the pull",
        why="While it is pulled the edge carries: half of the moment over the edge comes to the root, with the "
        "other sign. Let go, the strip leaves the edge and swings as a whole, and what was stored on both sides "
        "of the edge bends it most at its root. The edge hides the root from the pull, not from the release.",
        command=_EDGE,
        cases="",
        beside="F (L - a)/2 of a clamped strip over a support; modes of small bending (`independent_strip.py`)",
        compute=edge,
        within=1e-2,
    ),
]
