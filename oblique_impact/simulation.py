"""Simulate a scenario, or a small user-defined system, and return its history."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any
from warnings import warn

import numpy as np

from oblique_impact.beam.base_motion import BaseMotion
from oblique_impact.beam.beam import Beam, Energies
from oblique_impact.beam.operators import Discretization
from oblique_impact.beam.validity.integration import ambiguity_warnings
from oblique_impact.beam_problem import Parts, beam_of, beam_problem, system_scales
from oblique_impact.contact.compliance import Compliance
from oblique_impact.contact.decision import Decision
from oblique_impact.contact.friction import Coulomb, FrictionLaw, Frictionless
from oblique_impact.contact.impacts import ImpactLaw, NewtonImpact
from oblique_impact.contact.pairs import ContactPair
from oblique_impact.contact.state import Baumgarte
from oblique_impact.contact.stops import ContactLaw, ElasticStop
from oblique_impact.continuing import as_lists, begin_at
from oblique_impact.errors import InputError, Interrupted, Outcome, SimulationWarning
from oblique_impact.history.history import History, beam_history
from oblique_impact.history.samples import beam_variables, gather, section_forces
from oblique_impact.history.summary import summarize
from oblique_impact.history.variables import dataset
from oblique_impact.kernels.compiling import clock
from oblique_impact.kernels.system import MechanicalSystem
from oblique_impact.kernels.workspace import Array, own_numbers
from oblique_impact.marching.event import EventScheme
from oblique_impact.marching.loop import Run
from oblique_impact.marching.problem import Problem
from oblique_impact.marching.records import Record
from oblique_impact.marching.scheme import Scheme
from oblique_impact.marching.time_stepping import TimeSteppingScheme
from oblique_impact.progress import Status
from oblique_impact.resting import start_at_rest
from oblique_impact.scenario.scenario import Scenario, require_scenario

ProgressCallback = Callable[[Status], None]


def simulate(
    scenario: Scenario,
    on_progress: ProgressCallback | None = None,
    *,
    friction: FrictionLaw | None = None,
    contact_law: ContactLaw | None = None,
    impact_law: ImpactLaw | None = None,
    base_motion: BaseMotion | None = None,
    scheme: Scheme | None = None,
    discretization: Discretization | None = None,
    initial_state: History | tuple[Array, Array] | None = None,
) -> History:
    """Run a scenario and return its history, whatever the named outcome.

    Parameters
    ----------
    scenario : Scenario
        What to simulate.
    on_progress : callable, optional
        Called with a :class:`~oblique_impact.progress.Status` several times per run.
    friction, contact_law, impact_law, base_motion, scheme, discretization : optional
        User-defined parts, each in the place of the built-in one that the scenario names; see
        :class:`~oblique_impact.beam_problem.Parts`.
    initial_state : History or pair of ndarray, shape (coordinate,), optional
        In the place of what the section `initial` says: a history of the same beam, from whose end
        the run goes on with the contacts that are closed there; or coordinates and their rates at t = 0, as
        ``(history["q"][-1], history["qd"][-1])``, where contact begins anew: one that sticks holds where it now
        is, and nothing is stretched along the beam.  The beam is on the side of a peg on which that state has it.
        A driven root has the speed of its motion.

    Returns
    -------
    History
        Samples, events and summary; `outcome` says how the run ended, which is no error.

    Raises
    ------
    InputError
        If this is no scenario, a user-defined part does not fit it or returns arrays of the wrong kind, an
        initial state has the wrong shape or is for the exact beam, which takes none, or a beam that is to start at
        rest has no equilibrium.
    Interrupted
        After Ctrl-C; a KeyboardInterrupt whose `history` holds what was computed until then.

    Warns
    -----
    SimulationWarning
        For each entry of ``summary["warnings"]``.

    Examples
    --------
    >>> from oblique_impact import Scenario, simulate
    >>> history = simulate(Scenario.builtin("paper"))
    >>> float(history["theta"][-1])  # doctest: +SKIP
    """
    parts = Parts(friction, contact_law, impact_law, base_motion, scheme, discretization)
    return _warned(compute_history(scenario, on_progress, parts, initial_state))


def compute_history(
    scenario: Scenario,
    on_progress: ProgressCallback | None = None,
    parts: Parts = Parts(),
    initial_state: History | tuple[Array, Array] | None = None,
    stops: tuple[float, ...] = (),
    keeps_sides: bool = False,
) -> History:
    """Run a scenario as :func:`simulate` does, for callers that show the warnings in the summary themselves.

    A step ends at each of the `stops` (s), also where its length is given, and a sample is there if it is a
    multiple of the output interval.  A beam that `keeps_sides` is on those sides of points on which the scenario
    begins, also in coordinates in which it is pressed past them.
    """
    require_scenario(scenario, "simulate")
    parts.check(scenario)
    if scenario.is_absolute:
        from oblique_impact.fem_beam.exact import simulate as simulate_exact  # which is built on this package

        if initial_state is not None:
            raise InputError('initial_state: only with discretization.method = "modal" or "fem"')
        history = simulate_exact(scenario, on_progress, parts=parts)
    else:
        beam, problem = _prepared(scenario, parts, initial_state, keeps_sides)
        problem = replace(problem, breakpoints=(*problem.breakpoints, *stops))
        record, wall = _march(problem, on_progress)
        samples = gather(record.segments, beam.size, lambda time, q, qd: beam.energies(q, qd), beam.split)
        of_scenario = parts.discretization is None and parts.base_motion is None
        variables = beam_variables(beam, samples, of_scenario)
        forces = partial(section_forces, beam, samples.qdd, variables)
        history = beam_history(scenario, record, samples, variables, forces, wall, beam)
    given: dict[str, Any] = {name: repr(part) for name, part in parts.given().items()}
    if initial_state is not None:
        given["initial_state"] = as_lists(initial_state)
    if given:
        history.summary["provenance"]["user_defined"] = given
    return _unless_interrupted(history)


def check_scenario(scenario: Scenario) -> None:
    """Do all that a run does before it marches; raises InputError as :func:`simulate` does."""
    if scenario.is_absolute:
        from oblique_impact.fem_beam.exact import exact_problem  # which is built on this package

        exact_problem(scenario)
    else:
        _prepared(scenario, Parts())


def _prepared(
    scenario: Scenario,
    parts: Parts,
    initial_state: History | tuple[Array, Array] | None = None,
    keeps_sides: bool = False,
) -> tuple[Beam, Problem]:
    """Return the beam of a scenario in small deflections and its problem, with its start."""
    beam = beam_of(scenario, parts)
    start = None
    if initial_state is not None:
        start = begin_at(beam, initial_state, keeps_sides)
    elif scenario.initial.state != "undeformed":
        start = start_at_rest(beam, parts)
    problem = beam_problem(beam, parts)
    if start is not None:
        q0, qd0, earlier = start
        problem = replace(problem, q0=q0, qd0=qd0, earlier=earlier if scenario.contact.enabled else {})
    return beam, problem


def simulate_system(
    system: MechanicalSystem,
    q0: Array,
    qd0: Array,
    end_time: float,
    *,
    friction: FrictionLaw | None = None,
    contact_law: ContactLaw | None = None,
    impact_law: ImpactLaw | None = None,
    scheme: Scheme | None = None,
    output_interval: float = 1e-2,
    baumgarte: Baumgarte = Baumgarte(),
    extent: tuple[float, ...] = (),
    axial_flexibility: float = 0.0,
    gap_tolerance: float | None = None,
    breakpoints: tuple[float, ...] = (),
    clustering_time: float = 0.0,
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
    friction, contact_law, impact_law, scheme : optional
        Laws and marching scheme, as in :func:`simulate`; default: frictionless, a rigid stop, plastic impacts,
        events located.
    output_interval : float
        Time between samples (s).
    baumgarte : Baumgarte
        Stabilization of the contact constraints; default: none.
    extent : tuple of float
        Ends of the slope, [first, last] (m) along it; by default it has none.
    axial_flexibility : float
        Flexibility (m/N) without mass behind the friction, in series with it (Jenkins's element), with
        :class:`~oblique_impact.contact.friction.Coulomb` friction, on an
        :class:`~oblique_impact.contact.stops.ElasticStop` or, with events located and impacts without friction, on
        a rigid stop; a damped one only with events located or time-stepping.
    gap_tolerance : float, optional
        Gap (m) that counts as zero; default: 1e-12 of the length of the motion, see
        :func:`~oblique_impact.beam_problem.system_scales`.
    breakpoints : tuple of float
        Times (s) at which the forces are not smooth; steps end there.
    clustering_time : float
        Contacts less than this apart (s) are one macro-collision; by default each contact is one, because a system
        without a beam has no period to compare with.

    Returns
    -------
    History
        Without the variables that only a beam has.

    Raises
    ------
    InputError
        If an array of the system, of its state or of a user-defined scheme has the wrong shape or is not real,
        `axial_flexibility` or time-stepping is given with other laws, or a rigid stop with generalized-alpha.
    Interrupted
        After Ctrl-C, as :func:`simulate`.
    """
    if axial_flexibility != 0.0:
        elastic = isinstance(contact_law, ElasticStop)
        if isinstance(contact_law, ElasticStop) and (contact_law.damping or contact_law.linear_damping):
            elastic = isinstance(scheme or EventScheme(), EventScheme | TimeSteppingScheme)
        rigid = contact_law is None and isinstance(scheme or EventScheme(), EventScheme | TimeSteppingScheme)
        rigid = rigid and isinstance(impact_law or NewtonImpact(), NewtonImpact)
        if axial_flexibility < 0.0 or not ((elastic or rigid) and isinstance(friction, Coulomb)):
            stops = (
                "an ElasticStop, undamped but with EventScheme or TimeSteppingScheme, or with these a rigid stop"
            )
            words = f"should be at least 0, with Coulomb friction and {stops}"
            raise InputError(f"axial_flexibility = {axial_flexibility:g}: {words}")
    if isinstance(scheme, TimeSteppingScheme) and not isinstance(impact_law or NewtonImpact(), NewtonImpact):
        raise InputError("impact_law: should be a NewtonImpact with TimeSteppingScheme, which has no other")
    if isinstance(scheme, TimeSteppingScheme) and not isinstance(contact_law or ElasticStop(1.0), ElasticStop):
        raise InputError("contact_law: should be an ElasticStop with TimeSteppingScheme, which has no other")
    q0, qd0 = own_numbers(q0, (system.size,), "q0"), own_numbers(qd0, (system.size,), "qd0")
    system = _checked(system, q0, qd0)
    scheme = scheme or EventScheme(1e-10)
    tolerances, scales = system_scales(system, q0, qd0, end_time)
    gap = tolerances.gap if gap_tolerance is None else gap_tolerance
    compliance, at = None, np.zeros(1)
    if axial_flexibility:
        along = np.array([[0.0, 1.0], [axial_flexibility] * 2])
        compliance = Compliance.between(at, at, at, at, np.ones(1), None, 0.0, along)
    decision = Decision(
        [ContactPair(contact_law, extent, axial=compliance.behind(0) if compliance else None)],
        friction or Frictionless(),
        impact_law or NewtonImpact(),
        tolerances._replace(flight=scheme.shortest_flight, gap=gap),
        baumgarte,
        scheme.stick_criterion,
    )
    problem = Problem(
        system,
        q0,
        qd0,
        decision,
        scheme,
        end_time=float(end_time),
        output_interval=float(output_interval),
        scales=scales,
        breakpoints=breakpoints,
        compliance=compliance,
    )
    record, wall = _march(problem, on_progress)

    def energies(time: Array, q: Array, qd: Array) -> Energies:
        rows = [system.energy(*sample) for sample in zip(time, q, qd, strict=True)]
        return Energies(*np.array(rows, dtype=float).reshape(-1, 3).T)

    samples = gather(record.segments, system.size, energies)
    summary = summarize(record, samples, wall, clustering_time)
    if record.ambiguous:
        summary["warnings"] = ambiguity_warnings(record.ambiguous)
    history = History(dataset(samples.variables()), record.events, summary, None, record.contacts)
    return _warned(_unless_interrupted(history))


