"""Particles, belts and rods with friction, through the contact states that march the beam."""

from __future__ import annotations

from collections.abc import Iterator
from math import atan, ceil, cos, log, nan, pi, radians, sin, sqrt

import numpy as np
from scipy.interpolate import CubicHermiteSpline
from scipy.optimize import brentq

from oblique_impact import FixedStepScheme, History, simulate_system
from oblique_impact.contact.friction import Coulomb, Frictionless
from oblique_impact.contact.impacts import NewtonImpact, RouthImpact, routh_impulse
from oblique_impact.contact.state import Baumgarte
from oblique_impact.contact.stops import ElasticStop
from oblique_impact.contact.transitions import EventKind
from oblique_impact.validation.checks.registry import ROUNDING, Measurement, checks_of, within
from oblique_impact.validation.reference_values import VALUES, source
from oblique_impact.validation.small_systems import FreeRod, Particle, PinnedBar, events_of, samples_at

check = checks_of("small-systems", "Particles, belts and rods with friction")

#: relative: references have 12 digits, the first of which may be a 1
_DIGITS = 6e-12
_G, _SLOPE = 9.8, pi / 10
_INCLINE = Particle(above=-_G * cos(_SLOPE), along=-_G * sin(_SLOPE))
_BAR = PinnedBar(mass=0.86874, length=1.0, gravity=_G, slope=pi / 10, offset=0.3)


def _slide(
    system: Particle, along: float, speed: float, end: float, friction: Coulomb, output_interval: float = 1e-2
) -> History:
    start = np.array([along, 0.0]), np.array([speed, 0.0])
    return simulate_system(system, *start, end, friction=friction, output_interval=output_interval)


@check("A particle rests on an incline as long as mu_s >= tan(alpha), and slides with g (sin - mu cos) otherwise.")
def incline() -> Iterator[Measurement]:
    """The limit of rest from both sides, and the way in a given time."""
    limit, text = VALUES["6a"]["tan"], source("6a")
    sliding = 0.5 * VALUES["6a"]["a_mu02"] * 0.1**2
    for name, factor, exact in (("above", 1.0 + 1e-12, 0.0), ("below", 1.0 - 1e-12, sliding)):
        history = _slide(_INCLINE, 0.0, 0.0, 0.1, Coulomb(limit * factor, 0.2))
        way, quantity = -float(history["q"].values[-1, 0]), f"way in 0.1 s, mu_s just {name} the limit of rest"
        yield within(quantity, way, exact, "m", _DIGITS, text, name)
    history = _slide(_INCLINE, 0.0, 0.0, VALUES["6a"]["t_05m"], Coulomb(0.2, 0.2))
    way = -float(history["q"].values[-1, 0])
    yield within("way in the time for half a metre, mu = 0.2", way, 0.5, "m", _DIGITS, text, "way")


@check("A particle is thrown up an incline: it stops, and comes back only if friction is small.")
def thrown_up() -> Iterator[Measurement]:
    """Time and place of the stop, speed of return."""
    text, end = source("6b"), VALUES["6b"]["mu02"]["t_total"]
    for mu, key, kind in ((0.2, "mu02", EventKind.REVERSAL), (0.4, "mu04", EventKind.STICK)):
        expected, history = VALUES["6b"][key], _slide(_INCLINE, 0.0, 2.0, end, Coulomb(mu, mu))
        stop, exact = events_of(history, kind)[0].time, expected["t_stop"]
        yield within(f"time of the stop, mu = {mu}", stop, exact, "s", _DIGITS, text, f"time-{key}")
        place, exact = float(samples_at(history, stop)[0][0]), expected["d"]
        yield within(f"way up, mu = {mu}", place, exact, "m", _DIGITS, text, f"way-{key}")
        speed, exact = -float(history["qd"].values[-1, 0]), expected.get("v_return", 0.0)
        quantity = f"speed at the time of return, mu = {mu}"
        yield Measurement(quantity, speed, exact, "m/s", 1e-11, text, f"return-{key}")


