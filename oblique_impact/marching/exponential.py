"""An exponential integrator for free flight: long steps between impacts, whose fast vibrations are linear.

In the normal modes z of the beam at rest, q = Phi z, the motion is

    z_k'' + c_k z_k' + omega_k^2 z_k = f_k(t, z, z')

where all that is not linear with constant coefficients is in f: the spin, gravity, what they do to the stiffness.
It is small and changes slowly, so that a polynomial through s Gauss-Lobatto points of a step follows it, and

    z_k(t + tau) = free vibration from t + int_0^tau g_k(tau - s) f_k(s) ds,   g_k the response to an impulse

holds at these points with weights that depend on omega_k h alone: they are computed once, for steps h that are
the output interval times powers of two (levels).  One to three sweeps through the points find f (Picard
iteration).  This is the collocation form of an exponential integrator (Hochbruck and Ostermann, Acta Numerica
2010, Sec. 2).  The step may be longer than the period of the fastest mode that is excited, and is as long as the
highest Legendre coefficients of f allow.  With two modes it gains nothing; with many it takes a fifth of the time.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial import Legendre

from oblique_impact.contact.forces import OK, is_free, nearest
from oblique_impact.kernels.dense import multiply
from oblique_impact.kernels.jit import jitable
from oblique_impact.kernels.system import NormalModes
from oblique_impact.kernels.workspace import Array, copy
from oblique_impact.marching.advance import Position, Step, refused
from oblique_impact.marching.buffers import KEPT, NEXT, NO_GUARD, OutputSamples, Scratch, arm_flight, new_sample
from oblique_impact.marching.equations import QUADRATURES, derivative

#: of a step: with 16 it may be some twenty periods of the fastest mode long, and the tables stay small
POINTS = 16
_HIGHEST = 4  # the longest step is so many doublings of the output interval: the tables grow with its samples
_WIDEST = 120.0  # largest |lambda| h of a step, lambda an eigenvalue: more has no accurate weights
_NARROWEST = 2.0  # largest |lambda| h below which the stages of a Runge-Kutta step are cheaper
_SWEEPS = 6  # the most; where f needs more a shorter step is cheaper
_SETTLED = 0.01  # change, relative to the tolerance, that another sweep need not make
#: error below which the step is doubled, which multiplies it by 2^POINTS: half of the tolerance is kept in hand
_EASY = 2.0 ** -(POINTS + 1)
_SAME = 1e-9  # of the interval: times that differ less are the same sample
_CLEAR = 2.0  # steps stay so many times the way of the fastest place from any obstacle: its speed grows in them
#: a step should replace so many Runge-Kutta steps at least; so many are taken before another one is tried
_COST, _PATIENCE = 4.0, 8
_TAIL = 2  # Legendre coefficients that estimate the error: f may be even or odd about the middle of a step
_CAUTION = 2.0  # the sweeps of another step may contract as much slower
LEVEL, PATIENCE, SPEED, CONTRACTION = range(4)
#: phase (rad) of the fastest mode in a run, and between two samples, from which it is worth being compiled: a run
#: that is sampled so rarely is one of many
_LONG_RUN, _RARELY = 5e3, 10.0


class Exponential(NamedTuple):
    """Tables and buffers of the integrator for a run; a level for each length h, twice that of the one before."""

    lengths: Array  # (levels,) s
    shapes: Array  # (d, d)
    projection: Array  # (d, d)
    stiffness: Array  # (d,)
    damping: Array  # (d,)
    nodes: Array  # (s,) of a step, from 0 to 1
    free: Array  # (levels, rows, 4, d) z and z' of a free vibration, of z and z' at the start
    forced: Array  # (levels, rows, 2, d, s) z and z' of f at the points
    areas: Array  # (levels, rows, s) integrals (s) of what is known at the points
    tail: Array  # (2, s) the last Legendre coefficients of what is known at the points
    of_tail: Array  # (levels, 2, 2, d) z and z' at the end of these
    force: Array  # (2, d, s) f at the points, of this sweep and of the last one
    rates: Array  # (s, 3) of the quadratures at the points
    state: Array  # (2, d) z and z' at the start
    ends: Array  # (2, d) z and z' somewhere, or their errors
    memory: Array  # (4,) from call to call: level, patience, speed (m/s), contraction of the sweeps (1/s)


def is_worthwhile(modes: NormalModes, interval: float, end_time: float) -> bool:
    """Whether a run until `end_time` (s) with samples every `interval` (s) is worth the tables."""
    fastest = np.max(np.abs(modes.eigenvalues))
    return bool(fastest * end_time >= _LONG_RUN or fastest * interval >= _RARELY)


def new_exponential(modes: NormalModes, interval: float) -> Exponential:
    """Return the tables of a run with samples every `interval` (s), and buffers of its own."""
    tables, d = _tables(interval, *(values.tobytes() for values in modes)), modes.stiffness.size
    work = (
        np.zeros((2, d, POINTS)),
        np.zeros((POINTS, QUADRATURES)),
        np.zeros((2, d)),
        np.zeros((2, d)),
        np.array([0.0, 0.0, 0.0, np.inf]),
    )
    return Exponential(*[*tables, *work])


@lru_cache(maxsize=4)  # of a sweep, whose beams are often the same
def _tables(interval: float, *packed: bytes) -> tuple[Array, ...]:
    """Return the tables of normal modes as bytes, which can be remembered.

    The rows of a table are the points of a step but the first, the last of them its end, and then the samples
    inside of it.
    """
    shapes, projection, stiffness, damping = (np.frombuffer(values).copy() for values in packed)
    d = stiffness.size
    modes = NormalModes(shapes.reshape(d, d), projection.reshape(d, d), stiffness, damping)
    fastest = np.max(np.abs(modes.eigenvalues))
    highest = min(_HIGHEST, int(np.floor(np.log2(_WIDEST / (fastest * interval)))))
    lowest = min(highest, int(np.ceil(np.log2(_NARROWEST / (fastest * interval)))))
    levels = range(lowest, highest + 1)
    nodes = _lobatto(POINTS)
    rows = POINTS - 1 + (2 ** max(highest, 1) - 1)
    lengths = interval * 2.0 ** np.array(levels)
    free, forced = np.zeros((len(levels), rows, 4, d)), np.zeros((len(levels), rows, 2, d, POINTS))
    areas, of_tail = np.zeros((len(levels), rows, POINTS)), np.zeros((len(levels), _TAIL, 2, d))
    fit = np.linalg.inv(np.polynomial.legendre.legvander(2.0 * nodes - 1.0, POINTS - 1))
    for i, level in enumerate(levels):
        inside = np.arange(1, 2 ** max(level, 0)) / 2.0 ** max(level, 0)
        places = np.concatenate([nodes[1:], inside])
        used = slice(0, places.size)
        free[i, used] = _free(modes, lengths[i] * places)
        of_coefficients, integrals = _forced(modes, lengths[i], places)
        forced[i, used] = np.einsum("pvmd,mj->pvdj", of_coefficients, fit)
        areas[i, used] = integrals @ fit
        of_tail[i] = of_coefficients[POINTS - 2, :, -_TAIL:].swapaxes(0, 1)
    found = lengths, *modes, nodes, free, forced, areas, fit[-_TAIL:], of_tail
    return tuple(map(np.ascontiguousarray, found))


def _lobatto(count: int) -> Array:
    """Return the Gauss-Lobatto points of [0, 1]."""
    inner = Legendre.basis(count - 1).deriv().roots()
    return 0.5 * (1.0 + np.concatenate([[-1.0], np.sort(inner.real), [1.0]]))


_gauss = lru_cache(maxsize=64)(np.polynomial.legendre.leggauss)


def _impulse_response(modes: NormalModes, t: Array) -> tuple[Array, Array]:
    """g(t) (s) and g'(t) of each mode, (..., d): g'' + damping g' + stiffness g = 0, g(0) = 0, g'(0) = 1."""
    t, root = t[..., None], -modes.eigenvalues - 0.5 * modes.damping
    decay, u = -0.5 * modes.damping * t, root * t
    grow, fade = np.exp(decay + u), np.exp(decay - u)
    small = np.abs(u) < 1e-3
    series = t * np.exp(decay) * (1.0 + u * u / 6.0 * (1.0 + u * u / 20.0))
    g = np.where(small, series, (grow - fade) / np.where(small, 1.0, 2.0 * root))
    rate = 0.5 * (grow + fade) - 0.5 * modes.damping * g
    return g.real, rate.real