def _warned(history: History) -> History:
    """Return a history; gives its warnings to who has called the function that calls this."""
    for text in history.summary.get("warnings", ()):
        warn(text, SimulationWarning, stacklevel=3)
    return history


def _checked(system: Any, q0: Array, qd0: Array) -> Any:
    """Check the arrays of a system and make them contiguous; raises InputError for a wrong shape or type."""
    if isinstance(system, tuple):  # a compiled system: kernels read its arrays without a copy
        packed: Any = system
        arrays = {k: v for k, v in packed._asdict().items() if isinstance(v, np.ndarray)}
        floats = {k: v.astype(float) if v.dtype.kind == "f" else v for k, v in arrays.items()}
        return packed._replace(**{k: np.ascontiguousarray(v) for k, v in floats.items()})
    if isinstance(system, MechanicalSystem):  # its arrays are copied: strides and types do not matter
        d, rows = system.size, system.contact(0.0, q0, qd0)
        own_numbers(system.mass_matrix(0.0, q0), (d, d), "mass_matrix")
        own_numbers(system.forces(0.0, q0, qd0), (d,), "forces")
        own_numbers(rows.normal, (d,), "normal of contact")
        own_numbers(rows.tangential, (d,), "tangential of contact")
        own_numbers(system.stiffness_matrix(0.0, q0), (d, d), "stiffness_matrix")
        own_numbers(system.damping_matrix(0.0, q0), (d, d), "damping_matrix")
    return system


def _march(problem: Problem, on_progress: ProgressCallback | None) -> tuple[Record, float]:
    """March a problem; returns its record and the wall time (s), without compiling and loading kernels.

    Raises InputError for a rigid stop in a scheme that takes elastic ones alone.
    """
    if problem.scheme.elastic_only and problem.contact and not problem.decision.compliant:
        name = type(problem.scheme).__name__
        raise InputError(f"scheme: should be an EventScheme or TimeSteppingScheme with a rigid stop, not {name}")
    with clock() as marching:
        record = Run(problem, on_progress).execute()
        return record, marching.seconds


def _unless_interrupted(history: History) -> History:
    """Return a history; raises Interrupted after Ctrl-C, so that a loop over runs ends too."""
    if history.outcome is Outcome.INTERRUPTED:
        raise Interrupted(history)
    return history
