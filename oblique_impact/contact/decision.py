"""The decision: which contact states follow, by which impulses, and which events these are (paper Secs. 4-6).

One table for every discretization, scheme and system, and for one contact or several.  A contact that is alone has
its answer in closed form; those that are closed together are decided together, impacts first, by Newton's law in
Moreau's form without friction, then the states by accelerations (:mod:`~oblique_impact.contact.complementarity`).
What these rules leave open is in :mod:`~oblique_impact.contact.degenerate`.

It is ordinary Python, which sees each :class:`~oblique_impact.contact.state.Candidate` in its state with its
problem at an instant, and answers with a :class:`~oblique_impact.contact.transitions.Transition`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from oblique_impact.contact import degenerate
from oblique_impact.contact.complementarity import Closed, contact_forces, plastic_impulses
from oblique_impact.contact.elastic import stop_force
from oblique_impact.contact.forces import (
    OK,
    begins_with_a_jump,
    can_slide,
    friction_rate,
    friction_ratio,
    holding_force,
    shared_flexibility,
    sliding_force,
    sliding_inertia,
    sticking_force,
)
from oblique_impact.contact.friction import FrictionLaw
from oblique_impact.contact.impacts import ImpactLaw, Impulse, impulse_of
from oblique_impact.contact.pairs import ContactPair
from oblique_impact.contact.state import (
    AT_AN_INSTANT,
    DEFINITE,
    END,
    GUARDS,
    NORMAL,
    SWITCHED,
    UPPER,
    VELOCITY,
    Baumgarte,
    Candidate,
    State,
    Tolerances,
)
from oblique_impact.contact.transitions import (
    AtEnd,
    ContactProbe,
    Earlier,
    EventKind,
    StickCriterion,
    Transition,
)
from oblique_impact.errors import Outcome, RunEnded
from oblique_impact.kernels.workspace import Array

#: of the largest rate of an impact, one that is rounding: drift of the constraints
_STILL = 1e-9
#: of the time scale: candidates that reach their obstacles within it are located at one instant, and their impacts
#: are one problem; which of them comes first is rounding
_AT_ONCE = 1e-11


class Decision:
    """The transition table of all candidates of contact of a run.

    Parameters
    ----------
    pairs : sequence of ContactPair
        The candidates; their stops are all rigid or all compliant.
    friction, impact_law : FrictionLaw, ImpactLaw
        Tangential law, and law of impacts on a rigid stop.
    tolerances : Tolerances
        What counts as zero.
    baumgarte : Baumgarte
        Stabilization of the contact constraints.
    stick_criterion : StickCriterion, optional
        Of a scheme that distinguishes stick from slip itself.  Default: transitions are located, the table does.
    """

    def __init__(
        self,
        pairs: Sequence[ContactPair],
        friction: FrictionLaw,
        impact_law: ImpactLaw,
        tolerances: Tolerances,
        baumgarte: Baumgarte = Baumgarte(),
        stick_criterion: StickCriterion | None = None,
    ) -> None:
        self.pairs, self.friction, self.impact_law = tuple(pairs), friction, impact_law
        self.tolerances, self.stick_criterion = tolerances, stick_criterion
        law = self.pairs[0].contact_law
        #: of compliant stops, as kernels call it
        self.law = law.kernel if law else None
        self.compliant, self.axial = law is not None, self.pairs[0].axial is not None
        #: of a scheme that notices transitions late, at the ends of its steps
        self._late = None if stick_criterion is None or stick_criterion.located else stick_criterion
        #: whether each contact is decided by itself: where the scheme distinguishes stick from slip transitions of
        #: others come in the next steps, and no force on axial flexibility jumps
        self._separate = self.compliant and (stick_criterion is not None or self.axial)
        self._speed = tolerances.velocity / VELOCITY  # m/s, of the motion itself
        stops = [pair.contact_law.stop if pair.contact_law else {} for pair in self.pairs]
        self._free = [
            Candidate(first=pair.ends[0], last=pair.ends[1]).changed(**stop | {"compliant": 0})
            for pair, stop in zip(self.pairs, stops, strict=True)
        ]
        correct_rate, correct_place = map(float, baumgarte)
        self._closed = [
            free.changed(
                static=-1.0 if friction.static is None else float(friction.static),
                held=float(pair.on_side),
                correct_rate=correct_rate,
                correct_place=correct_place,
                compliant=int(self.compliant),
            )
            for free, pair in zip(self._free, self.pairs, strict=True)
        ]

    # --- states of one contact

    def free(self, i: int, side: float = 1.0) -> Candidate:
        """Return the state of flight above the line of a side or, on the side -1, below it beyond its ends."""
        return self._free[i].changed(side=side)

    def opened(self, i: int, c: Candidate) -> Candidate:
        """Return a contact that begins where a candidate is, with the compliance behind it."""
        at = {name: getattr(c, name) for name in AT_AN_INSTANT}
        found = self._closed[i].changed(relaxation=c.relaxation, **at)
        if (axial := self.pairs[i].axial) is not None:
            found.axial, found.sense = axial(c.slip)
        return found

    def slide(self, c: Candidate, slip_rate: float, direction: int) -> Candidate:
        """Return the sliding state of a contact at a slip velocity (m/s), in a direction where that is 0."""
        intercept, slope, lower, upper = map(float, self.friction.branch(slip_rate, direction))
        return c.changed(state=int(State.SLIP), intercept=intercept, slope=slope, lower=lower, upper=upper)

    def pressed(self, i: int, probe: ContactProbe) -> Candidate:
        """Return the state in which a contact on a compliant stop begins, by itself."""
        c = self.opened(i, probe.of(i))
        return self._pressed_axially(c) if self.axial else self._alone(i, inclined(c), probe)[0]

    def _pressed_axially(self, c: Candidate) -> Candidate:
        """Return the state in which a contact on axial flexibility begins, where both its forces are zero.

        It sticks if the tangential force grows more slowly than the friction cone.
        """
        stuck, direction = stick_at(c), _sign(c.slip_rate)
        edge = stuck.changed(intercept=-direction * stuck.static, slope=0.0)
        # one that is found pressed in has no tangential force yet, and begins well inside of its cone
        touches = c.depth <= self.tolerances.gap and not begins_with_a_jump(c)
        slips = touches and direction * (c.slip_rate + c.axial * friction_rate(edge)) > 0.0
        return self.slide(stuck, c.slip_rate, direction) if slips else stuck

    def _resumed(self, i: int, earlier: Earlier, c: Candidate) -> Candidate:
        """Return the state of a contact that goes on from an earlier run, its axial flexibility stretched."""
        c = inclined(self.opened(i, c.changed(slip=earlier.began)).changed(slip=c.slip))
        if earlier.state == State.STICK:
            return stick_at(c.changed(slip=c.slip + c.axial * earlier.tangential_force))
        # with axial flexibility friction sees another velocity than that of the slip
        rate = 0.0 if self.axial else c.slip_rate
        return self.slide(c, rate, -1 if earlier.tangential_force > 0.0 else 1)

    # --- transitions

    def start(self, probe: ContactProbe, earlier: Mapping[int, Earlier] = {}) -> Transition:
        """Return the states at the start of a run: contacts may touch, press already or go on from `earlier`."""
        touching, states, passages = list[int](), dict[int, Candidate](), list[tuple[int, AtEnd]]()
        for i, pair in enumerate(self.pairs):
            c = probe.of(i)
            if i in earlier:
                states[i] = self._resumed(i, earlier[i], c)
            elif pair.behind and c.gap < -self.tolerances.gap:
                states[i] = self.free(i, -1.0)
            elif pair.is_beyond(c.slip):
                if c.gap < -self.tolerances.gap:
                    states[i] = self.free(i, -1.0)
                elif pair.on_side and not self._is_apart(c):
                    states[i] = self.free(i, -1.0)
                    passages.append((i, AtEnd.FALLS_PAST))
            elif not self._is_apart(c) and not (self.stick_criterion and self.stick_criterion.located):
                touching.append(i)  # with a criterion that is located it falls in the first step
        found = self._touch(touching, probe) if touching else Transition()
        found.states |= states
        found.passages += passages
        found.events += [(i, EventKind.IMPACT) for i in earlier]
        found.pulls = {i: of.tangential_force for i, of in earlier.items()}
        return found

    def _is_apart(self, c: Candidate) -> bool:
        """Whether nothing touches at the start of a run; a stop that is pressed in still pushes as it opens."""
        pressed = self.compliant and c.gap < -self.tolerances.gap
        return c.gap > self.tolerances.gap or (c.gap_rate > self.tolerances.velocity and not pressed)

    def after_guard(self, guard: int, lately: Sequence[int], probe: ContactProbe) -> Transition:
        """Return the transition after a guard of a contact fell; raises RunEnded where no state exists.

        `lately` are contacts that an impact has opened a moment ago: impacts may alternate, see
        :mod:`oblique_impact.contact.degenerate`.
        """
        n = len(self.pairs)
        i, which = divmod(guard, GUARDS) if guard < GUARDS * n else (guard - GUARDS * n, SWITCHED)
        own, pair = probe.of(i), self.pairs[i]
        if own.state == State.FREE:
            if own.side < 0.0:
                return Transition.to(i, self.free(i), at_end=AtEnd.COMES_BACK)
            if pair.is_beyond(own.slip):
                return Transition.to(i, self.free(i, -1.0), at_end=AtEnd.FALLS_PAST)
            return self._touch(sorted([i, *self._arriving(i, probe)]), probe, lately)
        if which == NORMAL:  # its force is 0: the others' stay as they are
            return Transition.to(i, self.free(i), EventKind.RELEASE)
        others = [] if self._separate else [j for j in self._standing(probe) if j != i]
        if which == END:
            # a fixed step may leave it a little above the line
            side = 1.0 if own.gap > self.tolerances.gap else -1.0
            left = Transition.to(i, self.free(i, side), EventKind.RELEASE, AtEnd.SLIDES_OFF)
            return self._decide(others, probe, left)
        if which == DEFINITE:
            return self._leave_singular([i, *others], probe)
        if own.state == State.STICK:
            if self._late and not self.axial:
                return self._leave_stick_late(i, probe.coupled(i))
            # guard LOWER: lambda_tau reached +static lambda_n, so the contact slips backwards
            direction = 1 if which == UPPER else -1
            return self._decide([i, *others], probe, Transition(), leaves={i: direction})
        if self.axial:  # it sticks from where its slip ends
            c = probe.coupled(i)
            at = c.slip + c.axial * sliding_force(self.law, c).tangential
            return Transition.to(i, stick_at(c.changed(slip=at)), EventKind.STICK)
        if which == SWITCHED:
            return self._project_on_stick(i, probe.coupled(i))
        kink = own.upper if which == UPPER else own.lower
        if self.friction.static is None or self.stick_criterion or kink != 0.0:
            return self._next_branch(i, own, which)
        return self._decide([i, *others], probe, Transition(), at_rest=[i])

    def _standing(self, probe: ContactProbe) -> list[int]:
        """Return the contacts that are closed."""
        return [i for i in range(len(self.pairs)) if probe.of(i).state != State.FREE]

    def _arriving(self, i: int, probe: ContactProbe) -> list[int]:
        """Return the other candidates that reach rigid obstacles at the same instant, see `_AT_ONCE`.

        One that another brings to rest as well, at the same place, follows without speed.
        """
        if self.compliant:  # whose forces begin at zero, in any order
            return []
        tolerances, found = self.tolerances, list[int]()
        for j, pair in enumerate(self.pairs):
            c = probe.of(j)
            meets = c.state == State.FREE and c.side > 0.0 and not pair.is_beyond(c.slip)
            within = tolerances.gap - _AT_ONCE * tolerances.time * c.gap_rate
            if j != i and meets and c.gap_rate < -tolerances.velocity and c.gap <= within:
                normals = [probe.together([k, j], {})[1][:, 0, :, 0] for k in (i, *found)]
                if not any(map(degenerate.is_redundant, normals)):
                    found.append(j)
        return found

    def _touch(self, touching: list[int], probe: ContactProbe, lately: Sequence[int] = ()) -> Transition:
        """Return what follows as gaps close: an impact or, without speed or on compliant stops, contact."""
        if self._separate:
            pressed = {i: self.pressed(i, probe) for i in touching}
            return Transition(pressed, [(i, EventKind.IMPACT) for i in touching])
        contacts = [*touching, *self._standing(probe)]
        if self.compliant:
            return self._decide(contacts, probe, Transition())
        contacts += [i for i in lately if i not in contacts]
        impulses, opened = self._strike(contacts, probe, bool(lately))
        change, staying = Transition(impulses=impulses), [i for i in contacts if i not in opened]
        try:
            return self._decide(staying, probe, change, opened)
        except RunEnded as ended:
            if not impulses:
                raise
            # the impact has been; no state exists behind it
            found = Transition(impulses=impulses, failure=ended.outcome)
            for i, c in zip(staying, probe.together(staying, impulses)[0], strict=True):
                if c.state == State.FREE:
                    found.states[i] = self.slide(self.opened(i, c), c.slip_rate, _sign(c.slip_rate))
                    found.events.append((i, EventKind.IMPACT))
            return found

    def _strike(
        self, contacts: Sequence[int], probe: ContactProbe, alternate: bool
    ) -> tuple[dict[int, Impulse], list[int]]:
        """Return the impulses of an impact on rigid stops, none without speed, and the contacts that it opens.

        Of those that `alternate` an impact has just opened some.
        """
        group, delassus = probe.together(contacts, {})
        tolerance, rates = self.tolerances.velocity, np.array([c.gap_rate for c in group])
        if len(contacts) == 1:
            (i,), (c,) = contacts, group
            if degenerate.grazes(c, self.tolerances):
                return {}, []
            restitution = self.impact_law.restitution
            impulses = {i: self._impulse(c, restitution)}
            after = probe.after(impulses)[i]
            if restitution > 0.0 and degenerate.bounces_accumulate(after, self.tolerances, self._late is None):
                impulses = {i: self._impulse(c, 0.0)}
                after = probe.after(impulses)[i]
            return impulses, [i] if after.gap_rate > tolerance else []
        if np.min(rates) >= -tolerance:
            return {}, []
        normal = delassus[:, 0, :, 0]
        if degenerate.is_redundant(normal):
            raise RunEnded(Outcome.REDUNDANT_CONSTRAINTS)
        found = self._struck(contacts, rates, normal, self.impact_law.impulses(normal, rates))
        if alternate or (found[1] and self._bounces_accumulate(contacts, normal, *found, probe)):
            found = self._struck(contacts, rates, normal, degenerate.close_all(normal, rates))
        return found

    def _struck(
        self, contacts: Sequence[int], rates: Array, normal: Array, sizes: Array
    ) -> tuple[dict[int, Impulse], list[int]]:
        """Return the impulses of these sizes (N s) with what they take, and the contacts that they open."""
        after_rates = rates + normal @ sizes
        impulses = {
            i: Impulse(float(size), 0.0, float(-size * mean))
            for i, size, mean in zip(contacts, sizes, 0.5 * (rates + after_rates), strict=True)
            if size != 0.0
        }
        least = self.tolerances.velocity + _STILL * np.max(np.abs(rates))
        return impulses, [i for i, rate in zip(contacts, after_rates, strict=True) if rate > least]

    def _bounces_accumulate(
        self,
        contacts: Sequence[int],
        normal: Array,
        impulses: Mapping[int, Impulse],
        opened: Sequence[int],
        probe: ContactProbe,
    ) -> bool:
        """Whether no contact that an impact opens rises far enough to be told from one that stays closed.

        The others are taken to press without friction meanwhile.
        """
        after = probe.together(contacts, impulses)[0]
        accelerations = np.array([c.gap_acceleration for c in after])
        stay = [k for k, i in enumerate(contacts) if i not in opened]
        if stay:
            accelerations += normal[:, stay] @ plastic_impulses(normal[np.ix_(stay, stay)], accelerations[stay])
        return all(
            degenerate.bounces_accumulate(c.changed(gap_acceleration=float(a)), self.tolerances, True)
            for i, c, a in zip(contacts, after, accelerations, strict=True)
            if i in opened
        )

    def _impulse(self, c: Candidate, restitution: float) -> Impulse:
        """Return the impulse of the impact law in plain numbers: a user-defined one may have others."""
        return Impulse(*map(float, self.impact_law.impulse(c, restitution)))

    def _leave_singular(self, contacts: Sequence[int], probe: ContactProbe) -> Transition:
        """Return other states of sliding contacts whose forces grow without bound; raises RunEnded without any."""
        try:
            found = Transition() if self.axial else self._decide(contacts, probe, Transition())
        except RunEnded:
            found = Transition()
        if not found.events:
            group, delassus = probe.together(contacts, {})
            raise RunEnded(degenerate.unbounded_forces(group, delassus[:, 0, :, 0]))
        return found

    def _project_on_stick(self, i: int, c: Candidate) -> Transition:
        """Set the slip velocity to zero by an impulse that leaves the gap rate unchanged."""
        found = Transition.to(i, stick_at(c), EventKind.STICK)
        if self._late and self._late.projects:
            if self.compliant:
                projection = impulse_of(c, 0.0, -c.slip_rate / c.a_tt)
            else:
                per_rate = c.slip_rate / (c.a_nn * c.a_tt - c.a_nt * c.a_nt)
                projection = impulse_of(c, c.a_nt * per_rate, -c.a_nn * per_rate)
            found.stick_projections[i] = projection
        return found

    def _leave_stick_late(self, i: int, c: Candidate) -> Transition:
        """Return the slip that a scheme finds at the end of a step."""
        assert self._late is not None
        rate, direction = c.slip_rate, _sign(c.slip_rate)
        if self._late.projects:
            # the force that would hold it decides, not a slip velocity that is rounding or stabilization
            rate, direction = 0.0, -1 if holding_force(self.law, c, 0.0).tangential > 0.0 else 1
        return Transition.to(i, self.slide(c, rate, direction), EventKind.SLIP)

    def _next_branch(self, i: int, c: Candidate, guard: int) -> Transition:
        upward = guard == UPPER
        # a located kink is where the slip velocity is, up to rounding that could fall on either side of it
        kink = c.slip_rate if self._late else (c.upper if upward else c.lower)
        following = self.slide(c, kink, 1 if upward else -1)
        reversed_ = direction_of(c) * direction_of(following) < 0
        return Transition.to(i, following, EventKind.REVERSAL if reversed_ else None)

    # --- states that follow

    def _decide(
        self,
        contacts: Sequence[int],
        probe: ContactProbe,
        change: Transition,
        opened: Sequence[int] = (),
        at_rest: Sequence[int] = (),
        leaves: Mapping[int, int] = {},
    ) -> Transition:
        """Add the states of contacts with zero gap rate, or on compliant stops, to a change, with their events.

        The contacts `opened` leave by an impact.  Of those `at_rest` the slip has just ended, those that `leaves`
        names have been stuck and begin to slip in the given direction.  Raises RunEnded where no state exists.
        """
        states = {i: self.free(i) for i in opened}
        if contacts:
            group, delassus = probe.together(contacts, change.impulses)
            group = [
                c if c.state != State.FREE else inclined(self.opened(i, c))
                for i, c in zip(contacts, group, strict=True)
            ]
            if len(contacts) == 1 and (self.compliant or not self.axial or group[0].state == State.FREE):
                (i,), (c,) = contacts, group
                if i in at_rest or i in leaves:
                    c = c.changed(slip_rate=0.0)
                states[i], several = self._alone(i, c, probe, not change.impulses, leaves.get(i, 0))
            else:
                found, several = self._together(contacts, group, delassus, probe, at_rest, leaves)
                states |= found
            change.ambiguous = change.ambiguous or several
        for i, state in states.items():
            struck = i in change.impulses and change.impulses[i].normal > 0.0
            change.events += [(i, kind) for kind in _kinds(probe.of(i), state, struck)]
            change.states[i] = state
        return change

    def _alone(
        self, i: int, c: Candidate, probe: ContactProbe, present: bool = True, leaves: int = 0
    ) -> tuple[Candidate, bool]:
        """Return the state of one closed contact, and whether there was another solution: the closed form.

        Its gap and gap rate are zero, or its stop is compliant.  It is `present` if the candidate is where the run
        is; one that `leaves` stick begins to slip in that direction.
        """

        def ahead() -> float:
            return probe.slip_rate_ahead(i) if present else 0.0

        static, rate = self.friction.static, c.slip_rate
        if leaves:
            return self._slide_or_free(i, c, leaves)
        if self.axial:  # a rigid stop: the spring along the beam has no force yet
            stuck = stick_at(c)
            held = self._unstabilized(stuck).changed(travel=stuck.slip)
            return (stuck if sticking_force(self.law, held).normal > 0.0 else self.free(i)), False
        still = self.tolerances.velocity + (_STILL * self._speed if c.state == State.STICK else 0.0)
        if static is None:
            turns = abs(rate) <= still and degenerate.rows_are_parallel(c)
            rate = degenerate.turning_rate(c, ahead()) if turns else rate
            return self._slide_or_free(i, c, _sign(rate))
        if abs(rate) > still:
            # slip that ends within a step is found at its end, unless the force alone decides (the paper)
            if self._late is None or self._late.projects or not self._holds(c, static):
                return self._slide_or_free(i, c, _sign(rate))
            return stick_at(c), False
        resting = c.changed(slip_rate=0.0)
        force = holding_force(self.law, self._unstabilized(resting), 0.0)
        if force.status != OK or degenerate.rows_are_parallel(resting):
            rate = degenerate.turning_rate(resting, ahead())
            if rate == 0.0 and not self.compliant and c.gap_acceleration < 0.0:
                raise RunEnded(Outcome.REDUNDANT_CONSTRAINTS)
            return self._slide_or_free(i, resting, _sign(rate))
        if not self.compliant and not self._late and static * abs(c.a_nt) >= c.a_nn:  # perhaps not the only one
            delassus = np.array([[c.a_nn, c.a_nt], [c.a_nt, c.a_tt]]).reshape(1, 2, 1, 2)
            found, several = self._together([i], [resting], delassus, probe, [i])
            return found[i], several
        if abs(force.tangential) <= static * (force.normal + c.tilt * force.tangential):
            return (c if c.state == State.STICK else stick_at(c)), False
        return self._slide_or_free(i, resting, -1 if force.tangential > 0.0 else 1)

    def _holds(self, c: Candidate, static: float) -> bool:
        """Whether the force that keeps a contact sticking, whatever its slip velocity, lies in the cone."""
        force = holding_force(self.law, self._unstabilized(c), 0.0)
        normal = force.normal + c.tilt * force.tangential
        return force.status == OK and normal > 0.0 and abs(force.tangential) <= static * normal

    def _unstabilized(self, c: Candidate) -> Candidate:
        """Return a contact in which Baumgarte's stabilization of the normal constraint does nothing."""
        return c if self.compliant else c.changed(gap=0.0, gap_rate=0.0)

    def _slide_or_free(self, i: int, c: Candidate, direction: int) -> tuple[Candidate, bool]:
        """Return a contact that slides, or opens, and whether it could do both."""
        sliding = self.slide(c, c.slip_rate, direction)
        if self.compliant:
            if not can_slide(sliding):
                raise RunEnded(Outcome.PAINLEVE)
            return sliding, False
        force = sliding_force(self.law, self._unstabilized(sliding))
        if force.status != OK:
            raise RunEnded(Outcome.PAINLEVE)
        pushes = force.normal > 0.0
        if self._late:  # a contact noticed below the slope is pushed out by its stabilization
            pushes = pushes or sliding_force(self.law, sliding).normal > 0.0
        return (sliding if pushes else self.free(i)), sliding_inertia(sliding) < 0.0 < c.gap_acceleration

    def _together(
        self,
        contacts: Sequence[int],
        group: Sequence[Candidate],
        delassus: Array,
        probe: ContactProbe,
        at_rest: Sequence[int],
        leaves: Mapping[int, int] = {},
    ) -> tuple[dict[int, Candidate], bool]:
        """Decide by accelerations which contacts stay closed, which stick and which way the others slip.

        Says as well whether there were other solutions.
        """
        static = self.friction.static
        if self.axial:
            group, delassus = self._on_axis(group, delassus, probe)
        slips: dict[int, int] = {}
        several = False
        for i, c in zip(contacts, group, strict=True):
            still = self.tolerances.velocity + (_STILL * self._speed if c.state == State.STICK else 0.0)
            moving = abs(c.slip_rate) > still and i not in at_rest and i not in leaves
            slips[i] = leaves.get(i, _sign(c.slip_rate) if moving or static is None else 0)
        for _ in range(len(contacts) + 1):
            closed = [self._problem(c, slips[i]) for i, c in zip(contacts, group, strict=True)]
            free = np.array([[c.gap_acceleration, c.slip_acceleration] for c in group])
            solution = contact_forces(delassus, free, closed)
            several = several or solution.several
            begun = {
                i: _sign(a)
                for i, a, force in zip(contacts, solution.accelerations[:, 1], solution.forces, strict=True)
                if slips[i] == 0 and a != 0.0 and force[0] > 0.0
            }
            slips |= begun
            if not begun:
                break
        found, kept = {}, []
        for i, c, force in zip(contacts, group, solution.forces, strict=True):
            if force[0] <= 0.0 and not self.compliant:
                found[i] = self.free(i)
                continue
            kept.append(i)
            if slips[i] != 0:
                found[i] = self.slide(c, 0.0 if i in leaves else c.slip_rate, slips[i])
            else:
                found[i] = c if c.state == State.STICK else stick_at(c)
        if len(contacts) > 1:
            self._check(contacts, kept, found, delassus)
        return found, several

    def _on_axis(
        self, group: Sequence[Candidate], delassus: Array, probe: ContactProbe
    ) -> tuple[list[Candidate], Array]:
        """Return the problem of rigid contacts with axial flexibility, whose slips are displacements at once.

        Without mass the material slides until the forces, which stretch the axis, are within the cones: in the
        place of the accelerations of slip stand the displacements, in units that leave the numbers of one size.
        """
        every = [probe.coupled(j) for j in range(len(self.pairs))]
        closed = [c for c in every if c.state != State.FREE]
        shared = np.array([[shared_flexibility(c, other) for other in group] for c in group])
        unit = delassus[0, 0, 0, 0] / shared[0, 0]
        delassus = delassus.copy()
        delassus[:, 1, :, 0], delassus[:, 1, :, 1] = 0.0, unit * shared
        moved = []
        for c in group:
            # one that slides goes on, but for a cone that grows
            held = sum(
                shared_flexibility(c, other)
                * other.tangential_force
                * (1.0 + _STILL if other.state == State.SLIP else 1.0)
                for other in closed
            )
            moved.append(c.changed(slip_rate=0.0, slip_acceleration=-unit * held))
        return moved, delassus

    def _check(
        self, contacts: Sequence[int], kept: Sequence[int], states: Mapping[int, Candidate], delassus: Array
    ) -> None:
        """Raise RunEnded if the constraints of the contacts that stay closed are redundant."""
        rows = [] if self.compliant else [(contacts.index(i), 0) for i in kept]
        rows += [(contacts.index(i), 1) for i in kept if states[i].state == State.STICK]
        if rows and degenerate.is_redundant(np.array([[delassus[*a, *b] for b in rows] for a in rows])):
            raise RunEnded(Outcome.REDUNDANT_CONSTRAINTS)

    def _problem(self, c: Candidate, slip: int) -> Closed:
        """Return a contact with its direction of slip, 0 at rest, for the solution of all together."""
        static = self.friction.static
        if self.axial and c.state == State.SLIP:  # it has not stuck yet
            static = abs(c.intercept)
        push = stop_force(self.law, c, c.depth, c.depth_rate) if self.compliant else None
        sliding = self.slide(c, c.slip_rate if slip else 0.0, slip or 1)
        return Closed(slip, friction_ratio(sliding) if slip else 0.0, static or 0.0, push)


