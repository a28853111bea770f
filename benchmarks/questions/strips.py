"""A clamped steel strip: its clamp, masses, pegs and jaws, by its frequencies about rest."""

from __future__ import annotations

import numpy as np

from oblique_impact import frequencies_at_rest
from questions.independent_secular import Piece, decay, roots
from questions.question import Question, Row, run, scenario_of

#: the strip of the case `shaken`
LENGTH, BENDING, MASS = 0.25, 0.35, 0.157  # m, N m^2, kg/m
UNIT = np.sqrt(BENDING / MASS) / LENGTH**2  # rad/s
_SPRING = LENGTH**3 / BENDING  # m/N

_STRIP = """\
oblique-impact modes shaken --closed --set base.acceleration=0 --set base.frequency=0 --set gravity=0 \\
    --set initial.angle=0 --set beam.kelvin_voigt=0 --set discretization.method=fem --set discretization.modes=0"""

_DASHPOT = f"""{_STRIP} \\
    --set contact.enabled=false --set root.stiffness=5.6 --set root.damping=0.112"""

_MASS = f"""{_STRIP} \\
    --set contact.enabled=false --set "masses=[{{place=0.118, mass=0.002}}]\""""

_SUPPORT = f"""{_STRIP} \\
    --set initial.state=equilibrium --set slope.enabled=false --set contact.where=anywhere"""

_PEG = f"""{_SUPPORT} \\
    --set "obstacles=[{{kind='point', origin=[0.19586, -9.9e-4], radius=1e-3, stiffness=1e9}}]\""""

#: 10 N from either side
_JAWS = f"""{_SUPPORT.replace(" --closed", " --closed --friction stuck")} \\
    --set contact.surface=section --set contact.friction=hybrid --set contact.axial_flexibility=true \\
    --set "obstacles=[{{kind='point', origin=[0.2421875, 4.9e-4], stiffness=1e6}}, \\
{{kind='point', origin=[0.2421875, -4.9e-4], stiffness=1e6}}]\""""


def clamp_dashpot() -> list[Row]:
    """Return the damping ratio over the dashpot in the clamp."""
    rows = []
    for damping in (0.0112, 0.0354, 0.112, 0.354, 1.12):
        found = frequencies_at_rest(scenario_of(_DASHPOT, f"root.damping={damping}"), 4)
        # the first vibration, not a motion without one
        k = next(k for k, ratio in enumerate(found.damping) if ratio < 0.999)
        rate, ratio = decay(4.0, damping * UNIT * LENGTH / BENDING)
        values = {
            "damping ratio": (float(found.damping[k]), ratio),
            "decay (1/s)": (float(found.damping[k] * found.frequencies[k]), ratio * rate * UNIT),
        }
        rows.append(Row(f"{damping:g} N m s/rad", values))
    return rows


def mass() -> list[Row]:
    """Return the second frequency with a mass at the antinode and at the tip."""
    rows = []
    for size in (0.002, 0.004, 0.008, 0.016, 0.039):
        values = {}
        for name, place in (("at the antinode", 0.118), ("at the tip", LENGTH)):
            found = frequencies_at_rest(scenario_of(_MASS, f"masses=[{{place={place}, mass={size}}}]"), 2)
            at = Piece(place / LENGTH, mass=size / (MASS * LENGTH))
            pieces = [at] if place == LENGTH else [at, Piece(1.0 - place / LENGTH)]
            other = float(roots(pieces, 2)[1]) * UNIT / (2.0 * np.pi)
            values[f"{name} (Hz)"] = (float(found.frequencies[1]) / (2.0 * np.pi), other)
        rows.append(Row(f"{1e3 * size:g} g", values))
    return rows


def peg() -> list[Row]:
    """Return the first frequency over the place of a peg."""
    rows = []
    for part in (0.6, 0.7, 0.78344, 0.85, 0.9, 0.99):
        obstacle = f"{{kind='point', origin=[{part * LENGTH}, -9.9e-4], radius=1e-3, stiffness=1e9}}"
        found = frequencies_at_rest(scenario_of(_PEG, f"obstacles=[{obstacle}]"), 2)
        pieces = [Piece(part, spring=1e9 * _SPRING), Piece(1.0 - part)]
        over = float(found.frequencies[0]) / UNIT / 3.516015
        rows.append(Row(f"{part:g} L", {"over that without": (over, float(roots(pieces, 1)[0]) / 3.516015)}))
    return rows


