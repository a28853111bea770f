"""Elastic obstacles: where the beam touches them, and the forces of their springs and of Coulomb's friction.

In a plane a point of one body touches a side of the other:

a node of the beam, or a place in its section, on a straight side whose free side is on its left, or
a point c fixed in space, a peg or a corner, at the place x of the beam whose section looks at it

Points are complex numbers here, x + i y (m), and so are vectors.  In absolute coordinates gap and slip are
components of a difference of places: nothing of the beam's shape enters.

For a point on the beam, with the tangent t = exp(i phi) of the section and its normal n = i t,

    t . (r(x) - c) = 0,     gap = s n . (r(x) - c) - distance

which is continuous where elements meet; the tangent of the axis is not.  s = 1 where the point is on the right of
the beam, else -1.  With r' = exp(i phi) (1 + epsilon + i gamma) and the height h = n . (r - c)

    dgap = s [n . dr - gamma/F (t . dr + h dphi)],     F = 1 + epsilon + h phi'

where dr and dphi are those at a fixed x: the force is normal to the axis and its line passes through c.

The spring is k(s) at the slip s, which changes where the beam slides over the end of a bedding.  With means of
both ends of a step its force k d at the mean depth d, and Dk/Ds d^2/2 against the slide, do work that is the
change of the energy k d^2/2 exactly (a discrete gradient).
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from oblique_impact.contact.elastic import share_of
from oblique_impact.contact.state import STICKING, Candidate
from oblique_impact.fem_beam.exact.step_forces import NODE, BeamData, divided_difference
from oblique_impact.kernels.jit import inlined, jitable
from oblique_impact.kernels.workspace import Array, record_of

#: of half an element, the last step of the iterations for a place: a few units of rounding
_PLACED = 2e-15
#: most of these iterations: halvings from the whole element to rounding, and as many steps between
_MOST_STEPS = 120
#: of the length, a slide over which a difference of stiffnesses is mostly rounding
_HARDLY_SLID = 1e-9
#: of the length or 1 rad, a move in a step whose cube, what a discrete gradient corrects, is less than rounding
_HARDLY_MOVED = 1e-6

#: where the beam can touch an obstacle
TOUCHING = np.dtype(
    [
        ("on_side", np.int64),  # a node of the beam on a side; else a point on the beam
        # of a node on a side
        ("node", np.int64),
        ("outer", np.int64),  # of the ends of the side, the one that the beam points to
        ("cosine", float),  # of the angle of the side
        ("sine", float),
        ("height", float),  # m, of the side above the root's axis
        ("along", float),  # m, place of its origin along it
        ("fibre", float),  # e (m), place of the point in the section, across the beam
        # of a point on the beam
        ("x", float),  # c, m
        ("y", float),
        ("radius", float),  # m, of a peg
        ("half_depth", float),  # m, the lever of friction on the beam's face
        ("side", float),  # s
        # of both: the place that takes over at an end of a side, -1: none
        ("heir", np.int64),
    ],
    align=True,
)


def node_on_side(
    node: int, angle: float, height: float = 0.0, along: float = 0.0, fibre: float = 0.0, outer: int = 1
) -> Any:
    """Return the record of a node on a side at an angle (rad)."""
    found = {"height": height, "along": along, "fibre": fibre, "cosine": np.cos(angle), "sine": np.sin(angle)}
    return record_of(TOUCHING, found | {"on_side": 1, "node": node, "outer": outer, "heir": -1})


def point_on_beam(x: float, y: float, radius: float = 0.0, half_depth: float = 0.0, side: float = 1.0) -> Any:
    """Return the record of a point (m) on the beam."""
    found = {"x": x, "y": y, "radius": radius, "half_depth": half_depth, "side": side}
    return record_of(TOUCHING, found | {"heir": -1})


class Place(NamedTuple):
    """A contact at an instant."""

    gap: float  # m
    slip: float  # m, along the side from its origin; of a point on the beam minus its place
    gap_rate: float  # m/s
    slip_rate: float  # m/s, of the material
    x: float  # m along the beam
    normal: complex  # direction of a normal force on the beam
    tangent: complex
    point: complex  # m, where the beam touches


class Ends(NamedTuple):
    """Gaps and slips (m) of a contact at both ends of a step."""

    gap0: float
    gap1: float
    slip0: float
    slip1: float


@jitable
def place_of(beam: BeamData, touching: Any, q: Array, v: Array) -> Place:
    """Return the contact at a state; the slip rate is that of the material."""
    if touching.on_side:
        k, tangent = NODE * touching.node, complex(touching.cosine, touching.sine)
        lever = touching.fibre * complex(-np.sin(q[k + 2]), np.cos(q[k + 2]))
        point = complex(q[k], q[k + 1]) + lever
        moved = tangent.conjugate() * point
        rate = tangent.conjugate() * (complex(v[k], v[k + 1]) + 1j * v[k + 2] * lever)
        gap, slip = moved.imag - touching.height, moved.real - touching.along
        return Place(gap, slip, rate.imag, rate.real, beam.x[touching.node], 1j * tangent, tangent, point)
    at = _find(beam, touching, q)
    gap, across, gap_rate, slip_rate = _gap(touching, at), _across(touching, at), 0.0, 0.0
    for a in range(3):
        normal, tangential, turning = _local(touching, at, a)
        j = NODE * (at.first + a)
        gap_rate += normal.real * v[j] + normal.imag * v[j + 1] + turning[0] * v[j + 2]
        slip_rate += tangential.real * v[j] + tangential.imag * v[j + 1] + turning[1] * v[j + 2]
    point = complex(touching.x, touching.y) + (gap + touching.radius) * across
    return Place(gap, -at.x, gap_rate, slip_rate, at.x, across, at.turn, point)


@jitable
def take_rows(beam: BeamData, touching: Any, q0: Array, q1: Array, normal: Array, tangential: Array) -> Ends:
    """Put a contact over a step from q0 to q1 into rows (3 n,), and return gaps and slips at both ends.

    Rows times q1 - q0 are the change of the gap and the displacement of the material along the tangent (m).  Of a
    place in the section the row has a divided difference; of a point on the beam it is the gradient of the gap at
    the middle of the step, corrected along the step: Gonzalez's discrete gradient (2000).
    """
    normal[:], tangential[:] = 0.0, 0.0
    if touching.on_side:
        k, tangent = NODE * touching.node, complex(touching.cosine, touching.sine)
        turn0, turn1 = complex(np.cos(q0[k + 2]), np.sin(q0[k + 2])), complex(np.cos(q1[k + 2]), np.sin(q1[k + 2]))
        quotient, _ = divided_difference(turn0, turn1, q1[k + 2] - q0[k + 2])
        turning = 1j * touching.fibre * tangent.conjugate() * quotient
        normal[k], normal[k + 1], normal[k + 2] = -tangent.imag, tangent.real, turning.imag
        tangential[k], tangential[k + 1], tangential[k + 2] = tangent.real, tangent.imag, turning.real
        start = tangent.conjugate() * (complex(q0[k], q0[k + 1]) + 1j * touching.fibre * turn0)
        end = tangent.conjugate() * (complex(q1[k], q1[k + 1]) + 1j * touching.fibre * turn1)
        h, a = touching.height, touching.along
        return Ends(start.imag - h, end.imag - h, start.real - a, end.real - a)
    begun, ended = _find(beam, touching, q0), _find(beam, touching, q1)
    for j in range(q0.shape[0]):  # the row is about to be filled: until then the middle of the step
        tangential[j] = 0.5 * (q0[j] + q1[j])
    at = _find(beam, touching, tangential)
    _take_gradients(touching, at, normal, tangential)
    gap0, gap1 = _gap(touching, begun), _gap(touching, ended)
    # on all nodes whose elements the place has been in
    first = NODE * min(begun.first, ended.first, at.first)
    end = NODE * (max(begun.first, ended.first, at.first) + 3)
    left, square, length = gap1 - gap0, 0.0, beam.x[-1]
    for j in range(first, end):
        change, scale = q1[j] - q0[j], length if j % NODE < 2 else 1.0
        left -= normal[j] * change
        square += (change / scale) ** 2
    if square > _HARDLY_MOVED**2:
        for j in range(first, end):
            scale = length if j % NODE < 2 else 1.0
            normal[j] += left / square * (q1[j] - q0[j]) / scale**2
    return Ends(gap0, gap1, -begun.x, -ended.x)


@jitable
def rows_at(beam: BeamData, touching: Any, q: Array, normal: Array, tangential: Array) -> None:
    """Put a contact at an instant into rows (3 n,): its rates over those of q."""
    if touching.on_side:
        take_rows(beam, touching, q, q, normal, tangential)
    else:
        _take_gradients(touching, _find(beam, touching, q), normal, tangential)


# --- a point on the beam


class _Found(NamedTuple):
    """The place of the beam whose section looks at a point."""

    first: int  # node of its element
    z: float  # from -1 to 1 in the element
    x: float  # m along the beam
    past: float  # m, how far x is past an end, from which the beam goes on straight and without strain
    turn: complex  # exp(i phi)
    strain: complex  # exp(-i phi) r', 1 without strain
    curvature: float  # 1/m
    height: float  # m, of the place above the point, to the left of the tangent


@inlined
def _gap(touching: Any, at: _Found) -> float:
    return float(touching.side * at.height - touching.radius - touching.half_depth)


@inlined
def _slant(at: _Found) -> float:
    """gamma/F."""
    return at.strain.imag / (at.strain.real + at.height * at.curvature)


@inlined
def _across(touching: Any, at: _Found) -> complex:
    """Vector that the gap grows along."""
    return complex(touching.side * at.turn * (1j - _slant(at)))


@inlined
def _local(touching: Any, at: _Found, a: int) -> tuple[complex, complex, tuple[float, float]]:
    """Return derivatives of gap and material's place along t by x and y of a node of the element, and by phi."""
    z = at.z
    shape = 0.5 * z * (z - 1.0) if a == 0 else 1.0 - z * z if a == 1 else 0.5 * z * (z + 1.0)
    turning = shape * touching.side * (at.past - _slant(at) * at.height)
    lever = shape * touching.side * touching.half_depth
    return shape * _across(touching, at), shape * at.turn, (turning, lever)