def _free(modes: NormalModes, t: Array) -> Array:
    """Return z and z' of a free vibration at times t (p,) of z and z' at 0: (p, 4, d)."""
    g, rate = _impulse_response(modes, t)
    return np.stack([rate + modes.damping * g, g, -modes.stiffness * g, rate], axis=1)


def _forced(modes: NormalModes, h: float, places: Array) -> tuple[Array, Array]:
    """Return z and z' at places (p,) of a step for each Legendre polynomial in f, and the integrals of these."""
    count = POINTS + int(np.max(np.abs(modes.eigenvalues)) * h)
    x, weights = _gauss(count)
    x, weights = 0.5 * (1.0 + x), 0.5 * weights
    back = places[:, None] * (1.0 - x)  # from the place to where f acts
    g, rate = _impulse_response(modes, h * back)
    basis = np.polynomial.legendre.legvander(2.0 * places[:, None] * x - 1.0, POINTS - 1)
    basis = basis * (h * places[:, None, None] * weights[:, None])
    return np.stack([basis.swapaxes(1, 2) @ g, basis.swapaxes(1, 2) @ rate], axis=1), basis.sum(axis=1)


@jitable
def _at(tables: Exponential, level: int, row: int, before: int, z: Array) -> None:
    """Put z and z' at a row of the tables into z (2, d); f is that of this sweep, or of the one before."""
    free, forced, force, start = tables.free, tables.forced, tables.force, tables.state
    for k in range(z.shape[1]):
        place = free[level, row, 0, k] * start[0, k] + free[level, row, 1, k] * start[1, k]
        rate = free[level, row, 2, k] * start[0, k] + free[level, row, 3, k] * start[1, k]
        for j in range(force.shape[2]):
            place += forced[level, row, 0, k, j] * force[before, k, j]
            rate += forced[level, row, 1, k, j] * force[before, k, j]
        z[0, k], z[1, k] = place, rate


