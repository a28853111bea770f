"""From a scenario, or a system of one's own, to a history."""

from __future__ import annotations

import platform
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict
from functools import partial
from importlib.metadata import PackageNotFoundError, version
from typing import Any

import numpy as np
import xarray as xr

from oblique_impact.beam import Beam, Energies
from oblique_impact.contact import State
from oblique_impact.fields import BLOCK, Fields, FieldsAhead, Motion
from oblique_impact.floating_frame import supplied_power_beam
from oblique_impact.friction import FrictionLaw, Frictionless, friction_law
from oblique_impact.history import History, labelled
from oblique_impact.integrators import EventScheme, FixedStepScheme, GeneralizedAlphaScheme, Scheme
from oblique_impact.integrators.base import Tolerances
from oblique_impact.ledger import balance, macro_collisions
from oblique_impact.marching import Problem, Record, Run, Segment, Status, default_tolerances
from oblique_impact.nodal import FullBeam
from oblique_impact.nodal_frame import definiteness, new_nodal_work, supplied_power_nodal
from oblique_impact.operators import build_operators
from oblique_impact.plugins import discretization
from oblique_impact.scenario import Scenario
from oblique_impact.stops import Stop, stop_of
from oblique_impact.system import (
    GAP,
    GAP_RATE,
    LAMBDA_N,
    LAMBDA_T,
    SLIP,
    SLIP_RATE,
    Array,
    MechanicalSystem,
)
from oblique_impact.transitions import Baumgarte, ContactMachine, ImpactLaw, NewtonImpact, RouthImpact

#: flights closer to the slope than this part of the length take generalized-alpha's contact step
NEAR = 0.01
#: part of the tolerance that the iterations of one implicit step may leave: what they leave adds up
ITERATIONS = 0.01

ProgressCallback = Callable[[Status], None]

_REPORTED_PACKAGES = ("oblique-impact", "numpy", "scipy", "numba", "scikit-fem", "xarray")


def simulate(scenario: Scenario, on_progress: ProgressCallback | None = None) -> History:
    """Run a scenario and return its history, whatever the named outcome.

    Parameters
    ----------
    scenario : Scenario
        What to simulate.
    on_progress : callable, optional
        Called with a :class:`~oblique_impact.marching.Status` several times per run.

    Returns
    -------
    History
        Samples, events and summary; `outcome` says how the run ended, which is no error.

    Examples
    --------
    >>> from oblique_impact import Scenario, simulate
    >>> history = simulate(Scenario.builtin("paper"))
    >>> float(history["theta"][-1])  # doctest: +SKIP
    """
    full = _full_beam(scenario)
    beam = Beam(scenario, full.operators.beam if full else build_operators(scenario))
    problem = full_beam_problem(full) if full else beam_problem(beam)
    ahead = _Ahead(beam, Record(), 0 if full else problem.q0.size, on_progress)
    run = Run(problem, ahead)
    ahead.record = run.record
    started = time.perf_counter()
    record = run.execute()
    wall = time.perf_counter() - started - ahead.seconds
    samples = _Samples(record.segments, problem.q0.size)
    energies = (full or beam).energies(samples.q, samples.qd)
    if full:
        samples.transform(full.split)
    data = samples.dataset(energies).merge(_beam_variables(beam, samples, ahead.fields.along(samples.motion())))
    summary = _summary(record, samples, energies, wall, problem.machine.stop)
    summary["warnings"] = _warnings(beam, samples)
    return History(data, record.events, summary, scenario.to_toml())


