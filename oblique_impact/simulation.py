"""From a scenario, or a user-defined system, to a history."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from oblique_impact.beam.base_motion import BaseMotion
from oblique_impact.beam.beam import Beam, Energies
from oblique_impact.beam.clearance import closest
from oblique_impact.beam.determinacy import truncated, undetermined, without_limit
from oblique_impact.beam.frequencies import macro_gap
from oblique_impact.beam.operators import Discretization
from oblique_impact.beam.plausibility import doubts
from oblique_impact.contact.friction import FrictionLaw, Frictionless
from oblique_impact.contact.impacts import ImpactLaw, NewtonImpact
from oblique_impact.contact.state import Baumgarte
from oblique_impact.contact.stops import ContactLaw
from oblique_impact.contact.transitions import ContactMachine
from oblique_impact.errors import Interrupted, Outcome
from oblique_impact.history.history import History
from oblique_impact.history.samples import beam_variables, gather, warnings_of
from oblique_impact.history.summary import energy_warnings, summarize
from oblique_impact.history.variables import dataset
from oblique_impact.kernels.compiling import clock
from oblique_impact.kernels.system import MechanicalSystem
from oblique_impact.kernels.workspace import Array, own_numbers
from oblique_impact.marching.event import EventScheme
from oblique_impact.marching.loop import Run, Status
from oblique_impact.marching.problem import Problem
from oblique_impact.marching.records import Record
from oblique_impact.marching.scheme import Scheme
from oblique_impact.problem import Parts, beam_of, beam_problem, system_scales
from oblique_impact.scenario.scenario import Scenario, require_scenario

ProgressCallback = Callable[[Status], None]


def simulate(
    scenario: Scenario,
    on_progress: ProgressCallback | None = None,
    *,
    section_forces: bool = True,
    friction: FrictionLaw | None = None,
    contact_law: ContactLaw | None = None,
    impact_law: ImpactLaw | None = None,
    base_motion: BaseMotion | None = None,
    scheme: Scheme | None = None,
    discretization: Discretization | None = None,
) -> History:
    """Run a scenario and return its history, whatever the named outcome.

    Parameters
    ----------
    scenario : Scenario
        What to simulate.
    on_progress : callable, optional
        Called with a :class:`~oblique_impact.marching.loop.Status` several times per run.
    section_forces : bool
        Whether the history has bending moment, shear force, axial force and bending stress along the beam.  They
        take about 0.1 s for 10,000 samples, more than the marching of a short run: studies of many runs leave them
        out unless they look at them.
    friction, contact_law, impact_law, base_motion, scheme, discretization : optional
        User-defined parts, each in the place of the built-in one that the scenario names; see
        :class:`~oblique_impact.problem.Parts`.

    Returns
    -------
    History
        Samples, events and summary; `outcome` says how the run ended, which is no error.

    Raises
    ------
    InputError
        If this is no scenario, or a user-defined part does not fit it or hands over what it should not.
    Interrupted
        After Ctrl-C; a KeyboardInterrupt whose `history` holds what was computed until then.

    Examples
    --------
    >>> from oblique_impact import Scenario, simulate
    >>> history = simulate(Scenario.builtin("paper"))
    >>> float(history["theta"][-1])  # doctest: +SKIP
    """
    require_scenario(scenario, "simulate")
    parts = Parts(friction, contact_law, impact_law, base_motion, scheme, discretization)
    parts.check(scenario)
    if scenario.is_absolute:
        from oblique_impact.fem_beam.exact import simulate as simulate_exact  # which is built on this package

        history = simulate_exact(scenario, on_progress, motion=base_motion)
    else:
        beam = beam_of(scenario, parts)
        record, wall = _march(beam_problem(beam, parts), on_progress)
        history = _beam_history(beam, record, wall, section_forces)
    if given := parts.given():
        history.summary["provenance"]["user_defined"] = {name: repr(part) for name, part in given.items()}
    return _finished(history)


def _beam_history(beam: Beam, record: Record, wall: float, section_forces: bool) -> History:
    """Return the history of a beam's run, with all results that follow from its record."""
    scenario = beam.scenario
    samples = gather(record.segments, beam.size, lambda time, q, qd: beam.energies(q, qd), beam.split)
    variables = beam_variables(beam, samples, section_forces)
    summary = summarize(record, samples, wall, macro_gap(scenario))
    summary["clearance"] = closest(variables, scenario.beam.length)
    summary["without_limit"] = list(without_limit(scenario))
    summary["warnings"] = [
        *doubts(scenario),
        *warnings_of(beam, variables, summary["slope_ends"]),
        *undetermined(beam, [collision["contacts"] for collision in summary["macro_collisions"]]),
        *truncated(beam, variables),
        *energy_warnings(summary["energy"], np.max(samples.kinetic), scenario.solver.scheme),
    ]
    return History(dataset(variables), record.events, summary, scenario, record.contacts)


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
    baumgarte: Baumgarte = Baumgarte(),
    stop: ContactLaw | None = None,
    extent: tuple[float, ...] = (),
    gap_tolerance: float | None = None,
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
    extent : tuple of float
        Ends of the slope, [first, last] (m) along it; by default it has none.
    gap_tolerance : float, optional
        Gap (m) that counts as zero; default: 1e-12 of the length of the motion, see
        :func:`~oblique_impact.problem.system_scales`.
    macro_gap : float
        Contacts less than this apart (s) are one macro-collision; by default each contact is one, because a system
        without a beam has no period to compare with.

    Returns
    -------
    History
        Without the variables that only a beam has.

    Raises
    ------
    InputError
        If an array of the system, of its state or of a user-defined scheme has the wrong shape or is not real.
    Interrupted
        After Ctrl-C, as :func:`simulate`.
    """
    q0, qd0 = (own_numbers(v, (system.size,), name) for v, name in ((q0, "q0"), (qd0, "qd0")))
    system = _checked(system, q0, qd0)
    scheme = scheme or EventScheme(1e-10)
    tolerances, scales = system_scales(system, q0, qd0, end_time)
    gap = tolerances.gap if gap_tolerance is None else gap_tolerance
    tolerances = tolerances._replace(flight=scheme.shortest_flight, gap=gap)
    laws = friction or Frictionless(), impact or NewtonImpact()
    machine = ContactMachine(*laws, tolerances, baumgarte, scheme.stick_criterion, stop, extent)
    times = float(end_time), float(output_interval)
    problem = Problem(system, q0, qd0, machine, scheme, *times, scales, breakpoints=breakpoints)
    record, wall = _march(problem, on_progress)

    def energies(time: Array, q: Array, qd: Array) -> Energies:
        rows = [system.energy(*sample) for sample in zip(time, q, qd, strict=True)]
        return Energies(*np.array(rows, dtype=float).reshape(-1, 3).T)

    samples = gather(record.segments, system.size, energies)
    summary = summarize(record, samples, wall, macro_gap)
    return _finished(History(dataset(samples.variables()), record.events, summary, None, record.contacts))


def _checked(system: Any, q0: Array, qd0: Array) -> Any:
    """Return a system that kernels can read; raises InputError for arrays of the wrong shape or type."""
    if isinstance(system, tuple):  # packed: compiled kernels take its arrays as they are
        packed: Any = system
        arrays = {k: v for k, v in packed._asdict().items() if isinstance(v, np.ndarray)}
        floats = {k: v.astype(float) if v.dtype.kind == "f" else v for k, v in arrays.items()}
        return packed._replace(**{k: np.ascontiguousarray(v) for k, v in floats.items()})
    if isinstance(system, MechanicalSystem):  # what it returns is copied: strides and types do not matter
        d, rows = system.size, system.contact(0.0, q0, qd0)
        own_numbers(system.mass_matrix(0.0, q0), (d, d), "mass_matrix")
        own_numbers(system.forces(0.0, q0, qd0), (d,), "forces")
        own_numbers(rows.normal, (d,), "normal of contact")
        own_numbers(rows.tangential, (d,), "tangential of contact")
        own_numbers(system.stiffness_matrix(0.0, q0), (d, d), "stiffness_matrix")
        own_numbers(system.damping_matrix(0.0, q0), (d, d), "damping_matrix")
    return system


def _march(problem: Problem, on_progress: ProgressCallback | None) -> tuple[Record, float]:
    """Run the loop; returns what it leaves and its wall time (s), without compiling and loading kernels."""
    with clock() as marching:
        record = Run(problem, on_progress).execute()
        return record, marching.seconds


def _finished(history: History) -> History:
    """Return a history; raises Interrupted if Ctrl-C has cut it short, so that a loop over runs ends too."""
    if history.outcome is Outcome.INTERRUPTED:
        raise Interrupted(history)
    return history
