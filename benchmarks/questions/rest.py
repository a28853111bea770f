"""Strips at rest: on a table, and hanging with a mass."""

from __future__ import annotations

import numpy as np
from scipy.integrate import solve_bvp

from oblique_impact import frequencies_at_rest
from questions.question import Question, Row, run, scenario_of

_BENDING, _WEIGHT = 2.1e11 * 0.02 * 2e-4**3 / 12.0, 7850.0 * 0.02 * 2e-4 * 9.81  # N m^2, N/m

_TABLE = """\
oblique-impact run slap --set root.kind=driven --set initial.angle=0 --set initial.state=equilibrium \\
    --set beam.length=1.5 --set beam.material=steel --set gravity=9.81 \\
    --set "beam.section={shape='rectangle', height=2e-4, width=0.02}" --set "obstacles.1.origin=[0, -0.4]" \\
    --set discretization.method=absolute --set discretization.elements=30 --set contact.grid=30 \\
    --set end_time=1e-4 --out out/table"""

_HANGING = """\
oblique-impact modes paper --closed --set initial.angle=-1.5707963267948966 --set contact.enabled=false \\
    --set discretization.method=fem --set discretization.frame=mean-axis --set discretization.modes=4 \\
    --set "masses=[{place=0.5, mass=0.868744}]\""""


def _span(height: float) -> tuple[float, float]:
    """Return the hanging length (m) of the strip and the shear at its clamp (N), as an elastica that bends far.

    It is level at the clamp, and level and without curvature where it lies down; nothing pulls it along.
    """
    cubed = _BENDING / _WEIGHT
    small = (72.0 * height * cubed) ** 0.25

    def rates(part: np.ndarray, state: np.ndarray, unknown: np.ndarray) -> np.ndarray:
        length, shear = unknown
        turn, curvature, _, _ = state
        bends = (shear - length * part) * np.cos(turn) / cubed
        return np.asarray(length * np.array([curvature, bends, np.cos(turn), np.sin(turn)]))

    def ends(a: np.ndarray, b: np.ndarray, _: np.ndarray) -> np.ndarray:
        return np.array([a[0], a[2], a[3], b[0], b[1], b[3] + height])

    part = np.linspace(0.0, 1.0, 41)
    x = part * small
    start = np.array(
        [
            -(small**3) / cubed * part * (1.0 - part) ** 2 / 6.0,
            -(small**2) / cubed * (1.0 - part) * (1.0 - 3.0 * part) / 6.0,
            x,
            -height * part**2 * (6.0 - 8.0 * part + 3.0 * part**2),
        ]
    )
    found = solve_bvp(rates, ends, part, start, p=[small, 2.0 * small / 3.0], tol=1e-9, max_nodes=20_000)
    assert found.success
    return float(found.p[0]), float(found.p[1] * _WEIGHT)


def table() -> list[Row]:
    """Return the moment and the shear at the clamp over its height, and by small bending."""
    rows = []
    for height in (0.1, 0.2, 0.4):
        lies = f"obstacles.1.origin=[0, {-height}]"
        forces = run(_TABLE, lies).section_forces()
        second_order = run(_TABLE, lies, "discretization.method=fem", "discretization.modes=0").section_forces()
        moment, shear = (abs(float(forces[name].values[0, 0])) for name in ("moment", "shear"))
        length, exact = _span(height)
        small = (72.0 * height * _BENDING / _WEIGHT) ** 0.25
        values = {
            "moment (N mm)": (1e3 * moment, 1e3 * np.sqrt(2.0 * _BENDING * _WEIGHT * height)),
            "moment in all nodes of a mesh (N mm)": (1e3 * abs(float(second_order["moment"].values[0, 0])), None),
            "shear (N)": (shear, exact),
            "shear of small bending (N)": (2.0 / 3.0 * _WEIGHT * small, None),
            "span over that of small bending": (length / small, None),
        }
        rows.append(Row(f"{height:g} m", values))
    return rows


def hanging() -> list[Row]:
    """Return the first frequency over the place of the mass."""
    rows = []
    m, g = 2766.7 * 3.14e-4, 9.8
    for place in (0.25, 0.5, 2.0 / 3.0, 0.8, 1.0):
        found = frequencies_at_rest(scenario_of(_HANGING, f"masses=[{{place={place}, mass={m}}}]"), 1)
        square = g * (0.5 + place) / (1.0 / 3.0 + place**2)
        over = float(found.frequencies[0]) / np.sqrt(1.5 * g)
        rows.append(Row(f"{place:.3g} L", {"over that without": (over, float(np.sqrt(square / (1.5 * g))))}))
    return rows


QUESTIONS = [
    Question(
        name="table",
        title="A heavy strip is clamped level, high above a table, and lies down on it: its slope comes to 56°. "
        "What does the large bending change in the moment at the clamp?",
        guess="it is smaller; the strip touches 10 % nearer to the clamp",
        answer="nothing, it is √(2 E I w h) as with small bending: {2[moment (N mm)]:.2f} N mm at 0.4 m; but the "
        "model of the floating frame, which bends little and shortens to the second order, has "
        "{2[moment in all nodes of a mesh (N mm)]:.1f}",
        wrong=True,
        cost=38,
        price="a correction that is none, or the wrong model",
        why="Along the strip E I κ²/2 and what its weight does are kept together, as the energy of a pendulum is "
        "over time, whatever the slope. Level at both ends, and without curvature where it lies down, it has E I "
        "κ²/2 = w h at the clamp. The hanging part does change, to {2[span over that of small bending]:.2f} "
        "times its length, and the shear with it.",
        command=_TABLE,
        cases="height",
        beside="√(2 E I w h), and of the shear an elastica by `scipy.integrate.solve_bvp`",
        compute=table,
        within=1e-2,  # the strip is touched every 50 mm
    ),
    Question(
        name="hanging",
        title="A hanging beam has a mass of its own weight clipped to its middle. How much lower is its first "
        "frequency?",
        guess="10 % lower",
        answer="it is {1[over that without]:.3f} times as high",
        wrong=True,
        cost=17,
        price="the wrong sign in what a sensor does",
        why="Its stiffness is weight, which grows with the mass as its inertia does. A mass is a pendulum of its "
        "own length: inside of 2/3 L, the length of the pendulum that swings as the beam does, it is the faster "
        "one and pulls the beam along. At 2/3 L it changes nothing.",
        command=_HANGING,
        cases="mass at",
        beside="a rigid pendulum, g (1/2 + x)/(1/3 + x²)",
        compute=hanging,
        within=1e-3,
    ),
]
