"""The energy-consistent step as a scheme: transitions are located within steps, a trial step decides on stick."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from math import ceil, inf

import numpy as np
from scipy.optimize import brentq

from oblique_impact.beam_problem import NEAR
from oblique_impact.contact.forces import OK, guards_of
from oblique_impact.contact.state import (
    FREE,
    GUARDS,
    LOWER,
    SLIDING,
    STICKING,
    UPPER,
    Candidate,
    Guards,
)
from oblique_impact.contact.transitions import StickCriterion
from oblique_impact.fem_beam.exact.averages import Averages, MeanForces
from oblique_impact.fem_beam.exact.elastic_sections import Array
from oblique_impact.fem_beam.exact.exact_beam import Stage
from oblique_impact.fem_beam.exact.exact_system import ExactSystem
from oblique_impact.fem_beam.exact.step import NotConvergedError, SolvedStep, advance
from oblique_impact.fem_beam.exact.stop import ClosedContact, NodeOnSide, Pair, Place
from oblique_impact.marching import advance as march
from oblique_impact.marching.advance import Limits, Position, StepState, keep_sample, refused
from oblique_impact.marching.buffers import KEPT, NEXT, NO_GUARD
from oblique_impact.marching.equations import (
    DAMPING_LOSS,
    OF_A_CONTACT,
    QUADRATURES,
    SUPPLIED,
)
from oblique_impact.marching.scheme import Prepared, Scheme, Task

#: a guard that has fallen within this part of a step has fallen at its beginning
_AT_ONCE = 1e-6
#: part of a step that decides between stick and slip after each transition at the same instant, and how often
_SHORTER, _SHORTEST = 0.1, 6
#: tolerance of Newton's iterations that rounding leaves possible
_LEAST_TOLERANCE = 1e-12
#: steps of a call, some hundredths of a second
_STEPS_PER_CALL = 50
_NO_LIMITS = Limits(inf, inf, inf, 0)


@dataclass
class Recorder:
    """Record of the steps of a run."""

    averages: Averages = field(default_factory=Averages)
    at_once: int = 0  # transitions that have followed each other at one instant


class ExactStepper:
    """Steps of the exact beam in one phase; a `Stepper`."""

    def __init__(self, prepared: Prepared, limits: Limits) -> None:
        self.system: ExactSystem = prepared.system
        self.scratch, self.limits, self._recorder = prepared.scratch, limits, prepared.own
        self._scenario, self._touchings = self.system.scenario, self.system.touchings
        self._contacts = prepared.contacts
        self._states = [prepared.contacts.of(i) for i in range(len(self._touchings))]
        self._closed = {
            i: ClosedContact(self._touchings[i], sticks=True)
            if state.state == STICKING
            else ClosedContact(self._touchings[i], state.intercept, state.slope)
            for i, state in enumerate(self._states)
            if state.state != FREE
        }
        self._hand_over = self.system.hand_over

    def begin(self, start: StepState, y: Array) -> tuple[int, float]:
        """Take the state; section forces may jump where a phase begins or the root's motion is not smooth."""
        d, averages = self.system.beam.size, self._recorder.averages
        self._time, self._stage = start.t, Stage(y[:d].copy(), y[d : 2 * d].copy())
        self._places = self._places_of(self._stage)
        if start.taken == 0 or start.t in self.system.breakpoints:
            averages.cut()
        if start.taken == 0:
            averages.request(start.t, begins=True)
        return OK, self._distance()

    def length(self, gap: float, h: float) -> float:
        """Equal steps to the next output instant, at most as long as the distance from obstacles asks for."""
        solver, contact = self._scenario.solver, self._scenario.contact.enabled
        near = contact and gap < NEAR * self._scenario.beam.length
        longest = min(solver.contact_step, solver.free_step) if near else solver.free_step
        instant, stop = self.scratch.samples.counts[NEXT] * solver.output_interval, self.limits.t_stop
        self._until = float(instant) if instant < stop - 1e-9 * solver.output_interval else stop
        left = self._until - self._time
        return float(left / max(1, ceil(left / longest - 1e-9)))

    def take(self, now: Position, length: float, end: float, y: Array) -> march.Step:
        """Take a step, or the part of it up to the first guard that falls."""
        last = length >= (self._until - self._time) * (1.0 - 1e-12)
        try:
            return self._take(length, self._until if last else self._time + length, y)
        except NotConvergedError:
            self._recorder.averages.request(self._time)
            return refused(-march.FAILED_ITERATION, 0.0)

    def _take(self, length: float, end: float, y: Array) -> march.Step:
        step = self._step(length)
        places, found = self._places_of(step.stage), list[tuple[float, bool, int, int]]()
        for i in range(len(self._states) if self._scenario.contact.enabled else 0):
            for which, value in enumerate(self._guards(i, places, step, length)):
                if value < 0.0:
                    # what holds no longer lets go before others that it has held turn
                    turns = self._states[i].state == SLIDING and which in (LOWER, UPPER)
                    found.append((self._locate(i, which, length), turns, i, which))
        if not found:
            self._accept(step, places, length, y)
            self._time = end
            return march.Step(OK, True, end, length, NO_GUARD, self._distance())
        at, _, i, which = min(found, key=lambda entry: entry[:3])
        if at > 0.0:
            step = self._step(at)
            self._accept(step, self._places_of(step.stage), at, y)
            self._time += at
        guard = self._decide(i, which)
        self._recorder.at_once = 0 if at > 0.0 else self._recorder.at_once + 1
        if at == 0.0:
            self._recorder.averages.request(self._time)
        return march.Step(OK, at > 0.0, self._time, length, guard, self._distance())

    def arrive(self, step: march.Step, y: Array) -> march.Step:
        """Keep a sample if one is due."""
        counts = self.scratch.samples.counts
        kept = counts[KEPT]
        if step.guard == NO_GUARD:
            keep_sample(step.end, y, self.limits, self.scratch.samples)
        if step.guard != NO_GUARD or counts[KEPT] > kept or step.end == self.limits.t_stop:
            self._recorder.averages.request(step.end)
        return step

    def _places_of(self, stage: Stage) -> list[Place]:
        return [touching.place(stage) for touching in self._touchings]

    def _distance(self) -> float:
        """Return the smallest distance (m) of a place that can touch, negative in contact."""
        each = zip(self._states, self._places, strict=True)
        return min((state.side * place.gap for state, place in each), default=inf)

    def _step(self, length: float, contacts: dict[int, ClosedContact] | None = None) -> SolvedStep:
        """Return a step, with the closed contacts or others in their place, and reactions of all contacts."""
        contacts = contacts or self._closed
        step = advance(
            self.system.beam,
            self._stage,
            length,
            self.system.load_at(self._time + 0.5 * length),
            held=self.system.held(self._time + length),
            viscosity=self._scenario.beam.kelvin_voigt,
            contacts=list(contacts.values()),
            tolerance=max(self._scenario.solver.tolerance, _LEAST_TOLERANCE),
        )
        reactions, keeping = np.zeros((2, len(self._states)))
        reactions[list(contacts)], keeping[list(contacts)] = step.reactions, step.keeping
        return step._replace(reactions=reactions, keeping=keeping)

    def _accept(self, step: SolvedStep, places: list[Place], length: float, y: Array) -> None:
        """Go to the end of a step, with its impulses and losses, and the forces there to report."""
        q0, q1, scenario, beam = self._stage.q, step.stage.q, self._scenario, self.system.beam
        relaxation, held, d = scenario.beam.kelvin_voigt / length, step.held.size, beam.size
        gained = np.zeros(QUADRATURES + OF_A_CONTACT * len(places))
        if relaxation:
            gained[DAMPING_LOSS] = beam.damping_loss(q0, q1, relaxation)
        gained[SUPPLIED] = float(step.held @ (q1 - q0)[:held])
        if self.system.is_hub:
            gained[SUPPLIED] += scenario.root.torque * float(q1[2] - q0[2])
        if self.system.shaking is not None:
            force = self.system.inertia_force(self.system.shaking, self._time + 0.5 * length)
            gained[SUPPLIED] += float(force @ (q1 - q0))
        for i, contact in self._closed.items():
            own = contact.gained(q0, q1, float(step.reactions[i]), length)
            gained[QUADRATURES + OF_A_CONTACT * i :][: len(own)] = own
            c = self._contacts.each[i]
            c.peak_force = max(c.peak_force, contact.touching.force(places[i]))
            c.peak_depth = max(c.peak_depth, -places[i].gap)
        y_new = self.scratch.y_new
        y_new[:d], y_new[d : 2 * d] = step.stage
        np.add(y[2 * d :][: gained.size], gained, out=y_new[2 * d :][: gained.size])
        self.report(places, y_new[2 * d + gained.size :])
        mean = MeanForces(*beam.mean_resultants(q0, q1, relaxation), step.reactions)
        self._recorder.averages.add(self._time, self._time + length, mean)
        self._stage, self._places = step.stage, places

    def report(self, places: Sequence[Place], extra: Array) -> None:
        """Fill the forces at an instant; sticking contacts, and accelerations, have none but means of steps."""
        extra[:] = 0.0
        for i, contact in self._closed.items():
            force = contact.touching.force(places[i])
            friction = contact.friction(places[i].slip_rate)
            extra[self.system.beam.size + 2 * i :][:2] = force, friction * force

    # --- guards

    def _guards(self, i: int, places: Sequence[Place], step: SolvedStep, length: float) -> Guards:
        """Return the guards of a contact at the end of a step, of the mean forces of this."""
        state, touching, after = self._states[i], self._touchings[i], places[i]
        if state.state == FREE:
            return guards_of(_at(state, after))
        force, _ = self._closed[i].normal_force(*_ends(self._places[i], after), length)
        reaction = float(step.keeping[i])
        found = guards_of(_at(state, after).changed(normal_force=force, tangential_force=reaction))
        if state.state == STICKING:
            # either edge of the cone: what holds may swing from one to the other within a step
            found = found._replace(lower=min(found.lower, found.upper), upper=1.0)
        if i in self._hand_over and isinstance(touching, NodeOnSide):
            away = [abs(after.slip - end) for end in touching.extent]
            if away[touching.outer] < away[1 - touching.outer]:
                # the tip leaves a side for its corner where this comes onto the beam: both ways at the same place
                return found._replace(end=places[self._hand_over[i]].x - self._scenario.beam.length)
        return found

    def _locate(self, i: int, which: int, length: float) -> float:
        """Length (s) of the step at whose end a guard falls to zero; 0 if it falls at once."""

        def at(part: float) -> float:
            step = self._step(part * length)
            return self._guards(i, self._places_of(step.stage), step, part * length)[which]

        if at(_AT_ONCE) <= 0.0:
            return 0.0
        try:
            return float(brentq(at, _AT_ONCE, 1.0, xtol=1e-12, rtol=1e-14)) * length
        except (RuntimeError, ValueError) as error:  # no end in a hundred steps, or no number
            raise NotConvergedError(str(error)) from None

    def _decide(self, i: int, which: int) -> int:
        """Return the guard that fell, where slip or stick ends with what follows.

        A contact without slip sticks if the force that would hold it for a step lies in the cone; if not, it slips
        against this force.  At other kinks of its law slip goes on, and a law without stick slips always.
        """
        contact = self._states[i]
        slides, kink = contact.state == SLIDING, contact.upper if which == UPPER else contact.lower
        passes = slides and (kink != 0.0 or contact.static < 0.0)
        if contact.state == FREE or which not in (LOWER, UPPER) or passes:
            return GUARDS * i + which
        # where forces turn within a step, what follows contradicts it at once: then a part of the step decides
        length = min(self._scenario.solver.contact_step, self._scenario.solver.free_step)
        length *= _SHORTER ** min(self._recorder.at_once, _SHORTEST)
        holding = ClosedContact(self._touchings[i], sticks=True)
        trial = self._step(length, self._closed | {i: holding})
        after, reaction = holding.touching.place(trial.stage), float(trial.keeping[i])
        force, _ = holding.normal_force(*_ends(self._places[i], after), length)
        if slides and abs(reaction) <= contact.static * force:
            return GUARDS * len(self._states) + i
        which = UPPER if reaction < 0.0 else LOWER
        if slides:  # from zero slip, also where it goes on in its direction
            self._contacts.take(i, contact.changed(**{"upper" if which == UPPER else "lower": 0.0}))
        return GUARDS * i + which