@check("A mass on a spring rides a belt: it sticks and slips in a limit cycle.", seconds=0.5)
def belt() -> list[Measurement]:
    """Durations of slip and stick, ends of the way, and the largest speed against the belt."""
    system = Particle(above=-_G, stiffness=100.0, belt_speed=0.05)
    history = _slide(system, 0.0, 0.05, 3.0, Coulomb(0.4, 0.3), output_interval=1e-3)
    sticks = np.array([e.time for e in events_of(history, EventKind.STICK)])
    slips = np.array([e.time for e in events_of(history, EventKind.SLIP)])
    text, exact = source("6c"), VALUES["6c"]
    time, first = np.unique(history["time"].values, return_index=True)
    inside = (time >= slips[1]) & (time <= sticks[1])
    q, qd = history["q"].values[first, 0][inside], history["qd"].values[first, 0][inside]
    # between samples dt apart the cubic errs by (w dt)⁴/384 of the amplitude, a parabola's top by less
    place = CubicHermiteSpline(time[inside], q, qd)
    speed = CubicHermiteSpline(time[inside], qd, 0.3 * _G - 100.0 * q)
    ends = place(place.derivative().roots(extrapolate=False))
    slowest = float(speed(speed.derivative().roots(extrapolate=False)).min())
    return [
        Measurement("smallest displacement", ends.min(), exact["x_min"], "m", 2e-12, text, "x-min"),
        Measurement("largest displacement", ends.max(), exact["x_max"], "m", 2e-12, text, "x-max"),
        Measurement("smallest velocity", slowest, exact["v_min"], "m/s", 1e-11, text, "v-min"),
        within("duration of slip", sticks[1] - slips[1], exact["t_slip"], "s", _DIGITS, text, "slip"),
        within("duration of stick", slips[2] - sticks[1], exact["t_stick"], "s", _DIGITS, text, "stick"),
        within("period", slips[2] - slips[1], exact["period"], "s", _DIGITS, text, "period"),
    ]


@check("A ball bounces infinitely often in finite time and then lies still.", seconds=0.5)
def bouncing_ball() -> Iterator[Measurement]:
    """Time to rest for e = 0.5 and 0.8; bounces below four gap tolerances are the end."""
    text, gap = source("6e"), 1e-18
    heights = "closed form: heights fall like e^(2 n)"
    for e, key in ((0.5, "e05"), (0.8, "e08")):
        start, law = (np.array([0.0, 1.0]), np.zeros(2)), NewtonImpact(e)
        history = simulate_system(Particle(above=-_G), *start, 5.0, impact_law=law, gap_tolerance=gap)
        last = history.events[-1]
        left = 2.0 * sqrt(8.0 * gap / _G) / (1.0 - e) + 1e-11
        bounces, known = float(len(history.events) - 1), float(ceil(log(4.0 * gap) / (2.0 * log(e))) - 1)
        quantity = f"bounces higher than four tolerances, e = {e}"
        exact, first = VALUES["6e"], history.events[0].time
        of_first = _DIGITS * first
        way = 1.0 + 2.0 * sum((e * event.normal_velocity) ** 2 / (2.0 * _G) for event in history.events[:-1])
        left_way = 8.0 * gap / (1.0 - e**2) + 1e-11
        force = history["lambda_n"].values[history["time"].values > last.time].min()
        yield Measurement(f"first bounce, e = {e}", first, exact["first"], "s", of_first, text, f"first-{key}")
        yield Measurement(f"way, e = {e}", way, exact[f"dist_{key}"], "m", left_way, text, f"way-{key}")
        yield within(f"least force at rest, e = {e}", force, _G, "N", ROUNDING, "closed form: m g", f"rest-{key}")
        yield Measurement(f"time to rest, e = {e}", last.time, exact[key], "s", left, text, f"time-{key}")
        yield Measurement(quantity, bounces, known, "1", 0.0, heights, f"bounces-{key}")