@inlined
def _from_point(touching: Any, q: Array, node: int) -> complex:
    """Place (m) of a node, seen from the point."""
    return complex(q[NODE * node] - touching.x, q[NODE * node + 1] - touching.y)


@inlined
def _ahead(r: complex, phi: float) -> float:
    """Return t . r, how far (m) a place is ahead of the point."""
    return float(np.cos(phi) * r.real + np.sin(phi) * r.imag)


@jitable
def _take_gradients(touching: Any, at: _Found, normal: Array, tangential: Array) -> None:
    """Put the gradients of gap and material's place along the tangent into rows (3 n,)."""
    normal[:], tangential[:] = 0.0, 0.0
    for a in range(3):
        across, along, turning = _local(touching, at, a)
        j = NODE * (at.first + a)
        normal[j], normal[j + 1], normal[j + 2] = across.real, across.imag, turning[0]
        tangential[j], tangential[j + 1], tangential[j + 2] = along.real, along.imag, turning[1]


@jitable
def _find(beam: BeamData, touching: Any, q: Array) -> _Found:
    """Return the place where t . (r - c) rises through zero, the nearest to the point if there are more."""
    last, k, nearest, part = beam.x.shape[0] - 1, -1, 0.0, 0.0
    r = _from_point(touching, q, 0)
    before = _ahead(r, q[2])
    for node in range(last):
        there = _from_point(touching, q, node + 1)
        after = _ahead(there, q[NODE * (node + 1) + 2])
        away = r.real * r.real + r.imag * r.imag
        if before <= 0.0 < after and (k < 0 or away < nearest):
            k, nearest, part = node, away, before / (before - after)
        r, before = there, after
    if k < 0:
        return _find_past(beam, touching, q, last if before <= 0.0 else 0)
    first = k - k % 2
    a, b, c = (
        _from_point(touching, q, first),
        _from_point(touching, q, first + 1),
        _from_point(touching, q, first + 2),
    )
    p, o, u = q[NODE * first + 2], q[NODE * first + 5], q[NODE * first + 8]
    # z goes from -1 to 1 in the element; quadratic in it, r = b + z (r1 + z r2)
    r1, r2, p1, p2 = 0.5 * (c - a), 0.5 * (a + c) - b, 0.5 * (u - p), 0.5 * (p + u) - o
    low = -1.0 if k == first else 0.0
    z, high, shift, placed = low + part, low + 1.0, 2.0, False
    turn, across, tangent, bent = 1.0 + 0.0j, b, r1, p1
    for _ in range(_MOST_STEPS):
        phi = o + z * (p1 + z * p2)
        turn = complex(np.cos(phi), np.sin(phi))
        across, tangent = (b + z * (r1 + z * r2)) * turn.conjugate(), (r1 + 2.0 * z * r2) * turn.conjugate()
        bent = p1 + 2.0 * z * p2
        if across.real > 0.0:
            high = z
        else:
            low = z
        if placed:
            break
        growth = tangent.real + across.imag * bent
        step = -across.real / growth if growth > 0.0 else np.inf
        # where a step has not halved the last one, or leads out of the part that holds the place, this is halved:
        # so one of both is rounding in the end, mostly after four steps
        if not (abs(step) <= 0.5 * shift and low <= z + step <= high):
            step = 0.5 * (low + high) - z
        z, shift, placed = z + step, abs(step), abs(step) <= _PLACED
    half = 0.5 * (beam.x[first + 2] - beam.x[first])
    return _Found(first, z, beam.x[first + 1] + z * half, 0.0, turn, tangent / half, bent / half, across.imag)


