"""Beams at rest: the equilibrium of a scenario under its loads at t = 0, and that of a beam that is plucked.

Coordinates q and contact forces s >= 0, without friction, obey

    F(q) + D^T s = 0,    0 <= s  _|_  g(q) + W s >= 0

with the generalized forces F of weight, torque and elasticity, gaps g and their rows D = dg/dq; W is the
compliance of springs and beds with what the coordinates leave out of the beam, 0 of rigid stops.  From the
undeformed beam Newton's method goes on with the contacts that are closed (an active set); where the tangent is not
positive definite, or contacts open or close, a step is that to the least of a quadratic energy under all gaps (a
least-distance problem, Lawson and Hanson, Solving Least Squares Problems, 1974, Ch. 23), no longer than a tenth of
a radian and of the beam's length: so a beam comes down on what it falls on, and no unstable equilibrium is found.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import LinAlgError, cho_solve, cholesky, null_space, solve_triangular

from oblique_impact.beam.beam import Beam, ContactPlace
from oblique_impact.beam.bent_beam import direction_of
from oblique_impact.beam_problem import Parts, beam_of, beam_tolerances, decision_about, scheme_of
from oblique_impact.contact.compliance import across, across_by_shift
from oblique_impact.contact.elastic import share_of, stop_force
from oblique_impact.contact.state import DIRECTION, SLIDING, STICKING, Candidate, Contacts
from oblique_impact.contact.stops import NO_INERTIA
from oblique_impact.contact.transitions import Earlier
from oblique_impact.errors import InputError
from oblique_impact.kernels.jit import is_compiled
from oblique_impact.kernels.workspace import FORCES, Array
from oblique_impact.marching.sampling import solve_problem
from oblique_impact.marching.scheme import Scheme
from oblique_impact.scenario.messages import refused
from oblique_impact.scenario.scenario import Scenario

Mask = NDArray[np.bool_]

_MOST_STEPS = 500
#: largest step: rotation (rad), and deflection over the length
_LONGEST = 0.1
#: sizes of a step: a smaller one than the last that does not halve it is rounding; one that is no number's
_SETTLED, _ROUNDING = 1e-9, 1e-15
#: of the beam's length: gaps that are no deeper are closed to rounding; of the target of a least distance
_ROUNDED = 1e-12
#: of coordinates, for differences of the forces of contacts
_DIFFERENCE = 1e-5
#: of the beam's length: candidates that are farther away than this are not looked at in a step
_NEAR = 0.5


class Point(NamedTuple):
    """Forces and contacts of a beam in a state, of n candidates and d coordinates."""

    load: Array  # (d,) F, with the forces by the change of compliances
    gaps: Array  # (n,) m
    slips: Array  # (n,) m
    rows: Array  # (n, 2, d) of gap and slip
    pressing: Array  # (n,) N, of closed elastic contacts, with their damping


class ContactStiffness(NamedTuple):
    """How contacts change with the coordinates about a state."""

    stiffness: Array  # (d, d)
    springs: Array  # (m, d) N/m, by which the forces of m closed elastic contacts fall


class Balance:
    """The forces on a beam of a scenario in any state, and on its candidates of contact those of its law.

    Parameters
    ----------
    beam : Beam
        The beam, in any model but the exact one.
    parts : Parts
        User-defined parts of the run.
    """

    def __init__(self, beam: Beam, parts: Parts = Parts()) -> None:
        s, self.beam = beam.scenario, beam
        compliance, system = beam.compliance, beam.model
        if s.contact.normal == "rigid" and compliance is not None and compliance.bends:
            parts = replace(parts, contact_law=NO_INERTIA)  # in time-stepping too, whose own law has it elsewhere
        tolerances, scheme = beam_tolerances(s, beam.mass), parts.scheme or scheme_of(s)
        self.decision = decision_about(beam.candidates, s, scheme, tolerances, parts, compliance)
        self.elastic, self.count = self.decision.compliant, len(beam.candidates)
        self.free = slice(1 if s.root.kind == "driven" else 0, beam.size)
        packed = is_compiled(system)
        self._flight = [self.decision.free(i) for i in range(self.count)]
        bent = compliance if compliance is not None and compliance.bends else None
        self.contacts = Contacts.new(self._flight, beam.size, packed, self.decision.law, bent)
        self.work, self._mass, self._closed = system.new_workspace(), np.zeros(1), np.zeros(self.count, dtype=bool)
        self.enabled = s.contact.enabled

    def at(self, q: Array, qd: Array, closed: Mask) -> Point:
        """Return forces and contacts at coordinates and velocities (d,), with these contacts closed (n,)."""
        contacts = self.contacts
        if not np.array_equal(closed, self._closed):
            for i, c in enumerate(self._flight):
                state = self.decision.opened(i, c).changed(state=SLIDING, axial=0.0) if closed[i] else c
                contacts.take(i, state)
            self._closed = closed.copy()
        solve_problem(self.beam.model, contacts, 0.0, q, qd, self.work, self._mass)
        pressing = np.zeros(self.count)
        for i in np.flatnonzero(closed).tolist() if self.elastic else ():
            c = contacts.of(i)
            pressing[i] = stop_force(self.decision.law, c, c.depth, c.depth_rate)
        rows = contacts.rows[DIRECTION, :, :2].copy()
        return Point(self.work.vectors[FORCES].copy(), self._column("gap"), self._column("slip"), rows, pressing)

    def _column(self, name: str) -> Array:
        """Return a number of all candidates in the state of the last `at`, (n,)."""
        each = self.contacts.each
        return np.array(each[name] if isinstance(each, np.ndarray) else [getattr(c, name) for c in each])

    def mass_matrix(self) -> Array:
        """Return the mass matrix (d, d) in the state of the last `at`."""
        product, columns = np.zeros(self.beam.size), []
        for unit in np.eye(self.beam.size):
            self.beam.model.mass_product(float(self._mass[0]), self.work, unit, product)
            columns.append(product.copy())
        return np.array(columns).T

    def are_beyond(self, slips: Array) -> Mask:
        """Return which contacts are beyond the ends of their sides at slips (n,) in m, or behind them."""
        pairs = zip(self.decision.pairs, slips.tolist(), strict=True)
        return np.array([pair.behind or pair.is_beyond(slip) for pair, slip in pairs])

    def compliances(self, near: NDArray[np.intp], fixed: Mask, forces: Array | None = None) -> Array:
        """Return W (m, m) in m/N in the state of the last `at`, 0 of contacts that are `fixed`.

        A stop of any law has its compression over its force or, at given `forces` (n,), the slope of that.
        """
        found, bent = np.zeros((near.size, near.size)), self.contacts.compliance
        if not self.elastic:
            return found
        for k, i in enumerate(near.tolist()):
            found[k, k] = self._softness(self.contacts.of(i), None if forces is None else float(forces[i]))
            if bent is not None:
                found[k] += [across(bent, i, 0, j, 0) for j in near.tolist()]
        found[fixed], found[:, fixed] = 0.0, 0.0
        return found

    def size(self, move: Array) -> float:
        """Return the size of a change of the free coordinates: rotation (rad), or deflection over the length."""
        whole = np.zeros(self.beam.size)
        whole[self.free] = move
        return float(max(abs(self.beam.split(whole)[0]), self.beam.relative_deflection(whole[None])[0]))

    def held_stiffness(self, bend: Array) -> Array:
        """Return the stiffness (d, d) of the beam's own bending, with a spring of its weight on the frame.

        Without loads this is of the size of the tangent `bend` (d, d).
        """
        beam, root = self.beam, self.beam.scenario.root
        moment = beam.scenario.largest_gravity * beam.operators.Sm + abs(root.torque)
        return beam.held_stiffness(moment or float(np.max(np.abs(bend))))

    def _softness(self, c: Candidate, force: float | None) -> float:
        """Compression over force (m/N) of a stop alone where it is or, at a force (N), the slope of that."""
        law, own = self.decision.law, c.share * c.stiffness
        if law is not None and c.depth > 0.0:
            alone, compressed = c.changed(compliance=0.0), c.depth
            compressed -= c.compliance * float(stop_force(law, c, c.depth, 0.0))
            low = compressed * (1.0 - _DIFFERENCE) if force is not None else 0.0
            high = compressed * (1.0 + _DIFFERENCE) if force is not None else compressed
            pushes = [float(stop_force(law, alone, depth, 0.0)) for depth in (low, high)]
            own = (pushes[1] - pushes[0]) / (high - low) if high > low else own
        return 1.0 / own if own > 0.0 else 1e300

    def linearize(self, q: Array, elastic: Mask, forces: Array) -> ContactStiffness:
        """Return how contacts change with the coordinates (d,), by central differences at fixed forces (n,) in N.

        Stationary in the forces s, contacts hold V = -g.s - s.W s/2, whose second derivatives are those of the
        springs between the gaps g + W s and, at fixed forces, those of g and W.
        """
        closed, still, size = np.flatnonzero(elastic), np.zeros_like(q), _DIFFERENCE
        bent, rows = np.zeros((q.size, q.size)), np.zeros((self.count, q.size))
        for j in range(self.free.start, q.size if forces.any() else 0):
            move = size * np.eye(1, q.size, j)[0]
            before, after = (self._at_forces(q + side * move, still, elastic, forces) for side in (-1.0, 1.0))
            bent[:, j], rows[:, j] = (before[0] - after[0]) / (2.0 * size), (after[1] - before[1]) / (2.0 * size)
        self.at(q, still, elastic)
        soft, rows = self.compliances(closed, np.zeros(closed.size, dtype=bool), forces), rows[closed]
        springs = np.asarray(np.linalg.solve(soft, rows) if closed.size else rows)
        stiffness = bent + rows.T @ springs
        return ContactStiffness(0.5 * (stiffness + stiffness.T), springs)

    def _at_forces(self, q: Array, still: Array, elastic: Mask, forces: Array) -> tuple[Array, Array]:
        """Return the generalized force (d,) of contacts with given forces (n,), and their gaps with W s (n,)."""
        point, y = self.at(q, still, elastic), self.contacts.compliance
        push, gaps, closed = forces @ point.rows[:, 0], point.gaps.copy(), np.flatnonzero(elastic).tolist()
        for i in closed:
            c = self.contacts.of(i)
            if c.cell != 0.0:  # of a bed that is there in part
                share, fading = share_of(c.slip, c.first, c.last, c.cell)
                compressed = forces[i] / (share * c.stiffness)
                gaps[i] += compressed
                push -= 0.5 * c.stiffness * fading * compressed**2 * point.rows[i, 1]
            if y is not None:
                gaps[i] += sum(across(y, i, 0, j, 0) * forces[j] for j in closed)
                turned = sum(across_by_shift(y, i, 0, j, 0) * forces[j] for j in closed)
                push += forces[i] * turned * self.contacts.rows[DIRECTION, i, 2]
        return push, gaps


class Rest(NamedTuple):
    """A beam at rest, and its n contacts."""

    q: Array  # (d,) coordinates
    forces: Array  # (n,) N, along the gaps
    gaps: Array  # (n,) m
    slips: Array  # (n,) m
    rigid: Mask  # (n,) contacts that are held without compliance
    elastic: Mask  # (n,) those that are closed on springs, beds, or what the coordinates leave out
    stiffness: Array  # (d, d) tangent stiffness, with that of elastic contacts

    @property
    def closed(self) -> list[int]:
        """Contacts that are closed, by their numbers."""
        return np.flatnonzero(self.rigid | self.elastic).tolist()


class Hold(NamedTuple):
    """What holds a plucked beam, the last candidate of its balance: a gap (m) or, without one, a force (N)."""

    gap: float | None = None
    force: float = 0.0


class _Here(NamedTuple):
    """A state of the search: forces over the free coordinates (f,), and contacts that are possible there."""

    load: Array  # (f,) N, without contacts but with the force of a hold
    rows: Array  # (n, f) of the gaps
    gaps: Array  # (n,) m, of a hold from what it holds
    slips: Array  # (n,) m
    pressing: Array  # (n,) N, of closed elastic contacts
    fixed: Mask  # (n,) a gap that is held from both sides
    rigid: Mask  # (n,) held without compliance
    elastic: Mask  # (n,) closed, of the others
    near: NDArray[np.intp]  # (m,) all that can be closed
    W: Array  # (m, m) m/N, their compliance


def rest(balance: Balance, start: Array, hold: Hold | None = None) -> Rest:
    """Return the equilibrium that is found from coordinates (d,), with a `hold` or without.

    Raises InputError if there is none, or none is found.
    """
    free, beam, last = balance.free, balance.beam, np.inf
    q, forces, closed = start.copy(), np.zeros(balance.count), np.zeros(balance.count, dtype=bool)
    below = closed.copy()  # the line of a side, beyond its end
    for step in range(_MOST_STEPS):
        here = _look(balance, q, forces, closed, below, hold, step == 0)
        bend = beam.rest_stiffness(q)
        linear = balance.linearize(q, here.elastic, np.where(here.elastic, here.pressing, forces))
        tangent = bend + linear.stiffness
        found = _by_newton(balance, here, tangent[free, free], linear.springs[:, free])
        if found is not None:
            move, forces = found
            size = balance.size(move)
            q[free] += move
            if size <= _ROUNDING or (size <= _SETTLED and size > 0.5 * last):
                held = np.where(here.elastic, here.pressing, forces)
                on = held > 0.0
                return Rest(q, held, here.gaps, here.slips, here.rigid & on, here.elastic & on, tangent)
            last = size
            continue
        move, forces = _descend(balance, here, bend)
        size = balance.size(move)
        before, closed = closed, (forces > 0.0) & balance.elastic & ~here.fixed
        if size <= _ROUNDING:  # stops that hold a straight beam from both sides close without a step
            if np.array_equal(before, closed):
                raise _unheld(balance)
            continue
        last = min(size, _LONGEST)
        q[free] += move * last / size
    words = "no equilibrium is found from initial.angle: nothing holds the beam"
    raise refused("initial.state", beam.scenario.initial.state, words)


def _look(
    balance: Balance, q: Array, forces: Array, closed: Mask, below: Mask, hold: Hold | None, first: bool
) -> _Here:
    """Return a state of the search; takes note of contacts that have come `below` a side beyond its end.

    What the undeformed beam is inside of at `first` bends it away.  A hold has its force in `forces`.
    """
    n, length = balance.count, balance.beam.scenario.beam.length
    point = balance.at(q, np.zeros_like(q), closed)
    gaps, rows, load = point.gaps.copy(), point.rows[:, 0, balance.free], point.load[balance.free]
    is_hold = np.arange(n) == (n - 1 if hold else n)
    fixed = is_hold & (hold is not None and hold.gap is not None)
    if hold is not None and hold.gap is None:
        forces[-1] = hold.force
        load = load + hold.force * rows[-1]
    elif hold is not None:
        gaps[-1] -= hold.gap
    beyond = balance.are_beyond(point.slips)
    below[:] = (below | (beyond & (not first))) & (gaps < 0.0)
    possible = ~is_hold & ~beyond & ~below & balance.enabled & (gaps < _NEAR * length)
    near = np.flatnonzero(possible | fixed)
    rigid = fixed | (possible & (forces > 0.0) & (not balance.elastic))
    W = balance.compliances(near, fixed[near])
    return _Here(load, rows, gaps, point.slips, point.pressing, fixed, rigid, closed.copy(), near, W)


def _by_newton(balance: Balance, here: _Here, tangent: Array, springs: Array) -> tuple[Array, Array] | None:
    """Return Newton's step (f,) and the contact forces (n,) behind it.

    None of one that is too long or not stable, or where contacts would open or close.
    """
    load, rigid, near = here.load + here.pressing @ here.rows, here.rigid, here.near
    found = _solved(tangent, load, here.rows[rigid], -here.gaps[rigid])
    if found is None:
        return None
    move, forces = found[0], np.zeros(balance.count)
    forces[rigid] = found[1]
    forces[here.elastic] = here.pressing[here.elastic] - springs @ move
    ahead = here.gaps[near] + here.rows[near] @ move + here.W @ forces[near]
    on = rigid | here.elastic
    opens = np.any(forces[on & ~here.fixed] < -balance.decision.tolerances.force)
    closes = np.any(ahead[~on[near]] < -_ROUNDED * balance.beam.scenario.beam.length)
    if opens or closes or balance.size(move) > _LONGEST:
        return None
    return move, np.where(here.fixed, forces, np.maximum(forces, 0.0))


def _unheld(balance: Balance) -> InputError:
    """Return the error of a beam that nothing holds."""
    words = "there is no equilibrium that is stable: nothing holds the beam where it is"
    return refused("initial.state", balance.beam.scenario.initial.state, words)


def _solved(tangent: Array, load: Array, rows: Array, wanted: Array) -> tuple[Array, Array] | None:
    """Return the step (d,) with rows.step = wanted, and the forces on these; None of one that is not stable."""
    count = len(rows)
    if np.linalg.matrix_rank(rows) < count:
        return None
    base = null_space(rows) if count else np.eye(load.size)
    try:
        cholesky(base.T @ tangent @ base)
    except LinAlgError:
        return None
    # of one size: the multipliers are forces in units of the largest stiffness
    scale = float(np.max(np.abs(tangent)))
    matrix = np.block([[tangent, -scale * rows.T], [scale * rows, np.zeros((count, count))]])
    try:
        found = np.linalg.solve(matrix, np.concatenate([load, scale * wanted]))
    except np.linalg.LinAlgError:
        return None
    return found[: load.size], scale * found[load.size :]


def _descend(balance: Balance, here: _Here, bend: Array) -> tuple[Array, Array]:
    """Return the step (f,) to the least of a quadratic energy under all gaps, and the contact forces (n,).

    rows.step + W s >= -gaps, with both signs of a gap that is held.  Raises InputError if no step does.
    """
    from scipy.optimize import nnls  # a quarter of a second, for which other runs do not wait

    factor, rows, both = _positive(balance, bend), here.rows[here.near], here.fixed[here.near]
    down, forces = cho_solve((factor, True), here.load), np.zeros(balance.count)
    if not here.near.size:
        return down, forces
    signs = np.concatenate([np.ones(len(rows)), -np.ones(int(both.sum()))])
    which = np.concatenate([np.arange(len(rows)), np.flatnonzero(both)])
    bent = solve_triangular(factor, (signs[:, None] * rows[which]).T, lower=True)
    values, vectors = np.linalg.eigh(0.5 * (here.W + here.W.T))
    soft = (np.sqrt(np.maximum(values, 0.0))[:, None] * vectors.T)[:, which] * signs
    constraints, least = np.concatenate([bent, soft]), -signs * (here.gaps[here.near] + rows @ down)[which]
    lengths = np.linalg.norm(constraints, axis=0)
    lengths[lengths == 0.0] = 1.0
    constraints, least = constraints / lengths, least / lengths
    scale = max(float(np.max(np.abs(least))), np.finfo(float).tiny)
    matrix = np.concatenate([constraints, least[None] / scale])
    target = np.append(np.zeros(len(constraints)), 1.0)
    found, _ = nnls(matrix, target)
    left = matrix @ found - target
    if not left[-1] < -_ROUNDED:
        words = "there is no equilibrium: the obstacles leave the beam no room"
        raise refused("initial.state", balance.beam.scenario.initial.state, words)
    np.add.at(forces, here.near[which], -found / left[-1] * scale / lengths * signs)
    return down + cho_solve((factor, True), here.rows.T @ forces), forces


def _positive(balance: Balance, bend: Array) -> Array:
    """Return the Cholesky factor of the tangent, stiffened until it is positive definite.

    By springs: one on the frame, of the size of the weight's moment, and those of the beam's own bending.
    """
    free, more = balance.free, balance.held_stiffness(bend)
    for times in (0.0, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0):
        try:
            return np.asarray(cholesky((bend + times * more)[free, free], lower=True))
        except LinAlgError:
            continue
    raise _unheld(balance)


# --- starts


def start_at_rest(beam: Beam, parts: Parts = Parts()) -> tuple[Array, Array, dict[int, Earlier]]:
    """Return coordinates and velocities (d,) at t = 0 as `initial.state` says, and the contacts that are closed.

    Raises InputError if there is no equilibrium.
    """
    found = state_at_rest(beam, parts)
    still = beam.initial_state()[1] * 0.0
    return found.q, still, earlier_of(found, beam.scenario, parts.scheme or scheme_of(beam.scenario))


def earlier_of(found: Rest, scenario: Scenario, scheme: Scheme) -> dict[int, Earlier]:
    """Return the contacts of a beam at rest that go on at t = 0, as a scheme takes them."""
    sticks, goes_on = scenario.contact.friction == "hybrid", scenario.initial.state != "plucked"
    # as a beam is let go contacts may slip, and rigid ones open: accelerations decide, or the first step
    criterion = scheme.stick_criterion
    follows = scheme.decides or (criterion is not None and criterion.located)
    return {
        i: Earlier(STICKING if sticks else SLIDING, float(found.forces[i]), 0.0, float(found.slips[i]))
        for i in found.closed
        if goes_on or (follows and found.elastic[i])
    }


def state_at_rest(beam: Beam, parts: Parts = Parts()) -> Rest:
    """Return the equilibrium of a beam or, if it is plucked, that in which it is held before t = 0."""
    s = beam.scenario
    free = rest(Balance(beam, parts), beam.initial_state()[0])
    if s.initial.state != "plucked":
        return free
    held = beam_of(s, parts)
    place, angle = s.initial.place, _axis_angle(beam, free.q, s.initial.place)
    # a side through the root along the axis at the place, from whose gap the deflection counts
    held.candidates = [*beam.candidates, ContactPlace(-1, True, (place, angle, 0.0, 0.0, 0.0, 0.0), (), 1.0)]
    balance = Balance(held, parts)
    gap = balance.at(free.q, np.zeros_like(free.q), np.zeros(balance.count, dtype=bool)).gaps[-1]
    hold = Hold(gap + s.initial.deflection) if s.initial.deflection else Hold(force=s.initial.force)
    found = rest(balance, free.q, hold)
    own = slice(0, len(beam.candidates))
    return found._replace(
        forces=found.forces[own],
        gaps=found.gaps[own],
        slips=found.slips[own],
        rigid=found.rigid[own],
        elastic=found.elastic[own],
    )


def _axis_angle(beam: Beam, q: Array, place: float) -> float:
    """Return the angle (rad) of the beam's axis at a place (m) in coordinates (d,)."""
    along = beam.operators.along
    if along is None:
        raise InputError("discretization: a plucked beam needs shape functions anywhere, BeamOperators.along")
    theta, B = (part := beam.split(q))[0], part[1:]
    slope = float(along.derivative(np.array([place]), 1)[0] @ B)
    return float(theta + np.angle(direction_of(np.array(slope), beam.foreshortening)))
