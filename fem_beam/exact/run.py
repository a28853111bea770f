"""Marching a scenario: steps, contact states and their transitions, samples, and the balance of energy."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from math import ceil, copysign
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

from oblique_impact.beam.base_motion import BaseMotion, base_motion_of
from oblique_impact.beam.beam import contact_places
from oblique_impact.beam.cross_sections import Sections
from oblique_impact.contact.impacts import Impulse
from oblique_impact.contact.state import State
from oblique_impact.contact.stops import ElasticStop
from oblique_impact.contact.transitions import AtEnd, EventKind
from oblique_impact.errors import Outcome, RunEnded
from oblique_impact.fem_beam.exact.averages import Averages, Forces
from oblique_impact.fem_beam.exact.beam import ExactBeam, Stage
from oblique_impact.fem_beam.exact.sections import Array, ElasticSections
from oblique_impact.fem_beam.exact.step import NotConvergedError, Step, advance
from oblique_impact.fem_beam.exact.stop import Contact, Place, PointOnBeam, PointOnSide, Touching
from oblique_impact.fem_beam.mesh import mesh_of
from oblique_impact.marching import records
from oblique_impact.marching.equations import (
    DAMPING_LOSS,
    FRICTION_LOSS,
    NORMAL_IMPULSE,
    QUADRATURES,
    STOP_LOSS,
    SUPPLIED,
    TANGENTIAL_IMPULSE,
)
from oblique_impact.marching.loop import MAX_EVENTS, Status
from oblique_impact.marching.records import OpenContact
from oblique_impact.problem import NEAR
from oblique_impact.scenario.scenario import Scenario

#: a guard that has fallen within this part of a step has fallen at its beginning
_AT_ONCE = 1e-6
#: so many transitions at one instant are chattering
_MAX_AT_ONCE = 40
#: part of a step that decides between stick and slip after each transition at the same instant, and how often
_SHORTER, _SHORTEST = 0.1, 6
#: tolerance of Newton's iterations that rounding leaves possible
_LEAST_TOLERANCE = 1e-12
_NO_IMPULSE = Impulse(0.0, 0.0, 0.0)
_REPORT = 0.1  # s of computing between two reports of progress
#: steps that are timed to estimate the time of the whole run: some hundredths of a second
_TIMED = 20
_WAIT = 10.0  # s; a shorter run is not worth a line


class Sample(NamedTuple):
    """State and forces at an instant; of each contact its state, side, place and forces (N)."""

    time: float
    stage: Stage
    states: tuple[State, ...]
    sides: tuple[float, ...]  # 1, or -1 in flight below the line of a side
    places: tuple[Place, ...]
    normal: Array
    tangential: Array
    forces: Forces


class Phase(NamedTuple):
    """A contact state; the direction of slip is that of the slip velocity, 0 without friction."""

    state: State
    direction: float = 0.0


class _Books:
    """A place that can touch: its state and what its contacts have done."""

    def __init__(self, touching: Touching, place: Place) -> None:
        self.touching = touching
        self.phase = Phase(State.FREE)
        # in flight below the line of a side, past an end: -1
        self.side = -1.0 if place.gap < 0.0 and touching.is_beyond(place) else 1.0
        self.totals = np.zeros(QUADRATURES)
        self.opened: OpenContact | None = None
        self.reach = 0.0, 0.0  # m along the beam, of the open contact

    @property
    def is_closed(self) -> bool:
        """Whether it touches."""
        return self.phase.state is not State.FREE


def beam_of(scenario: Scenario, sections: ElasticSections | None = None) -> ExactBeam:
    """Discretize the beam of a scenario: nodes as those of its finite elements; `sections` replace its own."""
    own = Sections.from_scenario(scenario)
    ends = mesh_of(scenario, own).p[0]
    elastic = sections or ElasticSections.of(scenario)
    return ExactBeam(ends, elastic, own.tip_mass, own.hub_inertia, own.hub_radius)


def touchings_of(scenario: Scenario, beam: ExactBeam) -> list[Touching]:
    """Return the places where a beam can touch; the contact point on the slope also where contact is disabled."""
    if not scenario.contact.enabled and scenario.contact.where == "anywhere":
        return []
    found = list[Touching]()
    for place in contact_places(scenario):
        law, at = ElasticStop(place.stiffness, scenario.contact.damping), [float(x) for x in place.numbers]
        common = beam, place.obstacle, law, place.extent
        if place.on_side:
            node = int(np.argmin(np.abs(beam.x - at[0])))
            outer = int(np.cos(scenario.initial.angle - at[1]) > 0.0)
            found.append(PointOnSide(*common, node, at[1], (at[2], at[3]), at[4], outer))
        else:
            found.append(PointOnBeam(*common, complex(at[0], at[1]), place.radius, at[3], at[4]))
    return found


def _heirs(contacts: Sequence[_Books]) -> dict[int, int]:
    """Return which contact takes over where another slides off an end: tip on a side and its outer corner."""
    found: dict[int, int] = {}
    for i, contact in enumerate(contacts):
        side = contact.touching
        if isinstance(side, PointOnSide) and side.extent and side.node == side.beam.x.size - 1:
            corners = [
                j
                for j, other in enumerate(contacts)
                if isinstance(other.touching, PointOnBeam) and other.touching.obstacle == side.obstacle
            ]
            if corners:
                found |= {i: corners[side.outer], corners[side.outer]: i}
    return found


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
        self.totals = np.zeros(QUADRATURES)
        self._report, self._reported = on_progress or (lambda status: None), -np.inf
        self._timed: list[float] = []  # s of computing, of each of the first steps
        self.load = self.beam.weight(scenario.gravity)
        if scenario.root.kind == "hub":
            self.load[2] += scenario.root.torque
        q = self.beam.straight(scenario.initial.angle)
        driven = scenario.root.kind == "driven"
        speed = self.motion.at(0.0).speed if driven else scenario.initial.angular_velocity
        self.time, self.stage = 0.0, Stage(q, self.beam.turning(q, speed))
        touchings = touchings_of(scenario, self.beam)
        self.places = [touching.place(self.stage) for touching in touchings]
        self.contacts = [_Books(touching, place) for touching, place in zip(touchings, self.places, strict=True)]
        self._heirs = _heirs(self.contacts)
        self._averages = Averages()
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
        for i, contact in enumerate(self.contacts):
            if contact.is_closed:
                self.record.stored += contact.touching.law.energy(self.places[i].gap)
                self._close(i)
        return self.record

    # --- steps

    def _march_to(self, end: float) -> None:
        """March to an instant, in equal steps that are at most as long as the state asks for."""
        solver, contact = self.scenario.solver, self.scenario.contact.enabled
        while self.time < end:
            near = contact and self._distance() < NEAR * self.scenario.beam.length
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
                self._report(Status(self.time, self.scenario.end_time, max(self._states()), events, notice))

    def _distance(self) -> float:
        """Return the smallest distance (m) of a place that can touch, negative in contact."""
        return min((contact.side * place.gap for contact, place in self._each()), default=np.inf)

    def _each(self) -> Iterator[tuple[_Books, Place]]:
        """Go over the contacts with their present places."""
        return zip(self.contacts, self.places, strict=True)

    def _states(self) -> tuple[State, ...]:
        return tuple(contact.phase.state for contact in self.contacts) or (State.FREE,)

    def _expected(self) -> str:
        """Return the estimated computing time of the run as text; "" if it is short."""
        solver, step = self.scenario.solver, float(np.median(self._timed))
        left = self.scenario.end_time - self.time
        free, near = (step * left / length for length in (solver.free_step, solver.contact_step))
        if not self.scenario.contact.enabled:
            return f"about {_duration(free)}, at {1e3 * step:.2g} ms a step" if free > _WAIT else ""
        if max(free, near) < _WAIT:
            return ""
        words, reach = f"{_duration(free)} if it stays away from obstacles", f"{NEAR:g} beam.length"
        return f"{words}, {_duration(near)} if it stays within {reach} of one, at {1e3 * step:.2g} ms a step"

    def _try(self, length: float) -> bool:
        """Take a step, or the part of it up to the first transition; return whether it was the whole step."""
        step = self._step(length)
        places, found = self._places_of(step), list[tuple[float, bool, int, EventKind | AtEnd]]()
        for i in range(len(self.contacts) if self.scenario.contact.enabled else 0):
            for kind in self._guards(i):
                if self._guard(i, kind, places, step, length) < 0.0:
                    # what holds no longer lets go before others that it has held turn
                    found.append((self._locate(i, kind, length), kind is EventKind.REVERSAL, i, kind))
        if not found:
            self._accept(step, places, length)
            return True
        at, _, i, kind = min(found, key=lambda entry: entry[:3])
        if at > 0.0:
            step = self._step(at)
            self._accept(step, self._places_of(step), at)
        self._change(i, kind)
        if len(self.record.events) > MAX_EVENTS:
            raise RunEnded(Outcome.TOO_MANY_EVENTS)
        self._recent = 0 if at > 0.0 else self._recent + 1
        if self._recent > _MAX_AT_ONCE * len(self.contacts):
            raise RunEnded(Outcome.CHATTERING)
        return False

    def _places_of(self, step: Step) -> list[Place]:
        return [contact.touching.place(step.stage) for contact in self.contacts]

    def _step(self, length: float, holding: int = -1) -> Step:
        """Return a step with the closed contacts, one that is `holding` as if it stuck, and reactions of all.

        Raises RunEnded if its iterations do not converge.
        """
        closed = [i for i, contact in enumerate(self.contacts) if contact.is_closed]
        try:
            step = advance(
                self.beam,
                self.stage,
                length,
                self.load,
                held=self._held(self.time + length),
                viscosity=self.scenario.beam.kelvin_voigt,
                contacts=[self._contact(i, i == holding) for i in closed],
                tolerance=max(self.scenario.solver.tolerance, _LEAST_TOLERANCE),
            )
        except NotConvergedError:
            raise RunEnded(Outcome.NOT_CONVERGED) from None
        reactions, keeping = np.zeros((2, len(self.contacts)))
        reactions[closed], keeping[closed] = step.reactions, step.keeping
        return step._replace(reactions=reactions, keeping=keeping)

    def _held(self, at: float) -> Array:
        """Values of the prescribed unknowns at an instant (s)."""
        if self.scenario.root.kind != "driven":
            return np.zeros(2)
        angle = self.scenario.initial.angle + self.motion.at(at).angle
        return np.array([self.beam.radius * np.cos(angle), self.beam.radius * np.sin(angle), angle])

    def _contact(self, i: int, holding: bool = False) -> Contact:
        """Return a closed contact, as if it stuck if it is `holding`."""
        contact = self.contacts[i]
        if holding or contact.phase.state is State.STICK:
            return Contact(contact.touching, sticks=True)
        return Contact(contact.touching, friction=-self._kinetic * contact.phase.direction)

    def _accept(self, step: Step, places: list[Place], length: float) -> None:
        """Go to the end of a step and add its impulses and losses to the totals."""
        q0, q1 = self.stage.q, step.stage.q
        relaxation, held = self.scenario.beam.kelvin_voigt / length, step.held.size
        if relaxation:
            self.totals[DAMPING_LOSS] += self.beam.damping_loss(q0, q1, relaxation)
        self.totals[SUPPLIED] += float(step.held @ (q1 - q0)[:held])
        if self.scenario.root.kind == "hub":
            self.totals[SUPPLIED] += self.scenario.root.torque * float(q1[2] - q0[2])
        for i, contact in enumerate(self.contacts):
            if contact.is_closed:
                self._book(i, step, places[i], length)
        mean = self.beam.mean_resultants(q0, q1, relaxation)
        self._averages.add(self.time, self.time + length, Forces(*mean, step.reactions))
        self.stage, self.places, self.time = step.stage, places, self.time + length
        self.record.steps += 1

    def _book(self, i: int, step: Step, place: Place, length: float) -> None:
        """Add what a closed contact does within a step to the totals, its own and those of all."""
        contact, pushed = self.contacts[i], self._contact(i)
        rows = contact.touching.rows(self.stage.q, step.stage.q)
        force, _ = pushed.normal_force(rows.gap0, rows.gap1, length)
        tangential = float(step.reactions[i]) if pushed.sticks else pushed.friction * force
        elastic = -0.5 * contact.touching.law.stiffness * (rows.gap0 + rows.gap1)
        gained = np.zeros(QUADRATURES)
        gained[NORMAL_IMPULSE], gained[TANGENTIAL_IMPULSE] = force * length, tangential * length
        gained[FRICTION_LOSS] = -tangential * float(rows.tangential @ (step.stage.q - self.stage.q))
        gained[STOP_LOSS] = (force - elastic) * (rows.gap0 - rows.gap1)
        contact.totals += gained
        self.totals += gained
        opened, (first, last) = contact.opened, contact.reach
        assert opened is not None
        opened.peak_force = max(opened.peak_force, contact.touching.force(place))
        opened.depth = max(opened.depth, -place.gap)
        contact.reach = min(first, place.x), max(last, place.x)

    # --- contact states

    def _guards(self, i: int) -> tuple[EventKind | AtEnd, ...]:
        """Return the kinds of transition that the present state of a contact allows."""
        contact = self.contacts[i]
        if not contact.is_closed:
            return (EventKind.IMPACT,)
        ends = (AtEnd.SLIDES_OFF,) if contact.touching.extent else ()
        if contact.phase.state is State.STICK:
            return (EventKind.RELEASE, *ends, EventKind.SLIP)
        return (EventKind.RELEASE, *ends, *((EventKind.REVERSAL,) if contact.phase.direction else ()))

    def _guard(self, i: int, kind: EventKind | AtEnd, places: Sequence[Place], step: Step, length: float) -> float:
        """Return the guard of a transition at the end of a step: positive as long as it has not happened."""
        contact, after = self.contacts[i], places[i]
        if kind is EventKind.IMPACT:
            return contact.side * after.gap
        if kind is AtEnd.SLIDES_OFF:
            return self._inside(i, places)
        if kind is EventKind.RELEASE:
            return -after.gap
        if kind is EventKind.REVERSAL:
            return contact.phase.direction * after.slip_rate
        return self._static * self._mean_force(i, after, length) - abs(float(step.keeping[i]))

    def _inside(self, i: int, places: Sequence[Place]) -> float:
        """Return a length (m) that falls through zero where a contact slides off an end.

        The tip leaves a side for its corner where the corner comes onto the beam: both ways at the same place.
        """
        touching, place = self.contacts[i].touching, places[i]
        if i in self._heirs and isinstance(touching, PointOnSide):
            away = [abs(place.slip - end) for end in touching.extent]
            if away[touching.outer] < away[1 - touching.outer]:
                return places[self._heirs[i]].x - self.scenario.beam.length
        return touching.inside(place)

    def _mean_force(self, i: int, after: Place, length: float) -> float:
        """Return the mean normal force (N) of a step."""
        return Contact(self.contacts[i].touching).normal_force(self.places[i].gap, after.gap, length)[0]

    def _locate(self, i: int, kind: EventKind | AtEnd, length: float) -> float:
        """Length (s) of the step at whose end a guard falls to zero; 0 if it falls at once."""

        def at(part: float) -> float:
            step = self._step(part * length)
            return self._guard(i, kind, self._places_of(step), step, part * length)

        if at(_AT_ONCE) <= 0.0:
            return 0.0
        return float(brentq(at, _AT_ONCE, 1.0, xtol=1e-12, rtol=1e-14)) * length

    def _change(self, i: int, kind: EventKind | AtEnd) -> None:
        """Let a contact go through a transition, with a sample on either side of it."""
        contact, place = self.contacts[i], self.places[i]
        if kind is EventKind.IMPACT and (contact.side < 0.0 or contact.touching.is_beyond(place)):
            self._pass_end(i, AtEnd.COMES_BACK if contact.side < 0.0 else AtEnd.FALLS_PAST)
            return
        self._sample()
        if kind is AtEnd.SLIDES_OFF:
            self._leave_end(i)
        elif kind is EventKind.RELEASE:
            self._release(i)
        elif kind is EventKind.IMPACT:
            self._open(i)
        else:
            kind = self._at_zero_slip(i)
            self.record.events.append(self._event(i, kind))
        self._averages.cut()
        self._sample()

    def _pass_end(self, i: int, how: AtEnd) -> None:
        """Record how an end of a side is passed, and how the end of the beam where a contact has slid off it."""
        contact, place = self.contacts[i], self.places[i]
        contact.side = 1.0 if how is AtEnd.COMES_BACK else -1.0
        if isinstance(contact.touching, PointOnSide) or how is AtEnd.SLIDES_OFF:
            end = min(contact.touching.extent, key=lambda along: abs(along - place.slip))
            passage = records.Passage(self.time, how, place.slip, end, contact.touching.obstacle)
            self.record.passages.append(passage)

    def _leave_end(self, i: int) -> None:
        """Let a contact go that has slid off an end; the energy that its heir does not store is lost."""
        energies = [contact.touching.law.energy(place.gap) for contact, place in self._each()]
        at, depth = self.places[i].point, -self.places[i].gap
        heirs = [
            j
            for j in (self._heirs.get(i, i),)
            if not self.contacts[j].is_closed and energies[j] > 0.0 and abs(self.places[j].point - at) < depth
        ]
        loss = energies[i] - sum(energies[j] for j in heirs)
        self.contacts[i].totals[STOP_LOSS] += loss
        self.totals[STOP_LOSS] += loss
        self._pass_end(i, AtEnd.SLIDES_OFF)
        self._release(i)
        for j in heirs:
            self._open(j)

    def _open(self, i: int) -> None:
        """Begin a contact: it slips, with a direction where there is friction."""
        contact, place = self.contacts[i], self.places[i]
        contact.opened = OpenContact(self.time, _NO_IMPULSE, contact.totals.copy())
        contact.reach, contact.side = (place.x, place.x), 1.0
        direction = copysign(1.0, place.slip_rate) if self._static > 0.0 else 0.0
        contact.phase = Phase(State.SLIP, direction)
        self.record.events.append(self._event(i, EventKind.IMPACT))

    def _release(self, i: int) -> None:
        """End a contact, whose share of the finite force its event gets."""
        finite = self._close(i)
        self.contacts[i].phase = Phase(State.FREE)
        self.record.events.append(self._event(i, EventKind.RELEASE).with_share(finite))

    def _at_zero_slip(self, i: int) -> EventKind:
        """Choose stick or slip at an instant without slip, by the force that would hold the point for a step."""
        contact = self.contacts[i]
        was = contact.phase
        # where forces turn within a step, what follows contradicts it at once: then a part of the step decides
        length = min(self.scenario.solver.contact_step, self.scenario.solver.free_step)
        length *= _SHORTER ** min(self._recent, _SHORTEST)
        trial = self._step(length, holding=i)
        force = self._mean_force(i, contact.touching.place(trial.stage), length)
        reaction = float(trial.keeping[i])
        if was.state is not State.STICK and abs(reaction) <= self._static * force:
            contact.phase = Phase(State.STICK)
            return EventKind.STICK
        # the force of friction is on the side of the force that would hold the point
        contact.phase = Phase(State.SLIP, -copysign(1.0, reaction))
        return EventKind.SLIP if was.state is State.STICK else EventKind.REVERSAL

    def _event(self, i: int, kind: EventKind) -> records.Event:
        contact, place = self.contacts[i], self.places[i]
        event = records.Event(self.time, kind, 0.0, 0.0, place.gap_rate, place.slip_rate, 0.0, contact.phase.state)
        if self.scenario.contact.where == "point":
            return event
        return event._replace(obstacle=contact.touching.obstacle, place=place.x)

    def _close(self, i: int) -> records.Contact:
        """Record the end of a contact; returns the share of its finite force."""
        contact = self.contacts[i]
        assert contact.opened is not None
        whole, finite = contact.opened.closed(self.time, contact.totals, contact.touching.law)
        first, last = contact.reach
        self.record.contacts.append(
            whole._replace(obstacle=contact.touching.obstacle, first_place=first, last_place=last)
        )
        contact.opened = None
        return finite

    def _sample(self) -> None:
        """Store a sample; the section forces follow when the next steps are known."""
        phases, number = [contact.phase for contact in self.contacts], len(self.samples)
        sticks = np.array([phase.state is State.STICK for phase in phases], dtype=bool)
        normal = np.array([c.touching.force(place) if c.is_closed else 0.0 for c, place in self._each()])
        tangential = -self._kinetic * normal * np.array([phase.direction for phase in phases])
        at_once = self.beam.resultants(self.stage.q, self.stage.v, self.scenario.beam.kelvin_voigt)
        sample = Sample(
            self.time,
            self.stage,
            tuple(phase.state for phase in phases),
            tuple(contact.side for contact in self.contacts),
            tuple(self.places),
            normal,
            tangential,
            Forces(*at_once, np.zeros(len(phases))),
        )
        self.samples.append(sample)

        def store(forces: Forces) -> None:
            # stick ends where the mean of a step is at the edge of the cone: at its end it would be beyond
            edge = self._static * normal
            held = np.clip(forces.reactions, -edge, edge)
            along = np.where(sticks, held, tangential)
            self.samples[number] = self.samples[number]._replace(forces=forces, tangential=along)

        self._averages.request(self.time, store)
