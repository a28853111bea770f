"""Marching a scenario: steps, contact states and their transitions, samples, and the balance of energy."""

from __future__ import annotations

import time
from collections.abc import Callable
from math import ceil, copysign
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

from oblique_impact.beam.base_motion import BaseMotion, base_motion_of
from oblique_impact.beam.cross_sections import Sections
from oblique_impact.contact.impacts import Impulse
from oblique_impact.contact.state import State
from oblique_impact.contact.transitions import AtEnd, EventKind
from oblique_impact.errors import Outcome, RunEnded
from oblique_impact.fem_beam.exact.averages import Averages, Forces
from oblique_impact.fem_beam.exact.beam import ExactBeam, Stage
from oblique_impact.fem_beam.exact.sections import Array, ElasticSections
from oblique_impact.fem_beam.exact.step import NotConvergedError, Step, advance
from oblique_impact.fem_beam.exact.stop import Contact, Place, Slope
from oblique_impact.fem_beam.mesh import mesh_of
from oblique_impact.marching import records
from oblique_impact.marching.equations import Quadratures
from oblique_impact.marching.loop import MAX_EVENTS, Status
from oblique_impact.problem import NEAR
from oblique_impact.scenario.scenario import Scenario

#: a guard that has fallen within this part of a step has fallen at its beginning
_AT_ONCE = 1e-6
#: so many transitions at one instant are chattering
_MAX_AT_ONCE = 40
#: tolerance of Newton's iterations that rounding leaves possible
_LEAST_TOLERANCE = 1e-12
_NO_IMPULSE = Impulse(0.0, 0.0, 0.0)
_REPORT = 0.1  # s of computing between two reports of progress
#: steps that are timed to estimate the time of the whole run: some hundredths of a second
_TIMED = 20
_WAIT = 10.0  # s; a shorter run is not worth a line


class Sample(NamedTuple):
    """State and forces at an instant."""

    time: float
    stage: Stage
    state: State
    place: Place
    normal_force: float
    tangential_force: float
    forces: Forces


class Phase(NamedTuple):
    """A contact state; the direction of slip is that of the slip velocity, 0 without friction."""

    state: State
    direction: float = 0.0


def beam_of(scenario: Scenario, sections: ElasticSections | None = None) -> ExactBeam:
    """Discretize the beam of a scenario: nodes as those of its finite elements; `sections` replace its own."""
    own = Sections.from_scenario(scenario)
    ends = mesh_of(scenario, own).p[0]
    elastic = sections or ElasticSections.of(scenario)
    return ExactBeam(ends, elastic, own.tip_mass, own.hub_inertia, own.hub_radius)


def _duration(seconds: float) -> str:
    """Format a computing time."""
    for size, unit in ((3600.0, "h"), (60.0, "min")):
        if seconds >= 2.0 * size:
            return f"{seconds / size:.0f} {unit}"
    return f"{seconds:.0f} s"