@jitable
def _store_force(tables: Exponential, point: int, z: Array, dy: Array) -> None:
    """Store f at a point, from the derivative `dy` there."""
    d, force, stiffness, damping, rates = z.shape[1], tables.force, tables.stiffness, tables.damping, tables.rates
    for k in range(d):
        total = damping[k] * z[1, k] + stiffness[k] * z[0, k]
        for i in range(d):
            total += tables.projection[k, i] * dy[d + i]
        force[0, k, point] = total
    for i in range(rates.shape[1]):
        rates[point, i] = dy[2 * d + i]


@jitable
def _norm(tables: Exponential, y: Array, scales: Array, tolerance: float) -> float:
    """Size of errors of z and z', which are in `ends`, as errors of q and q' relative to the tolerance."""
    d, shapes, ends, total = tables.ends.shape[1], tables.shapes, tables.ends, 0.0
    for v in range(2):
        for i in range(d):
            error = 0.0
            for k in range(d):
                error += shapes[i, k] * ends[v, k]
            m = v * d + i
            relative = error / (tolerance * (scales[m] + abs(y[m])))
            total += relative * relative
    return float(np.sqrt(total / (2 * d)))


@jitable
def _error(tables: Exponential, level: int, y: Array, s: Scratch, tolerance: float) -> float:
    """Error of the end of a step that the last Legendre coefficients of f and of powers make, relative."""
    ends, tail, of_tail, force, rates = tables.ends, tables.tail, tables.of_tail, tables.force, tables.rates
    largest, energy = 0.0, tolerance * s.tolerances.energy
    for m in range(tail.shape[0]):
        for k in range(ends.shape[1]):
            coefficient = 0.0
            for j in range(tail.shape[1]):
                coefficient += tail[m, j] * force[0, k, j]
            ends[0, k] = of_tail[level, m, 0, k] * coefficient
            ends[1, k] = of_tail[level, m, 1, k] * coefficient
        largest = max(largest, _norm(tables, y, s.scales, tolerance))
        for i in range(QUADRATURES):
            coefficient = 0.0
            for j in range(tail.shape[1]):
                coefficient += tail[m, j] * rates[j, i]
            largest = max(largest, abs(coefficient) * tables.lengths[level] / energy)
    return float(largest)