@check("A mass on a spring is stopped by dry friction (VPCS SDND100, published).")
def dry_friction() -> list[Measurement]:
    """Extrema at multiples of pi/100 s."""
    history = _slide(Particle(above=-10.0, stiffness=1e4), 0.85e-3, 0.0, 0.2, Coulomb(0.1, 0.1))
    places = [float(samples_at(history, event.time)[0][0]) for event in history.events[1:]]
    return [
        Measurement(f"extremum {k + 1}", place, exact, "m", 3e-15, source("6g"), f"extremum-{k + 1}")
        for k, (place, exact) in enumerate(zip(places, VALUES["6g"], strict=True))
    ]


@check("A sliding rod: the forward problem has no solution inside of the Painlevé interval.")
def painleve() -> Iterator[Measurement]:
    """Edges of the interval where the effective inverse mass vanishes, mu = 1.5, and runs that stop there."""
    rod, text = FreeRod(gravity=_G), source("6d")

    def effective(angle: float) -> float:
        instant = rod.instant(rod.at(angle), rod.moving(angle, (-1.0, 0.0)))
        return instant.a_nn + 1.5 * instant.a_nt

    for edge, angle in zip(("lower", "upper"), VALUES["6d"]["interval_rad"], strict=True):
        quantity = f"effective inverse mass at the {edge} edge"
        yield Measurement(quantity, effective(angle), 0.0, "1/kg", 1e-11, text, edge)
    for degrees in (51.0, 60.0, 73.0):
        start = rod.at(radians(degrees)), rod.moving(radians(degrees), (-1.0, 0.0))
        summary = simulate_system(rod, *start, 0.5, friction=Coulomb(1.5, 1.5)).summary
        ended = summary["end_time"] if summary["outcome"] == "painleve" else nan
        quantity = f"end of a run from {degrees:g} degrees, by the outcome painleve"
        yield Measurement(quantity, ended, 0.0, "s", 0.0, text, f"ends-{degrees:g}")
    computed, exact = effective(atan(2.0)), VALUES["6d"]["mp_at_atan2"]
    yield Measurement("effective inverse mass at atan 2", computed, exact, "1/kg", ROUNDING, text, "atan2")


@check("A free rod strikes rough ground: impulses and velocities after, slipping and slipping into stick.")
def rod_impact() -> Iterator[Measurement]:
    """Routh's method with Poisson's restitution."""
    names = ("normal impulse", "tangential impulse", "tangential velocity", "normal velocity")
    units = ("N s", "N s", "m/s", "m/s")
    cases = {"slip": ("45,.3,2,-1,.5 slip", 0.3, 2.0), "stick": ("45,.8,-.5,-1,.5 slip-stick", 0.8, -0.5)}
    for name, (row, mu, slip) in cases.items():
        rod = FreeRod()
        instant = rod.instant(rod.at(pi / 4), rod.moving(pi / 4, (slip, -1.0)))
        impulse = routh_impulse(instant, 0.5, mu)
        after = (
            slip + instant.a_nt * impulse.normal + instant.a_tt * impulse.tangential,
            -1.0 + instant.a_nn * impulse.normal + instant.a_nt * impulse.tangential,
        )
        computed = (impulse.normal, impulse.tangential, *after)
        for k, (value, exact) in enumerate(zip(computed, VALUES["6f"][row], strict=True)):
            allowed, tail = max(_DIGITS * abs(exact), ROUNDING), f"{name}-{k + 1}"
            yield Measurement(f"{names[k]}, {name}", value, exact, units[k], allowed, source("6f"), tail)