class Run:
    """One run; `execute` marches it, and `samples`, `totals` and `record` hold what it leaves.

    Parameters
    ----------
    scenario : Scenario
        What to simulate.
    on_progress : callable, optional
        Called with a :class:`~oblique_impact.marching.loop.Status` several times a second.
    sections : ElasticSections, optional
        In place of those of the scenario.
    motion : BaseMotion, optional
        How a driven root turns; by default as the scenario says.
    """

    def __init__(
        self,
        scenario: Scenario,
        on_progress: Callable[[Status], None] | None = None,
        sections: ElasticSections | None = None,
        motion: BaseMotion | None = None,
    ) -> None:
        self.scenario, self.beam = scenario, beam_of(scenario, sections)
        self.motion = motion or base_motion_of(scenario.root)
        self.record, self.samples = records.Record(), list[Sample]()
        self.totals = Quadratures(*[0.0] * 7)
        self._report, self._reported = on_progress or (lambda status: None), -np.inf
        self._timed: list[float] = []  # s of computing, of each of the first steps
        node = int(np.argmin(np.abs(self.beam.x - scenario.contact.point)))
        self.slope = Slope.of(scenario, node)
        self.load = self.beam.weight(scenario.gravity)
        if scenario.root.kind == "hub":
            self.load[2] += scenario.root.torque
        q = self.beam.straight(scenario.initial.angle)
        driven = scenario.root.kind == "driven"
        speed = self.motion.at(0.0).speed if driven else scenario.initial.angular_velocity
        self.stage = Stage(q, self.beam.turning(q, speed))
        self.time, self.phase = 0.0, Phase(State.FREE)
        place = self.slope.place(self.stage)
        self._side = -1.0 if place.gap < 0.0 and self.slope.is_beyond(place) else 1.0
        self._averages = Averages()
        self._open: records.OpenContact | None = None
        self._recent = 0
        rough = scenario.contact.friction == "hybrid"
        self._kinetic = scenario.contact.mu_kinetic if rough else 0.0
        self._static = scenario.contact.mu_static if rough else 0.0

    def execute(self) -> records.Record:
        """March to the end, to a named outcome, or to an interrupt."""
        solver, end = self.scenario.solver, self.scenario.end_time
        count = ceil(end / solver.output_interval - 1e-9)
        instants = [min(k * solver.output_interval, end) for k in range(1, count)] + [end]
        breaks = self.motion.breakpoints if self.scenario.root.kind == "driven" else ()
        self._sample()
        try:
            for instant in instants:
                for until in sorted({instant, *(b for b in breaks if self.time < b <= instant)}):
                    self._march_to(until)
                    if until in breaks and until < instant:
                        self._averages.cut()
                self._sample()
                if instant in breaks:
                    self._averages.cut()
        except RunEnded as ended:
            self.record.outcome = ended.outcome
            self._sample()
        except KeyboardInterrupt:
            self.record.outcome = Outcome.INTERRUPTED
            self._sample()
        self._averages.cut()
        if self.phase.state is not State.FREE:
            self.record.stored = self.slope.law.energy(self.slope.place(self.stage).gap)
            self._close()
        return self.record

    # --- steps

    def _march_to(self, end: float) -> None:
        """March to an instant, in equal steps that are at most as long as the state asks for."""
        solver, contact = self.scenario.solver, self.scenario.contact.enabled
        while self.time < end:
            near = contact and self._side * self.slope.place(self.stage).gap < NEAR * self.scenario.beam.length
            longest = min(solver.contact_step, solver.free_step) if near else solver.free_step
            left = end - self.time
            length = left / ceil(left / longest - 1e-9)
            last = length >= left * (1.0 - 1e-12)
            started = time.perf_counter()
            if self._try(length) and last:
                self.time = end
            now, notice = time.perf_counter(), ""
            if len(self._timed) < _TIMED:
                self._timed.append(now - started)
                notice = self._expected() if len(self._timed) == _TIMED else ""
            if notice or now > self._reported + _REPORT:
                self._reported = now
                events = len(self.record.events)
                self._report(Status(self.time, self.scenario.end_time, self.phase.state, events, notice))

    def _expected(self) -> str:
        """Return the estimated computing time of the run as text; "" if it is short."""
        solver, step = self.scenario.solver, float(np.median(self._timed))
        left = self.scenario.end_time - self.time
        free, near = (step * left / length for length in (solver.free_step, solver.contact_step))
        if not self.scenario.contact.enabled:
            return f"about {_duration(free)}, at {1e3 * step:.2g} ms a step" if free > _WAIT else ""
        if max(free, near) < _WAIT:
            return ""
        words = f"{_duration(free)} if the contact point stays away from the slope"
        reach = f"{NEAR:g} beam.length"
        return f"{words}, {_duration(near)} if it stays within {reach} of it, at {1e3 * step:.2g} ms a step"

    def _try(self, length: float) -> bool:
        """Take a step, or the part of it up to the first transition; return whether it was the whole step."""
        step, found = self._step(length, self._contact()), None
        for kind in self._guards() if self.scenario.contact.enabled else ():
            if self._guard(kind, step, length) < 0.0:
                at = self._locate(kind, length)
                if found is None or at < found[0]:
                    found = at, kind
        if found is None:
            self._accept(step, length)
            return True
        at, kind = found
        if at > 0.0:
            self._accept(self._step(at, self._contact()), at)
        self._change(kind)
        if len(self.record.events) > MAX_EVENTS:
            raise RunEnded(Outcome.TOO_MANY_EVENTS)
        self._recent = 0 if at > 0.0 else self._recent + 1
        if self._recent > _MAX_AT_ONCE:
            raise RunEnded(Outcome.CHATTERING)
        return False

    def _step(self, length: float, contact: Contact | None) -> Step:
        """Return a step with a contact; raises RunEnded if its iterations do not converge."""
        try:
            return advance(
                self.beam,
                self.stage,
                length,
                self.load,
                held=self._held(self.time + length),
                viscosity=self.scenario.beam.kelvin_voigt,
                contact=contact,
                tolerance=max(self.scenario.solver.tolerance, _LEAST_TOLERANCE),
            )
        except NotConvergedError:
            raise RunEnded(Outcome.NOT_CONVERGED) from None

    def _held(self, at: float) -> Array:
        """Values of the prescribed unknowns at an instant (s)."""
        if self.scenario.root.kind != "driven":
            return np.zeros(2)
        angle = self.scenario.initial.angle + self.motion.at(at).angle
        return np.array([self.beam.radius * np.cos(angle), self.beam.radius * np.sin(angle), angle])

    def _contact(self) -> Contact | None:
        if self.phase.state is State.FREE:
            return None
        if self.phase.state is State.STICK:
            return Contact(self.slope, sticks=True)
        return Contact(self.slope, friction=-self._kinetic * self.phase.direction)

    def _accept(self, step: Step, length: float) -> None:
        """Go to the end of a step and add its impulses and losses to the totals."""
        before, after = self.slope.place(self.stage), self.slope.place(step.stage)
        gained = dict.fromkeys(Quadratures._fields, 0.0)
        relaxation = self.scenario.beam.kelvin_voigt / length
        if relaxation:
            gained["damping_loss"] = self.beam.damping_loss(self.stage.q, step.stage.q, relaxation)
        held = step.held.size
        supplied = float(step.held @ (step.stage.q - self.stage.q)[:held])
        if self.scenario.root.kind == "hub":
            supplied += self.scenario.root.torque * float(step.stage.q[2] - self.stage.q[2])
        gained["supplied"] = supplied
        contact = self._contact()
        if contact is not None:
            force, _ = contact.normal_force(before.gap, after.gap, length)
            tangential = step.reaction if contact.sticks else contact.friction * force
            gained["normal_impulse"], gained["tangential_impulse"] = force * length, tangential * length
            gained["friction_loss"] = -tangential * (after.slip - before.slip)
            elastic = -0.5 * self.slope.law.stiffness * (before.gap + after.gap)
            gained["stop_loss"] = (force - elastic) * (before.gap - after.gap)
        mean = self.beam.mean_resultants(self.stage.q, step.stage.q, relaxation)
        self.totals = Quadratures(*(a + gained[name] for name, a in self.totals._asdict().items()))
        self._averages.add(self.time, self.time + length, Forces(*mean, step.reaction))
        self.stage, self.time = step.stage, self.time + length
        self.record.steps += 1
        if self._open is not None:
            self._open.peak_force = max(self._open.peak_force, self.slope.force(after))
            self._open.depth = max(self._open.depth, -after.gap)

    # --- contact states

    def _guards(self) -> tuple[EventKind | AtEnd, ...]:
        """Return the kinds of transition that the present state allows."""
        if self.phase.state is State.FREE:
            return (EventKind.IMPACT,)
        ends = (AtEnd.SLIDES_OFF,) if self.slope.extent else ()
        if self.phase.state is State.STICK:
            return (EventKind.RELEASE, EventKind.SLIP)
        return (
            (EventKind.RELEASE, *ends, EventKind.REVERSAL) if self.phase.direction else (EventKind.RELEASE, *ends)
        )

    def _guard(self, kind: EventKind | AtEnd, step: Step, length: float) -> float:
        """Return the guard of a transition at the end of a step: positive as long as it has not happened."""
        after = self.slope.place(step.stage)
        if kind is EventKind.IMPACT:
            return self._side * after.gap
        if kind is AtEnd.SLIDES_OFF:
            return self.slope.inside(after)
        if kind is EventKind.RELEASE:
            return -after.gap
        if kind is EventKind.REVERSAL:
            return self.phase.direction * after.slip_rate
        force, _ = Contact(self.slope).normal_force(self.slope.place(self.stage).gap, after.gap, length)
        return self._static * force - abs(step.reaction)

    def _locate(self, kind: EventKind | AtEnd, length: float) -> float:
        """Length (s) of the step at whose end a guard falls to zero; 0 if it falls at once."""

        def at(part: float) -> float:
            return self._guard(kind, self._step(part * length, self._contact()), part * length)

        if at(_AT_ONCE) <= 0.0:
            return 0.0
        return float(brentq(at, _AT_ONCE, 1.0, xtol=1e-12, rtol=1e-14)) * length

    def _change(self, kind: EventKind | AtEnd) -> None:
        """Go through a transition, with a sample on either side of it."""
        place = self.slope.place(self.stage)
        if kind is EventKind.IMPACT and (self._side < 0.0 or self.slope.is_beyond(place)):
            self._pass_end(AtEnd.COMES_BACK if self._side < 0.0 else AtEnd.FALLS_PAST, place)
            return
        self._sample()
        if kind is AtEnd.SLIDES_OFF:
            self._pass_end(kind, place)
            # the energy still in the spring is lost to the beam
            loss = self.totals.stop_loss + self.slope.law.energy(place.gap)
            self.totals, kind = self.totals._replace(stop_loss=loss), EventKind.RELEASE
        if kind is EventKind.RELEASE:
            event = self._close(place)
            self.phase = Phase(State.FREE)
        else:
            if kind is EventKind.IMPACT:  # it slips, with a direction where there is friction
                self._open = records.OpenContact(self.time, _NO_IMPULSE, np.array(self.totals))
                direction = copysign(1.0, place.slip_rate) if self._static > 0.0 else 0.0
                self.phase = Phase(State.SLIP, direction)
            else:
                kind = self._at_zero_slip()
            event = self._event(kind, place)
        self.record.events.append(event._replace(state=self.phase.state))
        self._averages.cut()
        self._sample()

    def _pass_end(self, how: AtEnd, place: Place) -> None:
        """Record how an end of the slope is passed."""
        self._side = 1.0 if how is AtEnd.COMES_BACK else -1.0
        end = min(self.slope.extent, key=lambda along: abs(along - place.slip))
        self.record.passages.append(records.Passage(self.time, how, place.slip, end))

    def _at_zero_slip(self) -> EventKind:
        """Choose stick or slip at an instant without slip, by the force that would hold the point for a step."""
        was = self.phase
        length = min(self.scenario.solver.contact_step, self.scenario.solver.free_step)
        trial = self._step(length, Contact(self.slope, sticks=True))
        after = self.slope.place(trial.stage)
        force, _ = Contact(self.slope).normal_force(self.slope.place(self.stage).gap, after.gap, length)
        if was.state is not State.STICK and abs(trial.reaction) <= self._static * force:
            self.phase = Phase(State.STICK)
            return EventKind.STICK
        # the force of friction is on the side of the force that would hold the point
        self.phase = Phase(State.SLIP, -copysign(1.0, trial.reaction))
        return EventKind.SLIP if was.state is State.STICK else EventKind.REVERSAL

    def _event(self, kind: EventKind, place: Place) -> records.Event:
        return records.Event(self.time, kind, 0.0, 0.0, place.gap_rate, place.slip_rate, 0.0, self.phase.state)

    def _close(self, place: Place | None = None) -> records.Event:
        """End the contact and return its row of the event log."""
        assert self._open is not None
        contact, finite = self._open.closed(self.time, np.array(self.totals), self.slope.law)
        self.record.contacts.append(contact)
        self._open = None
        return self._event(EventKind.RELEASE, place or self.slope.place(self.stage)).with_share(finite)

    def _sample(self) -> None:
        """Store a sample; the section forces follow when the next steps are known."""
        place = self.slope.place(self.stage)
        force = 0.0 if self.phase.state is State.FREE else self.slope.force(place)
        sticks, number = self.phase.state is State.STICK, len(self.samples)
        tangential = 0.0 if sticks else -self._kinetic * self.phase.direction * force
        at_once = self.beam.resultants(self.stage.q, self.stage.v, self.scenario.beam.kelvin_voigt)
        forces = Forces(*at_once, 0.0)
        self.samples.append(Sample(self.time, self.stage, self.phase.state, place, force, tangential, forces))

        def store(forces: Forces) -> None:
            sample = self.samples[number]._replace(forces=forces)
            if sticks:
                # stick ends where the mean of a step is at the edge of the cone: at its end it would be beyond
                edge = self._static * force
                sample = sample._replace(tangential_force=min(max(forces.reaction, -edge), edge))
            self.samples[number] = sample

        self._averages.request(self.time, store)
