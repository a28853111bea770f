"""Beams that strike stops: a pinned beam that turns onto them, and a clamped strip that is let go."""

from __future__ import annotations

from math import gamma

import numpy as np
from reference_impact import Beam
from scipy.optimize import minimize_scalar

from questions.independent_strip import Spring, Strip
from questions.question import Question, Row, run

#: the paper's beam
_BENDING, _MASS = 68.952e9 * 7.85e-9, 2766.7 * 3.14e-4  # N m^2, kg/m

_TURNING = """\
oblique-impact run paper --set gravity=0 --set initial.angle=0 --set initial.angular_velocity=-1 \\
    --set contact.normal=spring --set contact.friction=frictionless --set discretization.frame=mean-axis"""

_LEVEL = '--set slope.angle=0 --set "slope.origin=[0, 0]"'

_FEM = "--set discretization.method=fem --set discretization.modes=16 --set discretization.elements=20"

_STIFFER = f"""{_TURNING} \\
    {_LEVEL} \\
    --set contact.stiffness=8e6 --set discretization.modes=60 --set end_time=2e-3 --out out/stiffer"""

_PIN = f"""{_TURNING} \\
    {_LEVEL} \\
    --set contact.point=0.6666666666666666 --set contact.stiffness=1e6 --set beam.kelvin_voigt=2e-5 \\
    --set discretization.method=fem --set discretization.modes=24 --set discretization.elements=24 \\
    --set solver.output_interval=1e-5 --set end_time=0.02 --out out/pin"""

_SECOND = f"""{_TURNING} \\
    --set contact.where=anywhere --set contact.stiffness=1e5 --set beam.kelvin_voigt=2e-5 \\
    {_FEM} \\
    --set slope.enabled=false \\
    --set "obstacles=[{{kind='point', origin=[0.8, -1e-8]}}, {{kind='point', origin=[0.95, -1e-8]}}]" \\
    --set solver.output_interval=2e-5 --set end_time=0.025 --out out/second"""

_CLAMP = f"""\
oblique-impact run shaken --set base.acceleration=0 --set base.frequency=0 --set gravity=0 \\
    --set initial.state=plucked --set initial.place=0.25 --set initial.deflection=5e-3 \\
    --set "slope.origin=[0, 0.25]" --set "slope.extent=[]" --set beam.kelvin_voigt=2e-5 \\
    {_FEM} \\
    --set root.stiffness=5.6 --set end_time=0.042 --out out/clamp"""

_ROUGH = """\
oblique-impact run many-modes --set discretization.modes=8 --set contact.friction=hybrid --set end_time=0.345 \\
    --out out/rough-stop"""


def _turning(
    stops: tuple[int, ...], stiffness: float, end: float, elements: int, modes: int, step: float
) -> tuple[Strip, np.ndarray, np.ndarray]:
    """Return a pinned beam that turns onto springs at nodes, its amplitudes and their rates over time."""
    beam = Strip(1.0, _BENDING, _MASS, elements, modes, root="pin", kelvin_voigt=2e-5)
    turns = np.repeat(-1.0, 2 * elements + 2)
    turns[::2] = -np.linspace(0.0, 1.0, elements + 1)
    springs = [Spring(node, stiffness) for node in stops]
    _, states, _ = beam.march((np.zeros(modes), beam.amplitudes(turns)), springs, end, step)
    return beam, states[:, :modes], states[:, modes:]


def second() -> list[Row]:
    """Return the largest moment with one stop and with two."""
    rows = []
    pegs = [f"{{kind='point', origin=[{place}, -1e-8]}}" for place in (0.8, 0.95)]
    for name, chosen, nodes in (
        ("0.8 L", pegs[:1], (16,)),
        ("0.8 L and 0.95 L", pegs, (16, 19)),
        ("0.95 L", pegs[1:], (19,)),
    ):
        history = run(_SECOND, f"obstacles=[{', '.join(chosen)}]")
        moment = float(np.abs(history.section_forces()["moment"].values).max())
        beam, amplitudes, _ = _turning(nodes, 1e5, 0.025, 20, 20, 1e-5)
        along = np.array([beam.moment_row(element, end) for element in range(20) for end in (0.0, 1.0)])
        rows.append(Row(name, {"largest moment (N m)": (moment, float(np.abs(amplitudes @ along.T).max()))}))
    return rows


