"""A clamped strip and stops: one with a preload, an edge under its span, two stops with a clearance."""

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


_TWO = """\
oblique-impact run shaken --set base.frequency=17.5 --set gravity=0 --set initial.state=plucked \\
    --set initial.place=0.25 --set initial.force=-1 --set contact.where=anywhere --set contact.grid=1 \\
    --set "slope.extent=[]" --set "obstacles=[{kind='side', origin=[-0.002, 0.25], angle=-1.5707963267948966}]" \\
    --set solver.output_interval=2e-4 --set end_time=5 --out out/two-stops"""


def _swing(frequency: float, shaken: float, start: str) -> float:
    """Return half of the range of the tip (m) over the last four periods, as the program has it."""
    undisturbed = (
        ["initial.state=equilibrium", "initial.place=0", "initial.deflection=0"] if start == "rest" else []
    )
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
    _, states, _ = strip.march(
        (state, np.zeros(4)),
        [Spring(10, _STIFFNESS, _PRESSED)],
        6.0,
        1.0 / (100.0 * frequency),
        harmonic=(-shaken * strip.uniform(), 2.0 * np.pi * frequency),
        after=6.0 - 4.0 / frequency,
    )
    return float(np.ptp(states[1:, :4] @ tip)) / 2.0


def routes(frequency: float = 19.0) -> list[Row]:
    """Return the swing of the tip at a frequency, from rest and from a pluck."""
    rows = []
    for start in ("rest", "a pluck by 5 mm"):
        two = _swing(frequency, 1.0, start), _other_swing(frequency, 1.0, start)
        rows.append(Row(start, {"swing of the tip (mm)": (1e3 * two[0], 1e3 * two[1])}))
    return rows


def free_frequency() -> list[Row]:
    """Return the same at the frequency that the strip has without its stop."""
    return routes(13.4)


def leaning() -> list[Row]:
    """Return the swing of the tip over what shakes it, at four frequencies, started by a pluck."""
    rows = []
    for frequency in (25.5, 22.0, 20.0, 19.0):
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


def two() -> list[Row]:
    """Return swing and moment at the root with one stop and with two, from a pluck."""
    rows = []
    strip = Strip(_LENGTH, _BENDING, _MASS, 20, 6, kelvin_voigt=_DAMPING)
    tip, root = strip.row(20), strip.moment_row(0, 0.0)
    # pulled into the first stop
    pulled = np.linalg.solve(np.diag(strip.squares) + 5e3 * np.outer(tip, tip), (-1.0 - 5e3 * 2e-3) * tip)
    for frequency in (13.0, 17.5):
        for name, stops in (("one stop", 1), ("two stops", 2)):
            history = run(_TWO, f"base.frequency={frequency}", *(["obstacles=[]"] if stops == 1 else []))
            late = history["time"].values > 5.0 - 8.0 / frequency
            moments = history.section_forces()["moment"].values[late, 0]
            # the tip goes left to positive deflections, the first stop is on its right
            springs = [Spring(20, 5e3, -2e-3), Spring(20, 5e3, 2e-3, -1.0)][:stops]
            _, states, _ = strip.march(
                (pulled, np.zeros(6)),
                springs,
                5.0,
                1.0 / (200.0 * frequency),
                harmonic=(2.0 * strip.uniform(), 2.0 * np.pi * frequency),
                after=5.0 - 8.0 / frequency,
            )
            amplitudes = states[1:, :6]
            values = {
                "swing of the tip (mm)": (
                    500.0 * float(np.ptp(history["tip_x"].values[late])),
                    500.0 * float(np.ptp(amplitudes @ tip)),
                ),
                "moment at the root (N mm)": (
                    1e3 * float(np.abs(moments).max()),
                    1e3 * float(np.abs(amplitudes @ root).max()),
                ),
            }
            rows.append(Row(f"{frequency:g} Hz, {name}", values))
    return rows


QUESTIONS = [
    Question(
        name="two-stops",
        title="A shaken strip has a stop on one side. A second one on the other side: is its swing smaller, and "
        "its stress?",
        guess="half of the swing, two thirds of the stress",
        answer="at its resonance both, by 5 and 17 %; at 17.5 Hz, once disturbed, "
        "{3[moment at the root (N mm)]:.0f} N mm in place of {2[moment at the root (N mm)]:.0f} N mm",
        wrong=True,
        cost=970,
        price="a second stop that keeps up what the first one lets die",
        why="Stops stiffen, and two of them more than one, which acts in half of each period alone: the motion "
        "with impacts reaches up to higher frequencies. Above 17.2 Hz, where that of one stop ends, the strip "
        "beside it comes to rest from any pluck, and between two stops it need not. A stop limits how far the "
        "strip swings, not whether it goes on.",
        command=_TWO,
        cases="",
        beside="modes of small bending (`independent_strip.py`)",
        compute=two,
        within=2e-2,
    ),
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
        "It never comes to 13.4 Hz: a swing that is large against the preload spends half a period of each kind, "
        "which makes 2/(1/25.5 + 1/13.4) = 17.5 Hz.",
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
        name="free-frequency",
        title="The strip on its preloaded stop is shaken at 13.4 Hz, which it has without the stop, and plucked. "
        "Does it come back to calm?",
        guess="it comes back to calm after some periods",
        answer="so it does: {1[swing of the tip (mm)]:.3f} mm after a pluck, {0[swing of the tip (mm)]:.3f} mm "
        "from rest",
        wrong=False,
        cost=0,
        price="",
        why="The free strip has its resonance here, but the strip is never free: as long as it swings at all it "
        "meets the stop in each period and is faster. Its largest motions are at 17.5 Hz and above. Here it "
        "loses the pluck, to what its damping leaves after 6 s.",
        command=_ROUTES.replace("frequency=19", "frequency=13.4"),
        cases="from",
        beside="modes of small bending (`independent_strip.py`)",
        compute=free_frequency,
        within=3e-2,  # what is left of the pluck
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
