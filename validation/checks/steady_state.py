"""Periodic response on a shaken base: an oscillator, free and with impacts, and a ball whose period doubles.

With one mode, in zeroth-order kinetics and across its base, a clamped beam is an oscillator of one degree of
freedom, u'' + 2 zeta w u' + w^2 u = -G (a + g) at its tip, with the participation G = phi(L) int phi dx/int phi^2
dx of its first mode.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Iterator
from functools import partial
from typing import Any

import numpy as np

from oblique_impact.scenario.scenario import Scenario
from oblique_impact.validation.checks.registry import Measurement, checks_of, within
from oblique_impact.validation.reference_values import VALUES, source
from oblique_impact.validation.studies.periodic import PeriodicSection, bracket_jump, steady_state

check = checks_of("periodic", "Periodic response")

_SETTLED = PeriodicSection(tolerance=1e-9, transient=4000)


#: frequency coefficient of the first mode of a clamped beam, and the integral of its mode of mean square 1
_BETA, _SIGMA = 1.8751040687119611, 0.7340955137589128
_PARTICIPATION = 2.0 * 2.0 * _SIGMA / _BETA
_ZETA, _RESTITUTION, _GAP, _ACCELERATION = 0.02, 0.6, 2e-3, 2.0  # -, -, m, m/s^2


def _oscillator(**changes: Any) -> Scenario:
    """The strip of the case `shaken` in one mode, with a rigid stop."""
    one_degree = {
        "gravity": 0.0,
        "beam__kelvin_voigt": 0.0,
        "slope__extent": [],
        "contact__normal": "rigid",
        "discretization__modes": 1,
        "discretization__kinetics": "zeroth-order",
    }
    return Scenario.builtin("shaken").adapted(**one_degree | changes)


_DAMPED: dict[str, Any] = {"beam__modal_damping_ratio": _ZETA, "base__acceleration": _ACCELERATION}


def _own_frequency() -> float:
    """First frequency of the strip (rad/s)."""
    beam = Scenario.builtin("shaken").model_dump()["beam"]
    stiffness, mass = beam["youngs_modulus"] * beam["second_moment"], beam["density"] * beam["area"]
    return float(_BETA**2 * math.sqrt(stiffness / mass) / beam["length"] ** 2)


def _response(rate: float) -> complex:
    """Complex amplitude H (m) of the tip without contact, u = Im(H exp(i W t)), at the rate W (rad/s)."""
    w = _own_frequency()
    return -_PARTICIPATION * _ACCELERATION / (w * w - rate * rate + 2j * _ZETA * w * rate)


@check("A one-mode strip that touches nothing: the harmonic response.", seconds=0.5)
def harmonic() -> Iterator[Measurement]:
    """Displacement at whole periods of the base, whose frequency is below, near and above the strip's own."""
    text = "closed form of the damped oscillator"
    for frequency in (10.0, 13.0, 20.0):
        history = steady_state(
            _oscillator(contact__enabled=False, base__frequency=frequency, **_DAMPED),
            settings=PeriodicSection(tolerance=1e-9, transient=4000, sample="tip_x"),
        )
        (sample,), exact = history.summary["periodic"]["samples"], _response(2.0 * math.pi * frequency)
        label, tail = f"tip at whole periods of {frequency:g} Hz", f"{frequency:g}"
        # a difference of 1e-9 between two periods, of which the vibration loses a tenth
        yield Measurement(label, sample, exact.imag, "m", 1e-8 * abs(exact), text, tail)


