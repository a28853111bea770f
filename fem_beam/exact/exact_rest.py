"""The exact beam at rest, in the rotations of its nodes and the strains at its Gauss points.

With the values phi of the nodes and Gamma = epsilon + i gamma at the Gauss points the places of the nodes are sums

    r_j = r_0 + sum over g of W_jg exp(i phi_g) (1 + Gamma_g)

so that the strain energy is quadratic in these coordinates z, and what is not linear is the potential of loads.
With generalized forces f of the nodes, R_g = sum of f_j W_jg, and dq/dz = J, forces and their derivatives are

    F = J^T f - K z,    dF/dz = J^T (df/dq) J + G(R) - K

where G has the second derivatives of the places.  Newton's method for the equilibrium goes far in them where it
would stretch a beam of absolute coordinates that turns (see :mod:`~oblique_impact.resting`).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag

from oblique_impact.beam.base_motion import base_motion_of
from oblique_impact.beam.beam import contact_places
from oblique_impact.beam.cross_sections import Sections
from oblique_impact.beam_problem import Parts, beam_tolerances, decision_about, scheme_of
from oblique_impact.contact.elastic import share_of
from oblique_impact.contact.state import Candidate
from oblique_impact.contact.transitions import Earlier
from oblique_impact.fem_beam.exact.exact_beam import Complex, ExactBeam
from oblique_impact.fem_beam.exact.exact_system import ExactModel, load_at, model_of
from oblique_impact.fem_beam.exact.point_loads import (
    COLUMNS,
    FIRST,
    add_point_forces,
    subtract_point_tangent,
    take_point_forces,
)
from oblique_impact.fem_beam.exact.step_forces import NODE, BeamData
from oblique_impact.fem_beam.exact.stop import place_of, take_rows
from oblique_impact.kernels.band_rows import BANDWIDTH, new_rows
from oblique_impact.kernels.jit import by_reference, kernel
from oblique_impact.kernels.workspace import Array
from oblique_impact.resting import Balance, ContactStiffness, Hold, Mask, Point, Rest, earlier_of, rest
from oblique_impact.scenario.scenario import Scenario

#: of the length or 1 rad, for differences of the rows of contacts
_DIFFERENCE = 1e-5
#: m/N, of a bed that is not there
_SOFT = 1e300


class TurnedBeam:
    """The exact beam of a scenario in rotations and strains: places, loads at t = 0, stiffness.

    The coordinates are those rotations of nodes that are not held, then extension and shear, point by point.
    """

    def __init__(self, scenario: Scenario, beam: ExactBeam, model: ExactModel) -> None:
        self.scenario, self.beam, self.model = scenario, beam, model
        root, n, points = scenario.root, beam.x.size, beam.points.size
        self.held = root.kind == "driven" and root.stiffness == 0.0
        #: whether the first node goes round with a hub
        self.goes_round = root.kind != "driven" and beam.radius > 0.0
        self.rotations = n - self.held
        self.size = self.rotations + 2 * points
        shapes = beam.data.shapes.reshape(points, 3)
        first = 2 * (np.arange(points) // 2)
        self._turns, self._bends = np.zeros((2, points, n))  # phi and phi' at Gauss points
        slopes = beam.data.slopes.reshape(points, 3)
        for k in range(3):
            self._turns[np.arange(points), first + k] = shapes[:, k]
            self._bends[np.arange(points), first + k] = slopes[:, k]
        self._sums = _sums_over(beam)
        stiffness = beam.data.sections.reshape(points, 4)
        axial, shear, bending = (stiffness[:, k] * stiffness[:, 3] for k in range(3))
        bent = (self._bends.T * bending) @ self._bends
        strained = np.diag(np.stack([axial, shear], axis=1).ravel())
        self.elastic: Array = block_diag(bent[self.held :, self.held :], strained)
        self._start = np.full(n, float(scenario.initial.angle))
        self.load, self.forces = np.zeros(beam.size), np.zeros((len(scenario.acting_forces), COLUMNS))
        load_at(model, 0.0, self.load)
        take_point_forces(model.forces, 0.0, self.forces)

    @property
    def start(self) -> Array:
        """Coordinates of the undeformed beam at the initial angle."""
        return np.append(self._start[self.held :], np.zeros(self.size - self.rotations))

    def turned(self, z: Array) -> tuple[Array, Complex, Complex]:
        """Return the rotations of the nodes, and exp(i phi) and r' at Gauss points."""
        phi = self._start.copy()
        phi[self.held :] = z[: self.rotations]
        turn = np.exp(1j * (self._turns @ phi))
        strain = z[self.rotations :: 2] + 1j * z[self.rotations + 1 :: 2]
        return phi, turn, turn * (1.0 + strain)

    def root_place(self, phi: Array) -> complex:
        """Return the place (m) of the first node."""
        return complex(self.beam.radius * np.exp(1j * (phi[0] if self.goes_round else self._start[0])))

    def nodes(self, z: Array) -> Array:
        """Return the nodal values (3 n,)."""
        phi, _, tangent = self.turned(z)
        r = self.root_place(phi) + self._sums @ tangent
        return np.stack([r.real, r.imag, phi], axis=1).ravel()

    def jacobian(self, z: Array) -> Array:
        """Return the derivatives (3 n, m) of the nodal values."""
        phi, turn, tangent = self.turned(z)
        n = phi.size
        places = np.zeros((n, n + 2 * turn.size), dtype=complex)
        places[:, :n] = self._sums @ ((1j * tangent)[:, None] * self._turns)
        if self.goes_round:
            places[:, 0] += 1j * self.root_place(phi)
        places[:, n::2], places[:, n + 1 :: 2] = self._sums * turn, self._sums * (1j * turn)
        found = np.zeros((NODE * n, n + 2 * turn.size))
        found[0::NODE], found[1::NODE] = places.real, places.imag
        found[2::NODE, :n] = np.eye(n)
        return found[:, self.held :]

    def loads(self, q: Array) -> Array:
        """Return the forces (3 n,) of weight, torque and base, those on the beam and of a spring at the root."""
        found = self.load.copy()
        add_point_forces(self.forces, q, q, found)
        found[2] -= self.scenario.root.stiffness * (q[2] - self._start[0])
        return found

    def following(self, q: Array) -> Array:
        """Return the derivatives (3 n, 3 n) of these forces, those of the spring at the root left out."""
        found = np.zeros((q.size, q.size))
        for force in self.forces:
            rows = new_rows(q.size)
            subtract_point_tangent(force[None], q, rows)
            first = NODE * int(force[FIRST])
            for i in range(first, first + 3 * NODE):
                for j in range(first, first + 3 * NODE):
                    if abs(j - i) <= BANDWIDTH:
                        found[i, j] -= 2.0 * rows[i, BANDWIDTH + j - i]  # by both ends of a step
        return found

    def bending_of(self, z: Array, forces: Array) -> Array:
        """Return the second derivatives (m, m) of the places against forces on the nodes (3 n,)."""
        phi, turn, tangent = self.turned(z)
        n, points = phi.size, turn.size
        pull = (forces[0::NODE] - 1j * forces[1::NODE]) @ self._sums
        found = np.zeros((n + 2 * points,) * 2)
        found[:n, :n] = (self._turns.T * (-pull * tangent).real) @ self._turns
        if self.goes_round:
            whole = np.sum(forces[0::NODE] - 1j * forces[1::NODE])
            found[0, 0] -= (whole * self.root_place(phi)).real
        for k, direction in enumerate((1j, -1.0)):
            column = ((pull * direction * turn).real[:, None] * self._turns).T
            found[:n, n + k :: 2], found[n + k :: 2, :n] = column, column.T
        return found[self.held :, self.held :]

    def rest_stiffness(self, z: Array) -> Array:
        """Return the tangent stiffness (m, m) at rest and t = 0, without contacts."""
        q, J = self.nodes(z), self.jacobian(z)
        found = self.elastic - self.bending_of(z, self.loads(q))
        if self.forces.size:
            found -= J.T @ self.following(q) @ J
        if not self.held:
            found[0, 0] += self.scenario.root.stiffness
        return found