def simulate_system(
    system: MechanicalSystem,
    q0: Array,
    qd0: Array,
    end_time: float,
    *,
    friction: FrictionLaw | None = None,
    impact: ImpactLaw | None = None,
    scheme: Scheme | None = None,
    output_interval: float = 1e-2,
    baumgarte: Baumgarte = Baumgarte(0.0, 0.0),
    tolerances: Tolerances = Tolerances(),
    stop: Stop | None = None,
    breakpoints: tuple[float, ...] = (),
    on_progress: ProgressCallback | None = None,
) -> History:
    """Run a small system of one's own, in plain Python, through the same states and schemes.

    Parameters
    ----------
    system : MechanicalSystem
        Mass matrix, forces and contact rows.
    q0, qd0 : ndarray, shape (d,)
        Initial coordinates and velocities.
    end_time : float
        s.
    friction, impact, scheme, stop : optional
        Laws, marching scheme and an elastic stop; default frictionless, plastic, event-located, rigid.

    Returns
    -------
    History
        Without the variables that only a beam has.
    """
    chosen = scheme or EventScheme(1e-10)
    machine = ContactMachine(
        friction or Frictionless(), impact or NewtonImpact(), baumgarte, tolerances, chosen.stepwise, stop
    )
    problem = Problem(
        system,
        np.asarray(q0, dtype=float),
        np.asarray(qd0, dtype=float),
        machine,
        chosen,
        end_time,
        output_interval,
        breakpoints=breakpoints,
    )
    started = time.perf_counter()
    record = Run(problem, on_progress).execute()
    wall = time.perf_counter() - started
    samples = _Samples(record.segments, system.size)
    rows = [system.energy(t, q, qd) for t, q, qd in zip(samples.time, samples.q, samples.qd, strict=True)]
    energies = Energies(*np.array(rows, dtype=float).reshape(-1, 3).T)
    summary = _summary(record, samples, energies, wall, stop)
    return History(samples.dataset(energies), record.events, summary)


def alpha_scheme(scenario: Scenario, weight: float) -> GeneralizedAlphaScheme:
    """Generalized-alpha on compiled kernels; flights within a hundredth of the length take the contact step.

    The tolerance of its iterations is relative to the energy of the beam's `weight` (N) over its length, and small
    enough (`ITERATIONS`) that what they leave does not add up to more over the many steps of a run.
    """
    from oblique_impact.integrators import kernels

    v = scenario.solver
    near = NEAR * scenario.beam.length if scenario.contact.enabled else 0.0
    tolerance = ITERATIONS * v.tolerance * float(np.sqrt(weight * scenario.beam.length))
    return GeneralizedAlphaScheme(
        v.free_step, min(v.contact_step, v.free_step), v.rho_infinity, near, tolerance, kernels.march_alpha
    )


def _full_beam(scenario: Scenario) -> FullBeam | None:
    """Return the nodal beam that a scenario marches without reduction, if it does."""
    chosen = scenario.discretization
    if chosen.modes > 0 or scenario.solver.scheme != "generalized-alpha":
        return None
    return FullBeam(scenario, discretization(chosen.method).build_nodal(scenario))


def contact_machine(scenario: Scenario, stepwise: bool, weight: float) -> ContactMachine:
    """Return the transition table of a scenario; `weight` (N) is the scale of its forces."""
    v, c = scenario.solver, scenario.contact
    return ContactMachine(
        scenario.part("friction") or friction_law(c.friction, c.mu_static, c.mu_kinetic, c.regularization),
        scenario.part("impact") or _impact_law(scenario),
        Baumgarte.from_parameters(*v.baumgarte, v.baumgarte_form),
        default_tolerances(scenario.beam.length, weight)._replace(flight=v.free_step if stepwise else 0.0),
        stepwise,
        stop_of(scenario),
    )


def _impact_law(scenario: Scenario) -> ImpactLaw:
    """Return the built-in impact law of a scenario."""
    c = scenario.contact
    if c.impact == "newton":
        return NewtonImpact(c.restitution)
    return RouthImpact(0.0 if c.friction == "frictionless" else c.mu_kinetic, c.restitution)


def full_beam_problem(full: FullBeam) -> Problem:
    """Put a nodal beam, generalized-alpha and the laws together for the loop, on compiled kernels."""
    from oblique_impact.integrators import kernels

    s, model = full.scenario, full.model
    weight = full.operators.beam.sections.mass * max(s.gravity, 1.0)
    scheme = alpha_scheme(s, weight)
    q0, qd0 = full.initial_state()
    return Problem(
        model,
        q0,
        qd0,
        contact_machine(s, scheme.stepwise, weight),
        scheme,
        s.end_time,
        s.solver.output_interval,
        contact=s.contact.enabled,
        observer=kernels.observe_kept_into,
        condenser=kernels.condense_at,
        supply=supplied_power_nodal,
        allocate=new_nodal_work,
        inertia=partial(definiteness, model),
    )