@check(
    "A rigid pinned bar strikes the slope in a run: time, impulse and energy lost, plastic and with restitution."
)
def bar_impact() -> Iterator[Measurement]:
    """Closed forms of the pinned bar."""
    text, exact = source("6i"), VALUES["6i"]
    for mu, e in ((0.0, 0.0), (0.3, 0.0), (0.3, 0.5)):
        friction, start = Coulomb(mu, mu) if mu else Frictionless(), (np.array([pi / 4]), np.zeros(1))
        history = simulate_system(_BAR, *start, 0.318, impact_law=RouthImpact(mu, e), friction=friction)
        event, name = history.events[0], f"mu{mu:g}-e{e:g}"
        normal, tangential, lost = event.normal_impulse, event.tangential_impulse, event.energy_loss
        if e == 0.0:
            of_normal, of_tangential = exact["mu03" if mu else "mu0"], exact["Pt_mu03"] * mu / 0.3
            quantity, tail = f"tangential impulse, mu = {mu}", f"{name}-tangential"
            yield within(f"normal impulse, mu = {mu}", normal, of_normal, "N s", _DIGITS, text, f"{name}-impulse")
            yield Measurement(quantity, tangential, of_tangential, "N s", _DIGITS, text, tail)
            yield within(f"energy lost, mu = {mu}", lost, exact["KE"], "J", 1e-12, text, f"{name}-energy")
            yield within(f"time, mu = {mu}", event.time, VALUES["4"]["t"], "s", 5e-13, source("4"), f"{name}-time")
        else:
            omega, expected = float(samples_at(history, event.time)[1][0]), exact["e05_mu03"]["omega"]
            yield within("spin after, e = 0.5", omega, expected, "rad/s", _DIGITS, text, f"{name}-spin")


@check("A mass strikes a stop with Hunt-Crossley damping: the speed of its rebound.")
def hunt_crossley() -> Iterator[Measurement]:
    """From m v dv/dd = -k d (1 + c v): v/c - ln(1 + c v)/c² is the same at both ends of the contact."""
    speed = 3.0
    for c in (0.05, 0.2):

        def first_integral(v: float, c: float = c) -> float:
            return v / c - log(1.0 + c * v) / c**2

        exact = brentq(lambda v, f=first_integral: f(-v) - f(speed), 0.0, min(speed, 0.999 / c), xtol=1e-15)
        ball, stop = Particle(above=0.0, mass=2.0), ElasticStop(5e3, c)
        start = np.array([0.0, 0.3]), np.array([0.0, -speed])
        history = simulate_system(ball, *start, 0.5, contact_law=stop, output_interval=1e-2)
        rebound, text = float(history["qd"].values[-1, 1]), "closed form (Hunt and Crossley 1975)"
        yield Measurement(f"speed after, damping {c} s/m", rebound, exact, "m/s", 2.5e-12, text, f"c{c:g}")


@check("Fixed steps find a contact late; Baumgarte's stabilization pushes the penetration out.", seconds=1.0)
def baumgarte() -> Iterator[Measurement]:
    """A falling particle: after the impact Z'' + 2 chi Z' + beta² Z = 0 (or Z'' + chi Z' + beta Z = 0)."""
    text = "closed form of the damped oscillation from the penetration at the impact"
    chi, beta, after = 10.0, 1000.0, 1e-3
    # the squared form is stiff, the steps err; the plain one is exact but for rounding
    for form, allowed in (("squared", 7e-15), ("plain", 1e-18)):
        terms, scheme = Baumgarte.from_parameters(chi, beta, form), FixedStepScheme(1e-4, 1e-5)
        ball, at_rest = Particle(above=-_G), (np.array([0.0, 0.01]), np.zeros(2))
        history = simulate_system(ball, *at_rest, 0.06, scheme=scheme, baumgarte=terms, output_interval=1e-5)
        start = history.events[0].time
        depth = float(samples_at(history, start)[0][1])
        time = history["time"].values
        k = int(np.argmin(np.abs(time - start - after)))
        half, spring = (chi, beta**2) if form == "squared" else (0.5 * chi, beta)
        omega, t = sqrt(spring - half**2), time[k] - start
        exact = depth * np.exp(-half * t) * (cos(omega * t) + half / omega * sin(omega * t))
        gap, quantity = float(history["q"].values[k, 1]), f"gap 1 ms after the impact, {form} form"
        yield Measurement(quantity, gap, exact, "m", allowed, text, form)