def _impact_orbit(frequency: float) -> tuple[float, float]:
    """Phase of the base (rad) and speed (m/s) of the one impact of a period, in closed form.

    Between two impacts u = exp(-d s) (C cos w_d s + D sin w_d s) + Im(H exp(i W t)), s = t - t_0.  That u is the
    gap at both ends, u' = V at the first and -V/e at the second gives D and V in proportion to C, and with Im(H
    exp(i W t_0)) = gap - C and its rate R C a quadratic equation for C.  Of its two orbits one can be stable.
    """
    e, w, rate = _RESTITUTION, _own_frequency(), 2.0 * math.pi * frequency
    decay, own, response = _ZETA * w, w * math.sqrt(1.0 - _ZETA**2), _response(rate)
    left, c, s = math.exp(-decay / frequency), math.cos(own / frequency), math.sin(own / frequency)
    d = (1.0 - left * c) / (left * s)
    first = own * d - decay
    second = left * (first * c - (decay * d + own) * s)
    speed = (first - second) * e / (1.0 + e)
    r = speed - first
    amplitude = np.roots([1.0 + (r / rate) ** 2, -2.0 * _GAP, _GAP**2 - abs(response) ** 2]).max()
    phase = math.atan2(_GAP - amplitude, amplitude * r / rate) - cmath.phase(response)
    return phase % (2.0 * math.pi), -amplitude * speed / e


@check("A one-mode strip on a rigid stop, once in each period: an impact oscillator.", seconds=0.5)
def impact_oscillator() -> Iterator[Measurement]:
    """Phase and speed of its impact, and what is lost in a period of what the base supplies."""
    text = "closed form of the orbit with one impact a period"
    for frequency in (14.0, 15.0):
        history = steady_state(
            _oscillator(contact__restitution=_RESTITUTION, base__frequency=frequency, **_DAMPED), settings=_SETTLED
        )
        (event,), energy = history.events, history.balance
        found = 2.0 * math.pi * frequency * event.time, -event.normal_velocity
        # the motion repeats to 1e-9 of itself, and settles by a half and more in each period
        for name, value, exact, unit in zip(
            ("phase", "speed"), found, _impact_orbit(frequency), ("rad", "m/s"), strict=True
        ):
            label = f"{name} of the impact at {frequency:g} Hz"
            yield Measurement(label, value, exact, unit, 2e-10 * exact, text, f"{name}-{frequency:g}")
        supplied, label = energy["supplied"], f"energy lost in a period at {frequency:g} Hz"
        lost, text_of_work = energy["lost_impact"] + energy["lost_damping"], "what the base supplies in it"
        yield Measurement(label, lost, supplied, "J", 2e-10 * supplied, text_of_work, f"energy-{frequency:g}")


@check("A beam without stiffness on a shaken table is the bouncing ball, whose period doubles.", seconds=1.5)
def bouncing_ball() -> Measurement:
    """The acceleration over g from which two flights alternate.

    Their difference squared, at 0.5, 1 and 1.5 % above it, goes to zero at the bifurcation; the parabola through
    them leaves 1e-6.  A flight of one period takes off with V = g T/2, which asks for a table velocity of V (1 -
    e)/(1 + e); the map of phase and velocity has the determinant e^2 and a multiplier of -1 where the table is
    accelerated by -2 g (1 + e^2)/(1 + e)^2.
    """
    e, above, squares = 0.5, (0.005, 0.01, 0.015), list[float]()
    exact = math.hypot(math.pi * (1.0 - e) / (1.0 + e), 2.0 * (1.0 + e * e) / (1.0 + e) ** 2)
    for part in above:
        ball = _oscillator(
            gravity=9.81,
            beam__youngs_modulus=2.1e3,  # its own period is 2e4 times that of the table
            initial__angle=0.0,
            slope__angle=0.0,
            slope__origin=[0.0, -2.6e-3],  # other falls end in chattering, which exists beside these flights
            contact__restitution=e,
            base__direction=math.pi / 2.0,
            base__frequency=30.0,
            base__acceleration=9.81 * exact * (1.0 + part),
        )
        one, other = steady_state(ball, settings=_SETTLED).summary["periodic"]["samples"]
        squares.append((one - other) ** 2)
    found = np.roots(np.polyfit(above, squares, 2))
    doubling = exact * (1.0 + float(found[np.argmin(np.abs(found))]))
    text = "closed form, as in Luo and Han, Nonlinear Dynamics 10 (1996)"
    return Measurement("acceleration over g at the period doubling", doubling, exact, "1", 5e-6 * exact, text)