def beam_problem(beam: Beam) -> Problem:
    """Put a beam, its scheme and its laws together for the loop, on compiled kernels."""
    from oblique_impact.integrators import kernels

    s = beam.scenario
    v = s.solver
    scheme: Scheme
    weight = beam.operators.mass_per_length * s.beam.length * max(s.gravity, 1.0)
    own = s.part("scheme")
    if own is not None:
        scheme = own
    elif v.scheme == "fixed-step":
        scheme = FixedStepScheme(v.free_step, v.contact_step, kernels.march_fixed)
    elif v.scheme == "generalized-alpha":
        scheme = alpha_scheme(s, weight)
    else:
        scheme = EventScheme(v.tolerance, kernels.march_event)
    machine = contact_machine(s, scheme.stepwise, weight)
    q0, qd0 = beam.initial_state()
    return Problem(
        beam.model,
        q0,
        qd0,
        machine,
        scheme,
        s.end_time,
        v.output_interval,
        contact=s.contact.enabled,
        breakpoints=beam.breakpoints,
        observer=kernels.observe_kept_into if v.scheme == "generalized-alpha" else kernels.observe_into,
        condenser=kernels.condense_at,
        supply=supplied_power_beam,
    )


class _Ahead:
    """The progress of a run: results along the beam are computed on the way, in `seconds` of wall time.

    With `size` 0 nothing is: the coordinates of the nodal beam are transformed at the end.
    """

    def __init__(self, beam: Beam, record: Record, size: int, on_progress: ProgressCallback | None) -> None:
        self.fields = FieldsAhead(beam)
        self.seconds = 0.0
        self.record = record
        self._size, self._on_progress, self._taken = size, on_progress, 0

    def __call__(self, status: Status) -> None:
        started = time.perf_counter()
        segments = self.record.segments[self._taken :]
        if self._size and sum(segment.times.size for segment in segments) >= BLOCK:
            self.fields.take(_Samples(segments, self._size).motion())
            self._taken += len(segments)
        self.seconds += time.perf_counter() - started
        if self._on_progress:
            self._on_progress(status)


class _Samples:
    """All samples of a record in one piece."""

    def __init__(self, segments: Sequence[Segment], size: int) -> None:
        states = np.concatenate([s.states for s in segments])
        self.time = np.concatenate([s.times for s in segments])
        self.q, self.qd = states[:, :size].copy(), states[:, size : 2 * size].copy()
        self.quadratures = states[:, 2 * size :]
        self.state = np.concatenate([np.full(s.times.size, s.state, dtype=np.int8) for s in segments])
        self.qdd = np.concatenate([s.observation.qdd for s in segments])
        self.scalars = np.concatenate([s.observation.scalars for s in segments])

    def transform(self, linear: Callable[[Array], Array]) -> None:
        """Replace the coordinates by a linear map of them."""
        self.q, self.qd, self.qdd = linear(self.q), linear(self.qd), linear(self.qdd)

    def motion(self) -> Motion:
        """Return the samples as the beam's post-processing takes them."""
        return Motion(self.time, self.q, self.qd, self.qdd, self.scalars[:, LAMBDA_N], self.scalars[:, LAMBDA_T])

    def dataset(self, energies: Energies) -> xr.Dataset:
        """Variables that every system has."""
        k, one, each = self.scalars, ("time",), ("time", "coordinate")
        state = labelled(self.state, one, "1", "contact state")
        state.attrs["flag_values"] = np.array([int(s) for s in State], dtype=np.int8)
        state.attrs["flag_meanings"] = " ".join(s.name.lower() for s in State)
        return xr.Dataset(
            {
                "q": labelled(self.q, each, "m or rad", "generalized coordinates"),
                "qd": labelled(self.qd, each, "m/s or rad/s", "generalized velocities"),
                "gap": labelled(k[:, GAP], one, "m", "normal gap"),
                "slip": labelled(k[:, SLIP], one, "m", "tangential position on the slope"),
                "gap_rate": labelled(k[:, GAP_RATE], one, "m/s", "gap rate"),
                "slip_rate": labelled(k[:, SLIP_RATE], one, "m/s", "slip velocity"),
                "lambda_n": labelled(k[:, LAMBDA_N], one, "N", "normal contact force"),
                "lambda_tau": labelled(k[:, LAMBDA_T], one, "N", "tangential contact force"),
                "state": state,
                "energy_kinetic": labelled(energies.kinetic, one, "J", "kinetic energy"),
                "energy_elastic": labelled(energies.elastic, one, "J", "elastic energy"),
                "energy_gravity": labelled(energies.gravity, one, "J", "gravity energy"),
            },
            coords={"time": labelled(self.time, one, "s", "time")},
        )


