"""Orders of the integrators, on closed forms and on the beam itself."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import cache

import numpy as np
from scipy.integrate import solve_ivp

from oblique_impact import EventScheme, FixedStepScheme, GeneralizedAlphaScheme, Scheme, simulate_system
from oblique_impact.contact.friction import ModifiedCoulomb
from oblique_impact.contact.stops import ElasticStop
from oblique_impact.validation.checks.registry import Measurement, checks_of
from oblique_impact.validation.runs import FEM, FRICTIONLESS, MEAN_AXIS, NEAR, SPRING, Array, event_times, run
from oblique_impact.validation.small_systems import Particle, PinnedBar

check = checks_of("orders", "Order of every integrator")

_PENDULUM = PinnedBar(mass=1.0, length=1.5, gravity=9.8, slope=0.0, offset=0.0)
_START, _END = 0.6, 0.3  # rad, s: before it meets the slope


@cache
def _exact_pendulum(end: float) -> tuple[float, float]:
    """Angle and speed of the falling bar, theta'' = -1.5 g cos(theta)/L, by SciPy's DOP853."""

    def rate(t: float, y: Array) -> list[float]:
        return [y[1], -1.5 * 9.8 / 1.5 * np.cos(y[0])]

    solution = solve_ivp(rate, (0.0, end), [_START, 0.0], method="DOP853", rtol=1e-13, atol=1e-14)
    return float(solution.y[0, -1]), float(solution.y[1, -1])


def _free_error(scheme: Scheme) -> float:
    stop = ElasticStop(1.0)  # far away; generalized-alpha takes no rigid one
    history = simulate_system(_PENDULUM, np.array([_START]), np.zeros(1), _END, scheme=scheme, contact_law=stop)
    angle, speed = _exact_pendulum(_END)
    return float(max(abs(history["q"].values[-1, 0] - angle), abs(history["qd"].values[-1, 0] - speed)))


def _sliding_error(scheme: Scheme) -> float:
    """A block on a spring slides, x'' = -9 x - 0.3 9.8, under the smoothed law, which has no stick state."""
    stop = ElasticStop(1e4)  # which holds the weight from the start on
    block, start = Particle(above=-9.8, stiffness=9.0), (np.array([0.1, -9.8e-4]), np.array([2.0, 0.0]))
    history = simulate_system(block, *start, 0.3, friction=ModifiedCoulomb(0.3), scheme=scheme, contact_law=stop)
    centre = -0.3 * 9.8 / 9.0
    return float(abs(history["slip"][-1] - centre - (0.1 - centre) * np.cos(0.9) - 2.0 / 3.0 * np.sin(0.9)))


def _event_error(h: float) -> float:
    """Largest error on x'' = -16 x over 6 s of steps of `h`, at a tolerance that allows longer ones."""
    spring, start = Particle(above=0.0, stiffness=16.0), (np.array([1.0, 1.0]), np.zeros(2))
    ends = tuple(h * np.arange(1, round(6.0 / h)))
    history = simulate_system(spring, *start, 6.0, scheme=EventScheme(1.0), breakpoints=ends, output_interval=h)
    return float(np.abs(history["q"].values[:, 0] - np.cos(4.0 * history["time"].values)).max())


_RK, _ALPHA_ORDER = FixedStepScheme.order, GeneralizedAlphaScheme.order
#: error over the step, the order that the scheme declares, the largest step
_CASES: dict[str, tuple[Callable[[float], float], float, float]] = {
    "fixed-step": (lambda h: _free_error(FixedStepScheme(h, h)), _RK, 0.02),
    "fixed-step-contact": (lambda h: _sliding_error(FixedStepScheme(1.0, h)), _RK, 0.015),
    "event": (_event_error, EventScheme.order, 0.3),
    "generalized-alpha-rho-0": (lambda h: _free_error(GeneralizedAlphaScheme(h, h, 0.0)), _ALPHA_ORDER, 0.01),
    "generalized-alpha-rho-0.8": (lambda h: _free_error(GeneralizedAlphaScheme(h, h, 0.8)), _ALPHA_ORDER, 0.01),
    "generalized-alpha-rho-1": (lambda h: _free_error(GeneralizedAlphaScheme(h, h, 1.0)), _ALPHA_ORDER, 0.01),
    "generalized-alpha-contact": (
        lambda h: _sliding_error(GeneralizedAlphaScheme(1.0, h, 0.5)),
        _ALPHA_ORDER,
        0.015,
    ),
}