@jitable
def _change(tables: Exponential, level: int, y: Array, scales: Array, tolerance: float) -> float:
    """Change of the end of a step by the last sweep, relative to the tolerance."""
    ends, forced, force, end = tables.ends, tables.forced, tables.force, tables.nodes.shape[0] - 2
    for v in range(2):
        for k in range(ends.shape[1]):
            total = 0.0
            for j in range(force.shape[2]):
                total += forced[level, end, v, k, j] * (force[0, k, j] - force[1, k, j])
            ends[v, k] = total
    return float(_norm(tables, y, scales, tolerance))


@jitable
def _write(tables: Exponential, level: int, row: int, y: Array, target: Array) -> None:
    """Write the state at a row of the tables."""
    d, areas, rates = tables.ends.shape[1], tables.areas, tables.rates
    _at(tables, level, row, 0, tables.ends)
    multiply(tables.shapes, tables.ends[0], target[:d])
    multiply(tables.shapes, tables.ends[1], target[d : 2 * d])
    for i in range(rates.shape[1]):
        total = y[2 * d + i]
        for j in range(rates.shape[0]):
            total += areas[level, row, j] * rates[j, i]
        target[2 * d + i] = total
    for i in range(2 * d + rates.shape[1], y.shape[0]):  # what contacts have gained does not change in flight
        target[i] = y[i]


@jitable
def _step(flight: Any, tables: Exponential, t: float, y: Array, level: int) -> tuple[float, float]:
    """Step from (t, y), whose derivative is in K[0], to s.y_new; its error, relative, and the largest gap rate.

    `flight` is the stepper of the event scheme.  The error is infinite where f is not found.
    """
    s, tolerance, h, speed = flight.scratch, flight.tolerance, tables.lengths[level], 0.0
    d, points, force = tables.ends.shape[1], tables.nodes.shape[0], tables.force
    multiply(tables.projection, y[:d], tables.state[0])
    multiply(tables.projection, y[d : 2 * d], tables.state[1])
    _store_force(tables, 0, tables.state, flight.stages.K[0])
    for k in range(d):
        for j in range(1, points):
            force[0, k, j] = force[0, k, 0]
    change, contraction = np.inf, tables.memory[CONTRACTION] * h
    for sweep in range(_SWEEPS):
        for k in range(d):
            copy(force[0, k], force[1, k])
        for j in range(1, points):
            _at(tables, level, j - 1, 1, tables.ends)
            multiply(tables.shapes, tables.ends[0], s.at[:d])
            multiply(tables.shapes, tables.ends[1], s.at[d : 2 * d])
            status = derivative(
                flight.system, flight.contacts, t + tables.nodes[j] * h, s.at, s.work, flight.stages.K[1]
            )
            if status != 0:
                return np.inf, speed
            speed = max(speed, nearest(flight.contacts)[1])
            _store_force(tables, j, tables.ends, flight.stages.K[1])
        last, change = change, _change(tables, level, y, s.scales, tolerance)
        # sweeps contract at a rate that two of them show, or those of the step before did (Hairer and Wanner,
        # Solving ODEs II, Sec. IV.8)
        if sweep > 0:
            contraction = change / last if last > 0.0 else 0.0
            tables.memory[CONTRACTION] = _CAUTION * contraction / h
        # powers are those of the motion before this sweep
        if change <= _SETTLED or (change <= 1.0 and change * contraction <= _SETTLED):
            _write(tables, level, points - 2, y, s.y_new)
            return _error(tables, level, y, s, tolerance), speed
    return np.inf, speed