@inlined
def _find_past(beam: BeamData, touching: Any, q: Array, node: int) -> _Found:
    """Return the place past an end of the beam."""
    r, phi = _from_point(touching, q, node), q[NODE * node + 2]
    turn, past = complex(np.cos(phi), np.sin(phi)), -_ahead(r, phi)
    first, z = (node - 2, 1.0) if node > 0 else (0, -1.0)
    return _Found(first, z, beam.x[node] + past, past, turn, 1.0 + 0.0j, 0.0, (turn.conjugate() * r).imag)


# --- forces


@inlined
def _over(c: Candidate, slip: float) -> tuple[float, float]:
    """Stiffness (N/m) of a stop at a place (m along the side), and its derivative by the place (N/m^2)."""
    share, fading = share_of(slip, c.first, c.last, c.cell)
    return c.stiffness * share, c.stiffness * fading


@inlined
def friction_at(c: Candidate, slip_rate: float) -> float:
    """lambda_tau/lambda_n at a slip velocity (m/s); 0 of a contact that sticks."""
    return 0.0 if c.state == STICKING else c.intercept + c.slope * slip_rate


@jitable
def force_at(c: Candidate, gap: float, slip: float, gap_rate: float) -> float:
    """Return the normal force (N) at an instant, of the spring and its damping, never pulling."""
    # at a release, the gap is zero but for rounding
    stiffness, _ = _over(c, slip)
    elastic = stiffness * max(0.0, -gap) * max(0.0, 1.0 - c.damping * gap_rate)
    return max(0.0, elastic - c.linear_damping * gap_rate)


