"""What an obstacle makes of a point of a body: gap, slip and directions, and from these rates, biases and rows.

A body says where its point is, r, in axes that are turned by the angle theta and stand still at the instant: its
velocity v = J q' and its acceleration J q'' + b are those against the inertial frame.  With the unit vectors n out
of the obstacle and t along it

    Z_n' = n.v,    Z_tau' = t.v,    D_n = n.J,    D_tau = t.J

A side is solid on one side of a line, which stands still: z_n = n.b, z_tau = t.b.  A peg, or a corner, is a point
fixed in space, which meets the body's axis at a place that moves along it.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from oblique_impact.contact.state import Candidate
from oblique_impact.kernels.jit import inlined
from oblique_impact.kernels.workspace import ACROSS, ACROSS_TURNED, ALONG, ALONG_TURNED, Array


class PointMotion(NamedTuple):
    """A point of a body and its motion, x along the body and y across it."""

    x: float  # m
    y: float
    x_rate: float  # m/s, of v
    y_rate: float
    x_bias: float  # m/s^2, of b
    y_bias: float


class AxisMotion(NamedTuple):
    """Derivatives along the axis of a body at a place on it: of r, v and b; 1/m of their units for each."""

    x1: float  # r'
    y1: float
    x2: float  # r''
    y2: float
    x1_rate: float  # v'
    y1_rate: float
    x2_rate: float  # v''
    y2_rate: float
    x1_bias: float  # b'
    y1_bias: float


class Directions(NamedTuple):
    """Normal n and tangent t of a contact in the axes of the body, and the lever of its friction."""

    normal_x: float
    normal_y: float
    tangent_x: float
    tangent_y: float
    lever: float  # of n.J' in the tangential row (m); 0 of a side, whose point has the lever in its place
    # of the place of a peg along the body: -sliding t.J - turning n.J' is its row; 0 of a side
    sliding: float
    turning: float  # m


class Heading(NamedTuple):
    """Direction of the axes of a body."""

    cosine: float
    sine: float


@inlined
def heading_of(theta: float) -> Heading:
    """Return the direction of axes that are turned by the angle theta (rad)."""
    return Heading(np.cos(theta), np.sin(theta))


@inlined
def meet_side(side: Any, heading: Heading, p: PointMotion, c: Candidate) -> Directions:
    """Gap, slip, rates and biases of a point of a body against a side."""
    cosine = heading.cosine * side.cosine + heading.sine * side.sine
    sine = heading.sine * side.cosine - heading.cosine * side.sine
    c.gap, c.slip = (
        p.x * sine + p.y * cosine - side.normal_offset,
        p.x * cosine - p.y * sine - side.tangential_offset,
    )
    c.gap_rate, c.slip_rate = p.x_rate * sine + p.y_rate * cosine, p.x_rate * cosine - p.y_rate * sine
    c.gap_bias, c.slip_bias = p.x_bias * sine + p.y_bias * cosine, p.x_bias * cosine - p.y_bias * sine
    return Directions(sine, cosine, cosine, -sine, 0.0, 0.0, 0.0)


@inlined
def centre_of(peg: Any, heading: Heading) -> tuple[float, float]:
    """Centre (m) of a peg in the axes of a body."""
    cosine, sine = heading
    return peg.x * cosine + peg.y * sine, peg.y * cosine - peg.x * sine


@inlined
def meet_peg(
    peg: Any, centre: tuple[float, float], place: float, p: PointMotion, a: AxisMotion, c: Candidate
) -> Directions:
    """Gap, slip, rates and biases of a peg against the axis of a body, which it meets at a place (m) along it.

    The centre c meets the axis where (r - c).r' = 0.  With t = r'/|r'|, its normal n on the side of the body, the
    turning w of t towards n and the one u of the section,

        x'     = -(v.r' + (r - c).v') / (r'.r' + (r - c).r''),    w = (n.v' + x' n.r'')/|r'|,  u = n.v'/|r'|
        Z_n'   = n.v,           Z_n''   = n.(J q'' + b) + x' n.v' - w t.v
        Z_tau' = t.v + e u,     Z_tau'' = t.(J q'' + b) + x' t.v' + w n.v + e u'

    where primes of r and v are derivatives along the body and e is the lever of friction.  The slip is -x, whose
    rate is that of the axis where the point touches it.
    """
    stretch = np.sqrt(a.x1 * a.x1 + a.y1 * a.y1)  # |r'|, 1 but for the fourth power of the slope
    tx, ty = a.x1 / stretch, a.y1 / stretch
    nx, ny = -peg.side * ty, peg.side * tx
    away_x, away_y = p.x - centre[0], p.y - centre[1]
    growing = stretch * stretch + away_x * a.x2 + away_y * a.y2
    place_rate = -(p.x_rate * a.x1 + p.y_rate * a.y1 + away_x * a.x1_rate + away_y * a.y1_rate) / growing
    normal_rate, tangential_rate = nx * a.x1_rate + ny * a.y1_rate, tx * a.x1_rate + ty * a.y1_rate  # of r'
    turning = (normal_rate + place_rate * (nx * a.x2 + ny * a.y2)) / stretch
    away = nx * away_x + ny * away_y
    c.gap, c.slip, c.shift, c.shift_rate = away - peg.distance, -place, place, place_rate
    c.gap_rate, c.slip_rate = nx * p.x_rate + ny * p.y_rate, tx * p.x_rate + ty * p.y_rate
    c.gap_bias = nx * p.x_bias + ny * p.y_bias + place_rate * normal_rate - turning * c.slip_rate
    c.slip_bias = tx * p.x_bias + ty * p.y_bias + place_rate * tangential_rate + turning * c.gap_rate
    lever = peg.lever / stretch
    if lever != 0.0:
        of_normal = nx * (a.x1_bias + place_rate * a.x2_rate) + ny * (a.y1_bias + place_rate * a.y2_rate)
        growth = tangential_rate + place_rate * (tx * a.x2 + ty * a.y2)  # of |r'|
        c.slip_bias += lever * (of_normal - turning * tangential_rate - normal_rate * growth / stretch)
        c.slip_rate += lever * normal_rate
    return Directions(nx, ny, tx, ty, lever, stretch / growing, away / growing)


@inlined
def take_rows(d: Directions, v: Array, rows: Array) -> None:
    """Rows D_n and D_tau from those of the point and, with a lever, of r', in the rows of a workspace.

    The third of `rows` (2 or 3, d), if it is asked for, is that of the place of a peg along the body.
    """
    normal, tangential = rows[0], rows[1]
    if rows.shape[0] > 2 and d.sliding != 0.0:
        for j in range(normal.shape[0]):
            slid = d.tangent_x * v[ALONG, j] + d.tangent_y * v[ACROSS, j]
            turned = d.normal_x * v[ALONG_TURNED, j] + d.normal_y * v[ACROSS_TURNED, j]
            rows[2, j] = -(d.sliding * slid + d.turning * turned)
    for j in range(normal.shape[0]):
        along, across = v[ALONG, j], v[ACROSS, j]
        normal[j] = d.normal_x * along + d.normal_y * across
        tangential[j] = d.tangent_x * along + d.tangent_y * across
    if d.lever != 0.0:
        for j in range(normal.shape[0]):
            tangential[j] += d.lever * (d.normal_x * v[ALONG_TURNED, j] + d.normal_y * v[ACROSS_TURNED, j])