def _kinds(before: Candidate, after: Candidate, struck: bool) -> list[EventKind]:
    """Return the events of a contact that goes over from one state to another, perhaps struck by an impact."""
    was_free, is_free = before.state == State.FREE, after.state == State.FREE
    if was_free and is_free:
        return [EventKind.REBOUND] if struck else []
    if struck or was_free:
        return [EventKind.IMPACT, EventKind.RELEASE] if is_free else [EventKind.IMPACT]
    if is_free:
        return [EventKind.RELEASE]
    if after.state != before.state:
        return [EventKind.STICK if after.state == State.STICK else EventKind.SLIP]
    turns = after.state == State.SLIP and direction_of(after) * direction_of(before) < 0
    return [EventKind.REVERSAL] if turns else []


def inclined(c: Candidate) -> Candidate:
    """Return a contact with the slip of the place itself, Z_tau + tilt Z_n, as the body yields."""
    t = c.tilt
    if t == 0.0:
        return c
    return c.changed(
        slip=c.slip + t * c.gap,
        slip_rate=c.slip_rate + t * c.gap_rate + c.tilt_slope * c.shift_rate * c.gap,
        a_nt=c.a_nt + t * c.a_nn,
        a_tt=c.a_tt + t * (2.0 * c.a_nt + t * c.a_nn),
        slip_acceleration=c.slip_acceleration + t * c.gap_acceleration,
    )


def stick_at(c: Candidate) -> Candidate:
    """Return the sticking state of a contact at its present slip."""
    return c.changed(state=int(State.STICK), kept_slip=float(c.slip))


def direction_of(c: Candidate) -> int:
    """Direction of slip on a branch: +1, -1, or 0 for a branch on both sides of zero."""
    return int(c.lower >= 0.0) - int(c.upper <= 0.0)


def _sign(value: float) -> int:
    return 1 if value >= 0.0 else -1