def _beam_variables(beam: Beam, samples: _Samples, fields: Fields) -> xr.Dataset:
    o = beam.operators
    radius = o.hub_radius + o.contact_point
    theta, B, Bd = samples.q[:, 0], samples.q[:, 1:], samples.qd[:, 1:]
    flat = 0.0 if beam.scenario.discretization.kinetics == "zeroth-order" else 1.0
    HB = flat * (B @ o.contact_shortening)
    ux, ux_rate = -0.5 * np.einsum("si,si->s", HB, B), -np.einsum("si,si->s", HB, Bd)
    uy, uy_rate = B @ o.contact_shape, Bd @ o.contact_shape
    spin, sine, cosine = samples.qd[:, 0], np.sin(theta), np.cos(theta)
    axial, transverse = ux_rate - spin * uy, uy_rate + spin * (radius + ux)
    arm = radius + ux
    one, along = ("time",), ("time", "station")
    return xr.Dataset(
        {
            "theta": labelled(theta, one, "rad", "angle of the floating frame"),
            "theta_dot": labelled(spin, one, "rad/s", "angular velocity of the floating frame"),
            "tip_x": labelled(arm * cosine - uy * sine, one, "m", "contact point, inertial x"),
            "tip_y": labelled(arm * sine + uy * cosine, one, "m", "contact point, inertial y"),
            "tip_vx": labelled(axial * cosine - transverse * sine, one, "m/s", "contact point velocity, x"),
            "tip_vy": labelled(axial * sine + transverse * cosine, one, "m/s", "contact point velocity, y"),
            "deflection": labelled(uy, one, "m", "transverse deflection of the contact point"),
            "shortening": labelled(ux, one, "m", "axial displacement of the contact point (foreshortening)"),
            "ux": labelled(fields.ux, along, "m", "axial displacement in the floating frame"),
            "uy": labelled(fields.uy, along, "m", "transverse displacement in the floating frame"),
            "ux_dot": labelled(fields.ux_dot, along, "m/s", "rate of ux in the floating frame"),
            "uy_dot": labelled(fields.uy_dot, along, "m/s", "rate of uy in the floating frame"),
            "moment": labelled(fields.moment, along, "N m", "bending moment"),
            "shear": labelled(fields.shear, along, "N", "shear force, slope of the bending moment"),
            "axial_force": labelled(fields.axial_force, along, "N", "axial force, tension positive"),
            "bending_stress": labelled(fields.bending_stress, along, "Pa", "bending stress at the outer fibre"),
        },
        coords={"station": labelled(o.stations.points, ("station",), "m", "arc length from the root")},
    )


def _summary(
    record: Record, samples: _Samples, energies: Energies, wall: float, stop: Stop | None
) -> dict[str, Any]:
    parts = [float(e[-1]) for e in energies]
    stored = stop.energy(float(samples.scalars[-1, GAP])) if stop and samples.state[-1] != State.FREE else 0.0
    ledger = balance(
        float(sum(e[0] for e in energies)),
        (parts[0], parts[1], parts[2], stored),
        samples.quadratures[-1],
        record.events,
    )
    return {
        "outcome": record.outcome.label,
        "message": record.outcome.sentence,
        "end_time": float(samples.time[-1]),
        "macro_collisions": [asdict(m) for m in macro_collisions(record.contacts)],
        "events": len(record.events),
        "energy": ledger.as_dict(),
        "steps": record.steps,
        "rejected_steps": record.rejected,
        "wall_time": wall,
        "versions": {"python": platform.python_version(), **_versions()},
    }


def _versions() -> dict[str, str]:
    found = {}
    for name in _REPORTED_PACKAGES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            continue
    return found


def _warnings(beam: Beam, samples: _Samples) -> list[str]:
    """Say where the model leaves its range of validity."""
    largest = float(np.max(np.abs(samples.q[:, 1:] @ beam.operators.stations.values.T), initial=0.0))
    length = beam.scenario.beam.length
    if largest > 0.1 * length:
        return [
            f"largest deflection {largest:.3g} m is more than a tenth of the length: "
            "the small-deflection model is stretched beyond its range"
        ]
    return []