@jitable
def begins_at_samples(tables: Exponential | None, free: bool) -> bool:
    """Whether steps are cut at samples, because exponential steps begin there."""
    if tables is None:
        return False
    return free


@jitable
def begin_flight(tables: Exponential | None, speed: float) -> None:
    """Begin with the longest steps, knowing nothing of their sweeps but the gap rate (m/s)."""
    if tables is not None:
        memory = tables.memory
        memory[LEVEL], memory[PATIENCE], memory[SPEED] = tables.lengths.shape[0] - 1, 0, speed
        memory[CONTRACTION] = np.inf


@jitable
def follow_step(tables: Exponential | None, speed: float, cut: bool) -> None:
    """Follow a step of another kind, with its largest gap rate (m/s): one that is cut may end at a sample."""
    if tables is not None:
        tables.memory[SPEED] = speed
        if cut:
            tables.memory[PATIENCE] = 0


@jitable
def take_exponential_step(flight: Any, tables: Exponential, now: Position, y: Array) -> Step:
    """Take the longest step of a level up to that of the last one that stays clear of all obstacles.

    `flight` is the stepper of the event scheme, which imports this module.  The derivative at the start and then
    at the end is in K[0].  The step is refused if none is worth its time now.
    """
    contacts, limits, s, t, interval = (
        flight.contacts,
        flight.limits,
        flight.scratch,
        now.t,
        flight.limits.interval,
    )
    memory, levels, next_sample = tables.memory, tables.lengths.shape[0], s.samples.counts[NEXT]
    if not is_free(contacts):
        return refused(OK, 0.0)
    if memory[PATIENCE] > 0:
        memory[PATIENCE] -= 1
        return refused(OK, 0.0)
    here = abs(next_sample * interval - t) <= _SAME * interval
    following = (next_sample + 1) * interval if here else next_sample * interval
    level = int(memory[LEVEL])
    while level >= 0 and tables.lengths[level] >= _COST * now.h:
        h = tables.lengths[level]
        inside = int(h / interval * (1.0 + _SAME)) - 1  # samples
        fits = here if inside >= 0 else t + h <= following + _SAME * interval
        near = now.gap <= _CLEAR * h * memory[SPEED]
        fits = fits and s.samples.counts[KEPT] + inside + 2 < s.samples.times.shape[0]
        if fits and not near and t + h <= limits.t_stop:
            error, speed = _step(flight, tables, t, y, level)
            if error <= 1.0:
                end = t + h if inside < 0 else (next_sample + inside + 1) * interval
                end = following if abs(end - following) <= _SAME * interval else end
                status = derivative(flight.system, contacts, end, s.y_new, s.work, flight.stages.K[1])
                gap, _ = nearest(contacts)
                if status == 0 and min(now.gap, gap) > _CLEAR * h * speed:
                    _keep_samples(tables, t, interval, y, level, here, inside, s.samples)
                    copy(flight.stages.K[1], flight.stages.K[0])
                    arm_flight(s.guards)
                    longer = error < _EASY and level + 1 < levels
                    memory[LEVEL], memory[SPEED] = level + 1 if longer else level, speed
                    return Step(OK, True, end, now.h, NO_GUARD, gap)
        level -= 1
    memory[LEVEL], memory[PATIENCE] = levels - 1, _PATIENCE - 1
    return refused(OK, 0.0)


@jitable
def _keep_samples(
    tables: Exponential,
    t: float,
    interval: float,
    y: Array,
    level: int,
    here: bool,
    inside: int,
    samples: OutputSamples,
) -> None:
    """Keep the sample at the start of a step and those inside of it."""
    first = samples.counts[NEXT]
    if here:
        copy(y, samples.states[new_sample(t, samples)])
    for m in range(1, inside + 1):
        row = tables.nodes.shape[0] - 2 + m
        _write(tables, level, row, y, samples.states[new_sample((first + m) * interval, samples)])