def pin() -> list[Row]:
    """Return the largest force on the pin with a stop at 2/3 of the length and at the tip."""
    rows = []
    for place, node in ((2.0 / 3.0, 16), (1.0, 24)):
        for stiffness in (1e4, 1e5, 1e6):
            history = run(_PIN, f"contact.point={place}", f"contact.stiffness={stiffness}")
            force = float(np.abs(history.section_forces()["shear"].values[:, 0]).max())
            beam, amplitudes, rates = _turning((node,), stiffness, 0.02, 24, 24, 1e-5)
            pushes = stiffness * np.maximum(-amplitudes @ beam.row(node), 0.0)
            speeding = -(amplitudes + beam.kelvin_voigt * rates) * beam.squares + np.outer(pushes, beam.row(node))
            other = float(np.abs(speeding @ beam.uniform() - pushes).max())
            rows.append(Row(f"{place:.3g} L, {stiffness:g} N/m", {"largest force on the pin (N)": (force, other)}))
    return rows


def _peak(stiffness: float) -> float:
    """Return the largest force (N) on the end of an endless beam that comes with 1 m/s, by its series.

    Its end answers a force with Z sqrt(s): the depth is t E(-(k/Z) t^(3/2)), with Mittag-Leffler's E of 3/2 and 2.
    """
    Z = _BENDING**0.25 * _MASS**0.75 / np.sqrt(2.0)

    def depth(x: float) -> float:
        return float(sum((-1) ** n * x ** (1.5 * n + 1.0) / gamma(1.5 * n + 2.0) for n in range(60)))

    found = minimize_scalar(lambda x: -depth(x), bounds=(0.5, 3.0), method="bounded", options={"xatol": 1e-10})
    return float(stiffness * -found.fun * (Z / stiffness) ** (2.0 / 3.0))


def stiffer() -> list[Row]:
    """Return the largest force of the first contact over the stop's stiffness and the beam's length."""
    rows = []
    for length in (1.0, 2.0):
        for stiffness in (1e6, 8e6):
            changes = f"contact.stiffness={stiffness}", f"beam.length={length}"
            history = run(_STIFFER, *changes, f"initial.angular_velocity={-1.0 / length}")
            peak = float(history.contacts[0].peak_force)
            rows.append(
                Row(f"{length:g} m, {stiffness / 1e6:g} N/µm", {"largest force (N)": (peak, _peak(stiffness))})
            )
    return rows


def clamp() -> list[Row]:
    """Return contacts and impulse of the first collision over the stiffness of the clamp."""
    rows, length, bending = [], 0.25, 0.35
    for over, end in ((np.inf, 0.03), (40.0, 0.03), (4.0, 0.042), (1.0, 0.06)):
        spring = 0.0 if np.isinf(over) else over * bending / length
        changes = [f"end_time={end}", f"root.stiffness={spring}"]
        history = run(_CLAMP, *changes)
        strip = Strip(length, bending, 0.157, 20, 16, root_spring=spring, kelvin_voigt=2e-5)
        pulled = np.zeros(strip.K.shape[0])
        pulled[strip.free] = np.linalg.solve(strip.K[np.ix_(strip.free, strip.free)], np.eye(strip.free.size)[-2])
        start = strip.amplitudes(pulled * 5e-3 / pulled[-2]), np.zeros(16)
        _, _, touches = strip.march(start, [Spring(20, 5e3)], end, 2e-6)
        values = {
            "contacts": (float(len(history.contacts)), float(len(touches))),
            "impulse (mN s)": (
                1e3 * sum(contact.normal_impulse for contact in history.contacts),
                1e3 * sum(touch.impulse for touch in touches),
            ),
        }
        rows.append(Row("rigid" if np.isinf(over) else f"{over:g} E I/L", values))
    return rows


def rough() -> list[Row]:
    """Return contacts of the first collision over the modes, with friction and without."""
    rows = []
    for modes in (2, 4, 8, 16):
        values = {}
        for name, friction in (("without friction", 0.0), ("with", 0.3)):
            law = "hybrid" if friction else "frictionless"
            history = run(_ROUGH, f"discretization.modes={modes}", f"contact.friction={law}")
            other = None
            if modes <= 8:
                beam = Beam(modes, mean_axis=True, friction=friction)
                beam.march(0.345)
                other = float(sum(kind in ("impact", "rebound") for kind, _ in beam.events))
            values[f"contacts {name}"] = (float(len(history.contacts)), other)
        rows.append(Row(f"{modes}", values))
    return rows