@check("A falling bar and a sliding block: each scheme converges at the order it declares.", seconds=1.5)
def small_systems() -> Iterator[Measurement]:
    """Slopes of the error over the step, in free motion and in contact."""
    text = (
        "the order that the scheme declares: 4 of the classical Runge-Kutta method, 8 of DOP853 (Hairer, "
        "Norsett and Wanner, Solving Ordinary Differential Equations I, 1993, Sec. II.5), 2 of "
        "generalized-alpha (Chung and Hulbert, J. Appl. Mech. 60, 1993)"
    )
    for name, (error, order, largest) in _CASES.items():
        steps = largest * np.array([1.0, 0.5, 0.25])
        errors = np.array([error(h) for h in steps.tolist()])
        slope = float(np.polyfit(np.log(steps), np.log(errors), 1)[0])
        yield Measurement(f"observed order, {name}", slope, order, "1", 0.2, text, name)


#: contacts with an elastic stop after 0.02, 1.6 and 2.8 ms
# elements and all their modes are the same system without what both leave out of the beam
_CONTACTS = (
    *NEAR,
    *(SPRING, FRICTIONLESS),
    "end_time=2.95e-3",
)
_PLAIN = "contact.residual_flexibility=false"
_MESH = (MEAN_AXIS, FEM, "discretization.elements=2")
#: model, keys of generalized-alpha, those of the event scheme (all modes of the full mesh), rho_infinity
_NODAL = "nodal", (*_MESH, "discretization.modes=0"), (*_MESH, "discretization.modes=4", _PLAIN)
_ALPHA: tuple[tuple[str, tuple[str, ...], tuple[str, ...], float], ...] = (
    (*_NODAL, 0.0),
    (*_NODAL, 0.8),
    (*_NODAL, 1.0),
    *(
        (model, (*keys, _PLAIN), (*keys, _PLAIN), rho)
        for model, keys, rho in (
            ("mean-axis", (MEAN_AXIS, "discretization.modes=4"), 0.8),
            ("tangent", ("discretization.modes=2",), 0.5),
            ("full", ("discretization.modes=3", "discretization.kinetics=full"), 0.8),
        )
    ),
)


def _end_of(*keys: str) -> Array:
    """Place (m) and velocity (m/s) of the contact point at the end, and impulse of the contacts (N s)."""
    history = run("paper", *_CONTACTS, *keys)
    impulse = sum(c["normal_impulse"] for c in history.summary["macro_collisions"])
    return np.array([float(history["tip_y"][-1]), float(history["tip_vy"][-1]), impulse])


@check("The beam through elastic impacts by generalized-alpha: order 2, in each model.", seconds=1.5)
def beam_alpha() -> Iterator[Measurement]:
    """Position, velocity and impulse after two contacts and in a third, against the event scheme at 1e-11."""
    steps = (4e-6, 2e-6, 1e-6)
    ceilings = (("position", "m", 1e-7), ("velocity", "m/s", 2e-3), ("impulse", "N s", 2e-5))
    text = "Chung and Hulbert 1993; Arnold and Bruels 2007; the event scheme at a tolerance of 1e-11"
    for model, keys, located, rho in _ALPHA:
        exact = _end_of(*located, "solver.tolerance=1e-11")
        scheme = ("solver.scheme=generalized-alpha", f"solver.rho_infinity={rho}")
        marched = [_end_of(*keys, *scheme, f"solver.free_step={h}", f"solver.contact_step={h}") for h in steps]
        errors = np.abs(np.array(marched) - exact)
        for k, (name, unit, ceiling) in enumerate(ceilings):
            order = float(np.log2(errors[0, k] / errors[2, k]) / 2.0)
            quantity, tail = f"{name}, {model}, rho {rho:g}", f"{model}-rho{rho:g}-{name}"
            yield Measurement(f"observed order, {quantity}", order, 2.0, "1", 0.3, text, tail)
            yield Measurement(
                f"error at 1 µs, {quantity}", errors[2, k], 0.0, unit, ceiling, text, f"{tail}-error"
            )


@check("Event times do not depend on the tolerance of the event scheme.", seconds=1.0)
def event_tolerance() -> Iterator[Measurement]:
    """First macro-collision at 1e-8 and at the default 1e-10 against 1e-12."""
    exact = event_times(run("paper", "end_time=0.335", "solver.tolerance=1e-12"))
    for tolerance, allowed in ((1e-8, 1.2e-11), (1e-10, 2.5e-13)):
        times = event_times(run("paper", "end_time=0.335", f"solver.tolerance={tolerance}"))
        worst, name = float(np.abs(times - exact).max()), f"{tolerance:g}"
        yield Measurement(f"largest distance at {name}", worst, 0.0, "s", allowed, "the same at 1e-12", name)