@jitable
def mean_force(c: Candidate, ends: Ends, length: float) -> tuple[float, float, float]:
    """Mean normal force (N) of a step of a length (s), its derivative by the last gap (N/m), and its damping (N).

    The rest of it is the spring's, whose work is the change of its energy.
    """
    k = 0.5 * (_over(c, ends.slip0)[0] + _over(c, ends.slip1)[0])
    depth, rate = -0.5 * (ends.gap0 + ends.gap1), (ends.gap0 - ends.gap1) / length
    factor, slope = 1.0 + c.damping * rate, -c.damping / length
    if factor <= 0.0:
        factor, slope = 0.0, 0.0
    elastic = k * depth
    damped = elastic * (factor - 1.0) + c.linear_damping * rate
    if elastic + damped <= 0.0:
        return 0.0, 0.0, -elastic
    return elastic + damped, -0.5 * k * factor + elastic * slope - c.linear_damping / length, damped


@jitable
def end_push(c: Candidate, ends: Ends, length: float) -> float:
    """Mean force (N) of a step along the slide, of a bedding under a place that lies over an end of it.

    `length` (m) is that of the beam.
    """
    (k0, slope0), (k1, slope1) = _over(c, ends.slip0), _over(c, ends.slip1)
    slope, slid = 0.5 * (slope0 + slope1), ends.slip1 - ends.slip0
    if slope0 != slope1 and abs(slid) > _HARDLY_SLID * length:
        slope = (k1 - k0) / slid
    return -0.25 * slope * (ends.gap0**2 + ends.gap1**2)