#: the strip of `benchmarks/reference_harmonic_balance.py`: 0.5 m x 20 mm x 1 mm, with Rayleigh damping of 0.5 % in
#: its first two modes and a spring of 99 times its own stiffness 1 mm away
_BENDING, _MASS, _RATIO = 210e9 * 20e-3 * 1e-9 / 12.0, 7800.0 * 20e-6, 0.005  # N m^2, kg/m, -


def clearance_strip(drive: str, frequency: float) -> Scenario:
    """Return that strip under a base of 0.06 m/s^2 or a force of 2 mN at its tip, at a frequency (Hz)."""
    first, second = (z**2 * math.sqrt(_BENDING / _MASS) / 0.5**2 for z in (_BETA, 4.694091132974175))
    forces = [{"force": 2e-3, "frequency": frequency}] if drive == "force" else []
    base = {} if forces else {"acceleration": 0.06, "frequency": frequency, "direction": 0.0}
    return Scenario.from_dict(
        {
            "gravity": 0.0,
            "beam": {
                "length": 0.5,
                "area": 20e-6,
                "second_moment": 20e-3 * 1e-9 / 12.0,
                "density": 7800.0,
                "youngs_modulus": 210e9,
                "mass_proportional": 2.0 * _RATIO * first * second / (first + second),
                "kelvin_voigt": 2.0 * _RATIO / (first + second),
            },
            "root": {"kind": "driven"},
            "initial": {"angle": math.pi / 2.0},
            "base": base,
            "forces": forces,
            "slope": {"origin": [1e-3, 0.5], "angle": math.pi / 2.0},
            "contact": {
                "normal": "spring",
                "stiffness": 99.0 * 3.0 * _BENDING / 0.5**3,
                "friction": "frictionless",
            },
            "discretization": {"modes": 10, "kinetics": "zeroth-order"},
            "solver": {"tolerance": 1e-8, "output_interval": 5e-4},
        }
    )


@check("A strip with a clearance on one side, on a shaken base: harmonic balance.", seconds=25.0)
def clearance_base() -> Iterator[Measurement]:
    """Least and largest deflection where the motion repeats, the fold of the branch, where it has no period."""
    yield from _harmonic_balance("base")


@check("A strip with a clearance on one side, under a force at its tip: harmonic balance.", seconds=25.0)
def clearance_force() -> Iterator[Measurement]:
    """As on a shaken base."""
    yield from _harmonic_balance("force")


def _harmonic_balance(drive: str) -> Iterator[Measurement]:
    value, text, state = VALUES[f"clearance-{drive}"], source(f"clearance-{drive}"), None
    for frequency in (3.2, 4.2, 4.3, 4.4):  # each from the state of the one before: of two motions the larger one
        settings = PeriodicSection(tolerance=1e-6, sample="tip_x")
        state = steady_state(clearance_strip(drive, frequency), state, settings)
        periodic = state.summary["periodic"]
        ends = {"least": periodic["least"], "largest": periodic["largest"]}
        for (name, end), exact in zip(ends.items(), value["deflections"].get(f"{frequency:g}", ()), strict=False):
            label = f"{name} deflection at {frequency:g} Hz"
            # the spring's depth of up to 0.15 mm, of which 0.4 % are those of the modes left out
            yield Measurement(label, 1e3 * end, exact, "mm", 1e-3, text, f"{name}-{frequency:g}")
    assert state is not None
    settings = PeriodicSection(tolerance=1e-4, sample="tip_x")
    jump = bracket_jump(partial(clearance_strip, drive), (4.4, 4.5), state, settings, within=2e-4)
    found = 0.5 * (jump[0] + jump[1]) if jump else math.nan
    yield within("frequency of the fold", found, value["fold"], "Hz", 1e-3, text, "fold")
    history = steady_state(clearance_strip(drive, value["none"]), settings=settings)
    label = f"period at {value['none']:g} Hz from rest; 0: none up to 8"
    yield Measurement(label, history.summary["periodic"]["period"] or 0, 0.0, "1", 0.0, text, "none")
