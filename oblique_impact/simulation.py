"""From a scenario, or a system of one's own, to a history."""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import partial

import numpy as np

from oblique_impact.beam.clearance import closest
from oblique_impact.beam.nodal import FullBeam
from oblique_impact.beam.plausibility import doubts
from oblique_impact.beam.reduced import Beam, Energies
from oblique_impact.contact.friction import FrictionLaw, Frictionless
from oblique_impact.contact.impacts import ImpactLaw, NewtonImpact
from oblique_impact.contact.stops import ContactLaw
from oblique_impact.contact.transitions import Baumgarte
from oblique_impact.history.ahead import Ahead, ProgressCallback
from oblique_impact.history.draft import Draft
from oblique_impact.history.history import History
from oblique_impact.history.samples import Samples, beam_variables, gather, summarize, warnings_of
from oblique_impact.history.variables import dataset
from oblique_impact.kernels.system import MechanicalSystem
from oblique_impact.kernels.workspace import Array
from oblique_impact.marching.event import EventScheme
from oblique_impact.marching.loop import Run
from oblique_impact.marching.scheme import Scheme
from oblique_impact.problem import beam_of, beam_problem, system_problem
from oblique_impact.scenario.scenario import Scenario, require_scenario


def simulate(
    scenario: Scenario, on_progress: ProgressCallback | None = None, draft: Draft | None = None
) -> History:
    """Run a scenario and return its history, whatever the named outcome.

    Parameters
    ----------
    scenario : Scenario
        What to simulate.
    on_progress : callable, optional
        Called with a :class:`~oblique_impact.marching.loop.Status` several times per run.
    draft : Draft, optional
        Where samples are written while the run goes on; :meth:`~oblique_impact.history.history.History.save` completes it.

    Returns
    -------
    History
        Samples, events and summary; `outcome` says how the run ended, which is no error.

    Raises
    ------
    InputError
        If this is no scenario.

    Examples
    --------
    >>> from oblique_impact import Scenario, simulate
    >>> history = simulate(Scenario.builtin("paper"))
    >>> float(history["theta"][-1])  # doctest: +SKIP
    """
    require_scenario(scenario, "simulate")
    marched = beam_of(scenario)
    full = marched if isinstance(marched, FullBeam) else None
    beam = Beam(scenario, marched.operators.beam) if isinstance(marched, FullBeam) else marched
    problem = beam_problem(marched)
    if draft is not None:
        draft.start()
    ahead = Ahead(_gathering(beam, full), partial(beam_variables, beam), on_progress, draft)
    run = Run(problem, ahead)
    ahead.record = run.record
    started = time.perf_counter()
    record = run.execute()
    wall = time.perf_counter() - started - ahead.seconds
    variables, first, last = ahead.finish()
    variables["station"] = beam.operators.stations.points
    summary = summarize(record, (first, last), wall, problem.machine.stop, scenario)
    summary["clearance"] = closest(variables, scenario.beam.length)
    events = [event.time for event in record.events]
    summary["warnings"] = [*doubts(scenario), *warnings_of(beam, variables, events)]
    data = dataset(variables)
    if draft is not None:
        draft.end(data)
    return History(data, record.events, summary, scenario.to_toml(), record.contacts)


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
    stop: ContactLaw | None = None,
    gap_tolerance: float | None = None,
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
    gap_tolerance : float, optional
        Gap (m) that counts as zero; default: 1e-12 of the length of the motion, see
        :func:`~oblique_impact.problem.system_scales`.

    Returns
    -------
    History
        Without the variables that only a beam has.
    """
    problem = system_problem(
        system,
        np.asarray(q0, dtype=float),
        np.asarray(qd0, dtype=float),
        float(end_time),
        float(output_interval),
        scheme or EventScheme(1e-10),
        (friction or Frictionless(), impact or NewtonImpact(), stop),
        baumgarte,
        breakpoints,
        gap_tolerance,
    )
    started = time.perf_counter()
    record = Run(problem, on_progress).execute()
    wall = time.perf_counter() - started

    def energies(time: Array, q: Array, qd: Array) -> Energies:
        rows = [system.energy(*sample) for sample in zip(time, q, qd, strict=True)]
        return Energies(*np.array(rows, dtype=float).reshape(-1, 3).T)

    samples = gather(record.segments, system.size, energies)
    ends = samples.part(slice(1)), samples.part(slice(-1, None))
    summary = summarize(record, ends, wall, stop)
    return History(dataset(samples.variables()), record.events, summary, contacts=record.contacts)


def _gathering(beam: Beam, full: FullBeam | None) -> Callable[..., Samples]:
    """Return what puts the samples of a beam together, with coordinates of the floating frame."""
    if full is None:
        return partial(gather, size=beam.size, energies=lambda time, q, qd: beam.energies(q, qd))
    return partial(gather, size=full.size, energies=lambda time, W, Wd: full.energies(W, Wd), transform=full.split)