def jaws() -> list[Row]:
    """Return the first frequency of a strip in jaws without friction and with contacts that stick."""
    rows = []
    # both press with 10 N at half a millimetre: as the section turns they turn it back with 0.01 N m/rad
    pressed = 0.01 * LENGTH / BENDING
    for name, friction, turn in (("slips", "free", pressed), ("sticks", "stuck", 1e9)):
        found = frequencies_at_rest(scenario_of(_JAWS), 2, "stuck" if friction == "stuck" else "free")
        pieces = [Piece(0.2421875 / LENGTH, spring=2e6 * _SPRING, turn=turn), Piece(1.0 - 0.2421875 / LENGTH)]
        other = float(roots(pieces, 1)[0]) * UNIT / (2.0 * np.pi)
        rows.append(Row(name, {"first frequency (Hz)": (float(found.frequencies[0]) / (2.0 * np.pi), other)}))
    pluck = "initial.state=plucked", "initial.place=0.125", "initial.force=0.05", "contact.mu_static=0.8"
    history = run(_JAWS, *pluck, "end_time=0.3", "solver.free_step=1e-5", "solver.contact_step=1e-5")
    times, middle = history["time"].values, history["uy"].sel(station=0.125, method="nearest").values
    rises = np.flatnonzero((middle[:-1] < 0.0) & (middle[1:] >= 0.0))
    crosses = times[rises] - middle[rises] * np.diff(times)[rises] / np.diff(middle)[rises]
    found = (crosses.size - 1) / (crosses[-1] - crosses[0])
    rows.append(Row("sticks, let go from a pluck", {"first frequency (Hz)": (float(found), other)}))
    return rows


QUESTIONS = [
    Question(
        name="clamp-dashpot",
        title="A clamp that yields has a dashpot. How much faster does a vibration die with ten times the "
        "dashpot?",
        guess="ten times as fast",
        answer="up to the best one faster, {2[decay (1/s)]:.1f} for {0[decay (1/s)]:.1f}/s; beyond it six times "
        "slower, {4[decay (1/s)]:.1f}/s",
        wrong=True,
        cost=5900,
        price="a damper that is made strong and does nothing",
        why="A dashpot takes energy as its force times its motion. A weak one moves freely and has no force, a "
        "strong one holds the root as a rigid clamp does, and nothing moves. At the best, here 0.112 N m s/rad, "
        "a fifth of critical damping ({2[damping ratio]:.3f}) is all that this place can give.",
        command=_DASHPOT,
        cases="dashpot",
        beside="the determinant of the strip in closed form, at a complex frequency (`independent_secular.py`)",
        compute=clamp_dashpot,
        within=1e-4,
    ),
    Question(
        name="jaws",
        title="Two jaws hold the end of a strip at its faces. What does friction that sticks do to its first "
        "frequency?",
        guess="nothing, or 1 %: friction acts along the strip, and it vibrates across",
        answer="it makes {1[first frequency (Hz)]:.1f} Hz of {0[first frequency (Hz)]:.1f} Hz",
        wrong=True,
        cost=31,
        price="a frequency that is a third too low, from a model whose contacts are on the axis",
        why="At a hinge the section turns, so that its faces move along the jaws, one out and one in. Stick at "
        "two faces half a millimetre from the axis holds that, and of a hinge makes a clamp: at the very tip "
        "(4.730/3.927)² = 1.45 times. The normal forces, which press through the same points, hold the section "
        "by 1/200 of what it has in bending.",
        command=_JAWS,
        cases="contact",
        beside="the determinant of the strip in closed form, with a spring and a hinge or a clamp at the jaws",
        compute=jaws,
        within=2e-3,  # of the pluck, by which higher modes swing too
    ),
    Question(
        name="mass",
        title="To lower the second frequency of a cantilever most, does a mass go to its antinode inside of the "
        "span or to the tip?",
        guess="to the antinode",
        answer="a light one to the tip ({0[at the tip (Hz)]:.2f} against {0[at the antinode (Hz)]:.2f} Hz with 2 "
        "g), a heavy one to the antinode ({4[at the antinode (Hz)]:.1f} against {4[at the tip (Hz)]:.1f} Hz with "
        "the strip's own mass)",
        wrong=True,
        cost=25,
        price="the place that is right for a sensor is wrong for a weight",
        why="A light mass lowers a frequency by its kinetic energy in the mode as it is, and the tip moves 1.4 "
        "times as far as the antinode. A heavy one becomes a point that stands still: at the tip a hinge, whose "
        "15.4 is not far from 22.0, at the antinode one that leaves half of the strip to swing on its own. Both "
        "are equal at 12 g, a third of the strip.",
        command=_MASS,
        cases="mass",
        beside="the determinant of the strip in closed form",
        compute=mass,
        within=1e-5,
    ),
    Question(
        name="peg",
        title="Where does one peg raise the first frequency of a cantilever most?",
        guess="at the tip, 4.4 times",
        answer="at {2[over that without]:.2f} times under the node of its second mode, 0.783 L; at 0.99 L it is "
        "{5[over that without]:.2f} times",
        wrong=True,
        cost=43,
        price="30 % of the frequency that the same peg gives elsewhere",
        why="A support cannot raise the first frequency beyond the second one that the beam has without it "
        "(Courant). It does so just where the second mode has its node, because that mode does not feel it. "
        "Farther out the inner span is longer than it need be, farther in the end beyond swings by itself.",
        command=_PEG,
        cases="peg at",
        beside="the determinant of the strip in closed form",
        compute=peg,
        within=2e-3,
    ),
]