QUESTIONS = [
    Question(
        name="second-stop",
        title="A beam turns onto a stop at 0.8 of its length. A second one near its tip shares the blow. What "
        "does it do to the largest bending stress?",
        guess="it lowers it by a third",
        answer="it raises it {0[largest moment (N m)]:.1f} to {1[largest moment (N m)]:.1f} N m",
        wrong=True,
        cost=110,
        price="a stop that is added for safety and doubles the stress",
        why="A stop near the centre of percussion stops all of the beam: what is on either side balances, and "
        "little is left to bend it. A second one near the tip, met at the same moment, takes this balance away, "
        "and the span between pin and tip sags as if it were struck in its middle. Stops share the force, not "
        "the stress.",
        command=_SECOND,
        cases="stops at",
        beside="modes of small bending on springs, marched by matrix exponentials (`independent_strip.py`)",
        compute=second,
        within=1.5e-2,  # places along the beam
    ),
    Question(
        name="pin",
        title="A stop at the centre of percussion, 2/3 of the length, spares the pin. How large is the force on "
        "it, against a stop at the tip?",
        guess="a fifth",
        answer="{2[largest force on the pin (N)]:.0f} for {5[largest force on the pin (N)]:.0f} N on a stiff "
        "stop, {0[largest force on the pin (N)]:.1f} for {3[largest force on the pin (N)]:.1f} N on a soft one",
        wrong=True,
        cost=340,
        price="a pin that is made for a fifth of what comes",
        why="The centre of percussion is one of rigid bodies: no impulse comes to the pin in the end. A beam "
        "bends, and its bending arrives at the pin as a force to one side and then to the other. The stop has to "
        "be so soft that its contact outlasts the first vibration.",
        command=_PIN,
        cases="stop",
        beside="modes of small bending; the force is what is left of the momentum (`independent_strip.py`)",
        compute=pin,
        within=5e-3,
    ),
    Question(
        name="stiffer",
        title="A stop eight times as stiff: how much larger is the first peak of its force? And with a beam "
        "twice as long?",
        guess="√8 = 2.8 times, as the mass on a spring; √2 times",
        answer="{1[largest force (N)]:.0f} after {0[largest force (N)]:.0f} N, twice; and not at all, "
        "{2[largest force (N)]:.0f} N",
        wrong=True,
        cost=41,
        price="a stop that is measured at one stiffness and extrapolated to another",
        why="In the time of the peak the stop knows a short piece of the beam alone, as far as a bending wave "
        "has come. A stiffer stop is quicker and has less of it, so that the mass which it stops falls by "
        "k^(-1/3), and the force grows by k^(1/3). What lies beyond, the length and the pin, comes later.",
        command=_STIFFER,
        cases="beam, stop",
        beside="the end of an endless beam, by Mittag-Leffler's series",
        compute=stiffer,
        within=2e-3,
    ),
    Question(
        name="clamp",
        title="A strip is let go against a stop. Its clamp yields, 4 E I/L: is it struck less often?",
        guess="yes: a softer beam comes slower, 3 contacts for 5",
        answer="more often, {2[contacts]:.0f} for {0[contacts]:.0f}; the impulse is {2[impulse (mN s)]:.2f} for "
        "{0[impulse (mN s)]:.2f} mN s",
        wrong=True,
        cost=50,
        price="a clamp is not in the model, and the second blow neither",
        why="The clamp lowers the first frequency by 30 %, and with it the impulse, but the second one by 19 % "
        "only. A collision is long in terms of the second vibration, whose swing back lifts the tip off the stop "
        "in its middle. The slower the first mode, the more such swings has its half period.",
        command=_CLAMP,
        cases="clamp",
        beside="modes of small bending (`independent_strip.py`)",
        compute=clamp,
        within=5e-3,
    ),
    Question(
        name="refinement-friction",
        title="On a rigid stop without damping the number of contacts grows with every mode. Does friction bound "
        "it?",
        guess="yes, friction takes energy: below ten",
        answer="it does not change it: {2[contacts with]:.0f} of {2[contacts without friction]:.0f} in 8 modes, "
        "{3[contacts with]:.0f} of {3[contacts without friction]:.0f} in 16",
        wrong=True,
        cost=170,
        price="a limit that is believed where there is none",
        why="The contacts are made by bending across the beam, and friction acts along it: it moves nothing but "
        "by the small angle between beam and slope and by what bending shortens. It takes energy from the swing, "
        "not from the vibrations. Damping of the beam that the mesh resolves bounds the number, friction does "
        "not.",
        command=_ROUGH,
        cases="modes",
        beside="`reference_impact.py`, in SciPy alone",
        compute=rough,
        within=1e-9,
    ),
]