def _sums_over(beam: ExactBeam) -> Array:
    """Return the matrix (n, points) from r' at Gauss points to the places of nodes, seen from the first."""
    found = np.zeros((beam.x.size, beam.points.size))
    for e, h in enumerate(np.diff(beam.ends)):
        # r' is linear in an element, a + b z from -1 to 1
        a, b = np.array([0.5, 0.5]), np.array([-0.5, 0.5]) * np.sqrt(3.0)
        order = np.argsort(beam.points[e])
        found[2 * e + 1 :, 2 * e + order] = 0.5 * h * (a - 0.5 * b)
        found[2 * e + 2 :, 2 * e + order] = h * a
    return found


@kernel("contacts of the exact beam at rest")
def _find_contacts(beam: BeamData, touchings: Any, q: Array, gaps: Array, slips: Array, rows: Array) -> None:
    """Put gaps and slips (n,) and their rows (n, 2, 3 n) into arrays."""
    beam = by_reference(beam)
    for i in range(gaps.shape[0]):
        at = place_of(beam, touchings[i], q, q)
        gaps[i], slips[i] = at.gap, at.slip
        take_rows(beam, touchings[i], q, q, rows[i, 0], rows[i, 1])


class ExactBalance(Balance):
    """The forces on the exact beam of a scenario in rotations and strains, and on its candidates of contact.

    Parameters
    ----------
    scenario : Scenario
        The scenario.
    beam : ExactBeam
        Its beam.
    parts : Parts
        User-defined parts of the run.
    hold : tuple of float, optional
        Place (m) and angle (rad) of the axis where a plucked beam is held: the last of all candidates.
    """

    def __init__(
        self,
        scenario: Scenario,
        beam: ExactBeam,
        parts: Parts = Parts(),
        hold: tuple[float, float] | None = None,
    ) -> None:
        s = scenario
        model = model_of(s, beam, parts.base_motion or base_motion_of(s.root))
        places, self._hold = contact_places(s), hold
        self.beam: Any = TurnedBeam(s, beam, model)
        tolerances = beam_tolerances(s, Sections.from_scenario(s).mass)
        self.decision = decision_about(places, s, scheme_of(s), tolerances, parts)
        self.elastic, self.count = self.decision.compliant, len(places) + (hold is not None)
        self.free, self.enabled = slice(0, self.beam.size), s.contact.enabled
        self._each = [self.decision.opened(i, self.decision.free(i)) for i in range(len(places))]
        self._slips = np.zeros(self.count)
        self._held_row, self._held_from = np.zeros(beam.size), 0.0
        if hold is not None:
            first, shapes = beam.row_at(hold[0])
            for a, share in enumerate(shapes):
                j = NODE * (first + a)
                self._held_row[j], self._held_row[j + 1] = -share * np.sin(hold[1]), share * np.cos(hold[1])

    def contacts_at(self, q: Array) -> tuple[Array, Array, Array]:
        """Return gaps and slips (n,) and rows (n, 2, 3 n) of nodal values (3 n,)."""
        own = len(self._each)
        gaps, slips, rows = np.zeros(self.count), np.zeros(self.count), np.zeros((self.count, 2, q.size))
        _find_contacts(self.beam.beam.data, self.beam.model.touchings, q, gaps[:own], slips[:own], rows[:own])
        if self._hold is not None:
            gaps[-1], rows[-1, 0] = self._held_row @ q, self._held_row
        return gaps, slips, rows

    def at(self, q: Array, qd: Array, closed: Mask) -> Point:
        """Return forces and contacts at rest at coordinates (d,), with these contacts closed (n,)."""
        nodes, J = self.beam.nodes(q), self.beam.jacobian(q)
        gaps, slips, rows = self.contacts_at(nodes)
        load, pressing = self.beam.loads(nodes), np.zeros(self.count)
        for i in np.flatnonzero(closed).tolist() if self.elastic else ():
            stiffness, fading = _over(self._each[i], float(slips[i]))
            depth = -float(gaps[i])  # also of one that is to close: its spring pulls the beam to it
            pressing[i] = stiffness * depth
            load = load - 0.5 * fading * depth**2 * rows[i, 1]
        self._slips = slips
        still = q.copy()
        still[: self.beam.rotations] = self._from_start(q)
        return Point(J.T @ load - self.beam.elastic @ still, gaps, slips, rows @ J, pressing)

    def _from_start(self, q: Array) -> Array:
        """Rotations from the straight beam: bending keeps its digits."""
        found: Array = q[: self.beam.rotations] - self.beam.scenario.initial.angle
        return found

    def are_beyond(self, slips: Array) -> Mask:
        """Return which contacts are beyond the ends of their sides at slips (n,) in m."""
        found = super().are_beyond(slips[: len(self._each)])
        return np.append(found, False) if self._hold is not None else found

    def compliances(self, near: NDArray[np.intp], fixed: Mask, forces: Array | None = None) -> Array:
        """Return W (m, m) in m/N in the state of the last `at`, 0 of contacts that are `fixed`."""
        found = np.zeros((near.size, near.size))
        for k, i in enumerate(near.tolist() if self.elastic else ()):
            if not fixed[k]:
                stiffness, _ = _over(self._each[i], float(self._slips[i]))
                found[k, k] = 1.0 / stiffness if stiffness > 0.0 else _SOFT
        return found

    def size(self, move: Array) -> float:
        """Return the size of a change of the coordinates: rotation (rad), or strain."""
        return float(np.max(np.abs(move)))

    def held_stiffness(self, bend: Array) -> Array:
        """Return the stiffness (d, d) of the beam on a spring (N m/rad) at its root, of the size of its loads."""
        sections, s = Sections.from_scenario(self.beam.scenario), self.beam.scenario
        moment = s.largest_gravity * sections.static_moment + abs(s.root.torque)
        found: Array = self.beam.elastic.copy()
        if not self.beam.held:
            found[0, 0] += moment or float(np.max(np.abs(bend)))
        return found

    def linearize(self, q: Array, elastic: Mask, forces: Array) -> ContactStiffness:
        """Return how contacts change with the coordinates (d,), at fixed forces (n,) in N."""
        nodes, J = self.beam.nodes(q), self.beam.jacobian(q)
        closed = np.flatnonzero(elastic)
        _, slips, rows = self.contacts_at(nodes)
        bent, sprung = np.zeros((nodes.size, nodes.size)), rows[:, 0].copy()
        loaded = forces * (np.arange(self.count) < len(self._each))
        # columns on which a row may depend: those of the element
        columns = np.flatnonzero(np.any(rows[loaded != 0.0], axis=(0, 1)))
        for j in columns.tolist():
            move = _DIFFERENCE * self.beam.beam.scale[j] * np.eye(1, nodes.size, j)[0]
            (push0, gaps0), (push1, gaps1) = (
                self._pushed(nodes + side * move, elastic, loaded) for side in (-1, 1)
            )
            bent[:, j] = (push0 - push1) / (2.0 * move[j])
            sprung[:, j] = np.where(loaded != 0.0, (gaps1 - gaps0) / (2.0 * move[j]), sprung[:, j])
        push, _ = self._pushed(nodes, elastic, forces)
        self._slips = slips
        soft = np.diag(self.compliances(closed, np.zeros(closed.size, dtype=bool)))
        springs = (sprung[closed] @ J) / soft[:, None]
        stiffness = J.T @ bent @ J - self.beam.bending_of(q, push) + (sprung[closed] @ J).T @ springs
        return ContactStiffness(0.5 * (stiffness + stiffness.T), springs)

    def _pushed(self, nodes: Array, elastic: Mask, forces: Array) -> tuple[Array, Array]:
        """Return the generalized force (3 n,) of contacts with given forces (n,), and their gaps with W s (n,)."""
        gaps, slips, rows = self.contacts_at(nodes)
        push = forces @ rows[:, 0]
        for i in np.flatnonzero(elastic).tolist():
            stiffness, fading = _over(self._each[i], float(slips[i]))
            compressed = forces[i] / stiffness if stiffness > 0.0 else 0.0
            gaps[i] += compressed
            push -= 0.5 * fading * compressed**2 * rows[i, 1]
        return push, gaps


