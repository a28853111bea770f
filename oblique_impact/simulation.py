"""From a scenario, or a user-defined system, to a history."""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import partial

import numpy as np

from oblique_impact.beam.clearance import closest
from oblique_impact.beam.floating_frame import supplied_power_beam
from oblique_impact.beam.frequencies import macro_gap
from oblique_impact.beam.nodal import FullBeam
from oblique_impact.beam.nodal_frame import definiteness, new_nodal_work, supplied_power_nodal
from oblique_impact.beam.operators import build_operators
from oblique_impact.beam.plausibility import doubts
from oblique_impact.beam.reduced import Beam, Energies
from oblique_impact.contact.friction import FrictionLaw, Frictionless, friction_law
from oblique_impact.contact.stops import Stop, stop_of
from oblique_impact.contact.transitions import Baumgarte, ContactMachine, ImpactLaw, NewtonImpact, RouthImpact
from oblique_impact.errors import Interrupted, Outcome
from oblique_impact.history.history import History
from oblique_impact.history.samples import beam_variables, gather, warnings_of
from oblique_impact.history.summary import summarize
from oblique_impact.history.variables import dataset
from oblique_impact.kernels.system import Array, MechanicalSystem
from oblique_impact.marching import EventScheme, FixedStepScheme, GeneralizedAlphaScheme, Scheme
from oblique_impact.marching.loop import Problem, Record, Run, Status, default_tolerances
from oblique_impact.marching.scheme import Tolerances
from oblique_impact.scenario.scenario import Scenario, require_scenario
from oblique_impact.scenario.user_defined import discretization

ProgressCallback = Callable[[Status], None]

#: flights closer to the slope than this part of the length take generalized-alpha's contact step
NEAR = 0.01
#: part of the tolerance that the iterations of one implicit step may leave: what they leave adds up
ITERATIONS = 0.01


def simulate(scenario: Scenario, on_progress: ProgressCallback | None = None) -> History:
    """Run a scenario and return its history, whatever the named outcome.

    Parameters
    ----------
    scenario : Scenario
        What to simulate.
    on_progress : callable, optional
        Called with a :class:`~oblique_impact.marching.loop.Status` several times per run.

    Returns
    -------
    History
        Samples, events and summary; `outcome` says how the run ended, which is no error.

    Raises
    ------
    InputError
        If this is no scenario.
    Interrupted
        After Ctrl-C; a KeyboardInterrupt whose `history` holds what was computed until then.

    Examples
    --------
    >>> from oblique_impact import Scenario, simulate
    >>> history = simulate(Scenario.builtin("paper"))
    >>> float(history["theta"][-1])  # doctest: +SKIP
    """
    require_scenario(scenario, "simulate")
    full = _full_beam(scenario)
    beam = Beam(scenario, full.operators.beam if full else build_operators(scenario))
    problem = full_beam_problem(full) if full else beam_problem(beam)
    record, wall = _march(problem, on_progress)
    if full is None:
        samples = gather(record.segments, beam.size, lambda time, q, qd: beam.energies(q, qd))
    else:
        samples = gather(record.segments, full.size, lambda time, W, Wd: full.energies(W, Wd), full.split)
    record.segments.clear()  # the samples have copies
    variables = beam_variables(beam, samples)
    summary = summarize(record, samples, wall, macro_gap(scenario), problem.machine.stop, scenario)
    summary["clearance"] = closest(variables, scenario.beam.length)
    events = [event.time for event in record.events]
    summary["warnings"] = [*doubts(scenario), *warnings_of(beam, variables, events)]
    return _finished(History(dataset(variables), record.events, summary, scenario.to_toml(), record.contacts))


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
    macro_gap: float = 0.0,
    on_progress: ProgressCallback | None = None,
) -> History:
    """Run a small user-defined system, in plain Python, through the same states and schemes.

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
    macro_gap : float
        Contacts less than this apart (s) are one macro-collision; by default each contact is one, because a system
        without a beam has no period to compare with.

    Returns
    -------
    History
        Without the variables that only a beam has.

    Raises
    ------
    Interrupted
        After Ctrl-C, as :func:`simulate`.
    """
    chosen = scheme or EventScheme(1e-10)
    machine = ContactMachine(
        friction or Frictionless(), impact or NewtonImpact(), baumgarte, tolerances, chosen.stepwise, stop
    )
    q, qd = np.asarray(q0, dtype=float), np.asarray(qd0, dtype=float)
    problem = Problem(system, q, qd, machine, chosen, end_time, output_interval, breakpoints=breakpoints)
    record, wall = _march(problem, on_progress)

    def energies(time: Array, q: Array, qd: Array) -> Energies:
        rows = [system.energy(*sample) for sample in zip(time, q, qd, strict=True)]
        return Energies(*np.array(rows, dtype=float).reshape(-1, 3).T)

    samples = gather(record.segments, system.size, energies)
    summary = summarize(record, samples, wall, macro_gap, stop)
    return _finished(History(dataset(samples.variables()), record.events, summary, contacts=record.contacts))


def _march(problem: Problem, on_progress: ProgressCallback | None) -> tuple[Record, float]:
    """Run the loop; returns what it leaves and its wall time (s)."""
    started = time.perf_counter()
    record = Run(problem, on_progress).execute()
    return record, time.perf_counter() - started


def _finished(history: History) -> History:
    """Return a history; raises Interrupted with one that Ctrl-C has cut short, so that loops over runs end too."""
    if history.outcome is Outcome.INTERRUPTED:
        raise Interrupted(history)
    return history


def alpha_scheme(scenario: Scenario, weight: float) -> GeneralizedAlphaScheme:
    """Generalized-alpha on compiled kernels; flights within a hundredth of the length take the contact step.

    The tolerance of its iterations is relative to the energy of the beam's `weight` (N) over its length, and small
    enough (`ITERATIONS`) that what they leave does not add up to more over the many steps of a run.
    """
    from oblique_impact.marching import kernels

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
    from oblique_impact.marching import kernels

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
    from oblique_impact.marching import kernels

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