def _at(state: Candidate, place: Place) -> Candidate:
    """Return a contact in a state with the kinematics of a place."""
    gap, slip, gap_rate, slip_rate = map(float, place[:4])
    depth = {"depth": -gap, "depth_rate": -gap_rate}
    return state.changed(gap=gap, slip=slip, gap_rate=gap_rate, slip_rate=slip_rate, **depth)


def _ends(before: Place, after: Place) -> tuple[Pair, Pair]:
    """Return gaps and slips (m) at both ends of a step."""
    return (before.gap, after.gap), (before.slip, after.slip)


class ExactScheme(Scheme):
    """Steps of :func:`~oblique_impact.fem_beam.exact.step.advance`, of the second order."""

    name = "energy-consistent"
    order = 2

    @property
    def stick_criterion(self) -> StickCriterion:  # noqa: D102
        return StickCriterion(inf, located=True)

    def buffers(self, task: Task) -> Recorder:  # noqa: D102
        return Recorder()

    def extra_state(self, size: int, contacts: int, quadratures: int) -> int:  # noqa: D102
        return size + 2 * contacts

    def fill_extra_state(self, prepared: Prepared, y: Array, extra: Array) -> None:  # noqa: D102
        d = prepared.system.beam.size
        places = [touching.place(Stage(y[:d], y[d : 2 * d])) for touching in prepared.system.touchings]
        ExactStepper(prepared, _NO_LIMITS).report(places, extra)

    def steps_per_call(self, size: int) -> int:  # noqa: D102
        return _STEPS_PER_CALL

    def stepper(self, prepared: Prepared, limits: Limits) -> ExactStepper:  # noqa: D102
        return ExactStepper(prepared, limits)