def _over(c: Candidate, slip: float) -> tuple[float, float]:
    """Stiffness (N/m) of a stop at a place (m along the side), and its derivative by the place (N/m^2)."""
    share, fading = share_of(slip, c.first, c.last, c.cell)
    return c.stiffness * share, c.stiffness * fading


def find_rest(scenario: Scenario, beam: ExactBeam, parts: Parts = Parts()) -> tuple[ExactBalance, Rest]:
    """Return the equilibrium of a beam or, if it is plucked, that in which it is held, with the forces on it.

    Raises InputError if there is none.
    """
    balance, initial = ExactBalance(scenario, beam, parts), scenario.initial
    found = rest(balance, balance.beam.start)
    if initial.state != "plucked":
        return balance, found
    first, shapes = beam.row_at(initial.place)
    phi = balance.beam.nodes(found.q)[2::NODE][first : first + 3]
    held = ExactBalance(scenario, beam, parts, (initial.place, float(shapes @ phi)))
    gap = float(held.contacts_at(balance.beam.nodes(found.q))[0][-1])
    hold = Hold(gap + initial.deflection) if initial.deflection else Hold(force=initial.force)
    bent = rest(held, found.q, hold)
    own = slice(0, balance.count)
    names = "forces", "gaps", "slips", "rigid", "elastic"
    return balance, bent._replace(**{name: getattr(bent, name)[own] for name in names})


def start_of(scenario: Scenario, beam: ExactBeam, scheme: Any, parts: Parts) -> tuple[Array, dict[int, Earlier]]:
    """Return nodal values (3 n,) at t = 0 as `initial.state` says, and the contacts that are closed."""
    balance, found = find_rest(scenario, beam, parts)
    return balance.beam.nodes(found.q), earlier_of(found, scenario, scheme)
