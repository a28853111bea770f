"""A beam's motion from q and q' alone, computed apart from the program: shapes, places, velocities, energies.

Points of the plane are complex numbers.  Shape functions are the textbook's eigenfunctions or Hermite's cubics,
the modes of a mesh those of matrices that are integrated here; nothing of the program's operators is used.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.polynomial import legendre
from scipy.interpolate import make_interp_spline
from scipy.linalg import eigh
from scipy.optimize import brentq

POINTS, WEIGHTS = legendre.leggauss(10)
#: from values at these points to integrals from -1 to each of them
INNER = np.linalg.solve(
    legendre.legvander(POINTS, 9).T, [legendre.Legendre.basis(n).integ(lbnd=-1)(POINTS) for n in range(10)]
).T
#: shear over axial stiffness of a solid circular section: Cowper's coefficient, Poisson's ratio of aluminium
SHEAR = 6.0 * 1.33 / (7.0 + 6.0 * 0.33) / (2.0 * 1.33)


def cross(a, b):
    """Moment of b at the arm a."""
    return np.imag(np.conj(a) * b)


def textbook(frame, mode, length):
    """phi and its first two derivatives by the formulas of any textbook, int phi^2 dx = length, phi(L) > 0."""
    low = (mode + 0.5) * np.pi
    if frame == "tangent":
        b = brentq(lambda z: np.cos(z) + 1.0 / np.cosh(z), low - 1.2, low + 1.2, xtol=1e-15)
        s = (np.cosh(b) + np.cos(b)) / (np.sinh(b) + np.sin(b))
        parts = [
            lambda z: np.cosh(z) - np.cos(z) - s * (np.sinh(z) - np.sin(z)),
            lambda z: np.sinh(z) + np.sin(z) - s * (np.cosh(z) - np.cos(z)),
            lambda z: np.cosh(z) + np.cos(z) - s * (np.sinh(z) + np.sin(z)),
        ]
    else:
        low = (mode + 1.25) * np.pi
        b = brentq(lambda z: np.sin(z) - np.cos(z) * np.tanh(z), low - 0.3, low + 0.3, xtol=1e-15)
        s = np.sin(b) / np.sinh(b)
        parts = [
            lambda z: np.sin(z) + s * np.sinh(z),
            lambda z: np.cos(z) + s * np.cosh(z),
            lambda z: -np.sin(z) + s * np.sinh(z),
        ]
    nodes, weights = legendre.leggauss(40)
    scale = np.sign(parts[0](b)) / np.sqrt(0.5 * weights @ parts[0](0.5 * b * (1.0 + nodes)) ** 2)
    return [lambda x, f=f, k=k: scale * (b / length) ** k * f(b * x / length) for k, f in enumerate(parts)]


def hermite(nodes, x, derivative):
    """Hermite's cubics or their derivatives at places x, (x, 2 nodes): deflection and slope, node by node."""
    found = np.zeros((x.size, 2 * nodes.size))
    e = np.clip(np.searchsorted(nodes, x, side="right") - 1, 0, nodes.size - 2)
    h = np.diff(nodes)[e]
    z, rows = (x - nodes[e]) / h, np.arange(x.size)
    shapes = {
        0: (1 - 3 * z**2 + 2 * z**3, h * (z - 2 * z**2 + z**3), 3 * z**2 - 2 * z**3, h * (z**3 - z**2)),
        1: ((6 * z**2 - 6 * z) / h, 1 - 4 * z + 3 * z**2, (6 * z - 6 * z**2) / h, 3 * z**2 - 2 * z),
        2: ((12 * z - 6) / h**2, (6 * z - 4) / h, (6 - 12 * z) / h**2, (6 * z - 2) / h),
    }[derivative]
    for k, shape in enumerate(shapes):
        found[rows, 2 * e + k] = shape
    return found


def quadratic(nodes, x, derivative):
    """Quadratic shape functions of elements with a node in their middle, or their derivatives, (x, nodes)."""
    found = np.zeros((x.size, nodes.size))
    for row, place in enumerate(x):
        e = 2 * min(int(np.searchsorted(nodes[::2], place, side="right")) - 1, nodes.size // 2 - 1)
        for k in range(3):
            a, b = np.delete(nodes[e : e + 3], k)
            scale = (nodes[e + k] - a) * (nodes[e + k] - b)
            found[row, e + k] = (2 * place - a - b if derivative else (place - a) * (place - b)) / scale
    return found


class _Beam:
    """Parts of both kinds of beam: sections, a rule of quadrature, places, velocities, integrals over time."""

    def __init__(self, history):
        self.history = history
        self.scenario = s = history.scenario
        self.time, self.q, self.qd = (np.asarray(history[name].values) for name in ("time", "q", "qd"))
        self.x = history["station"].values
        self.radius = s.root.hub_radius
        self.touch = int(np.argmin(np.abs(self.x - s.contact.point)))
        self.nodes = np.array(s.discretization.nodes)
        kinks = [row[0] for table in (s.beam.area, s.beam.section.height) if table for row in np.atleast_2d(table)]
        # point masses, the last one that of the tip, which may be 0
        inner = [(m.place, m.mass, m.inertia) for m in s.masses]
        self.places_of_masses, masses, self.inertias = np.transpose(
            [*inner, (s.beam.length, s.beam.tip_mass, 0.0)]
        )
        kinks += [*self.places_of_masses, *(f.place for f in s.forces)]
        edges = np.union1d(np.union1d(self.x, self.nodes), [x for x in kinks if x < s.beam.length])
        self.edges = edges[np.append(True, np.diff(edges) > 1e-12)]
        self.halves = 0.5 * np.diff(self.edges)
        self.points = (self.edges[:-1, None] + self.halves[:, None] * (1.0 + POINTS)).ravel()
        self.weights = np.outer(self.halves, WEIGHTS).ravel()
        self.at_stations = np.searchsorted(self.edges, self.x - 1e-12)
        self.mass = np.append(s.beam.density * self.area(self.points) * self.weights, masses)
        self.at_masses = np.searchsorted(self.edges, self.places_of_masses - 1e-12)
        self.hub_inertia = s.root.inertia
        self.normal, self.tangent = 1j * np.exp(1j * s.slope.angle), np.exp(1j * s.slope.angle)

    def outside(self, x):
        """Whether points of mass, those of the quadrature and point masses, are outside of x or at it."""
        return np.append(self.points > x, self.places_of_masses >= x - 1e-12)

    @cached_property
    def forces(self):
        """Places (m) of forces, where they are and how fast, and they themselves, (samples,) each."""
        return [(f.place, *self.moved(f.place), self._force(f)) for f in self.scenario.forces]

    def _force(self, f):
        phase = 2.0 * np.pi * (f.frequency + 0.5 * f.sweep_rate * self.time) * self.time
        value = np.interp(self.time, *np.transpose(f.table)) if f.table else f.force * np.sin(phase)
        if not f.table and f.frequency == f.sweep_rate == 0.0:
            value = np.full(self.time.size, f.force)
        return value * (self.across(f.place) if f.direction == "across" else np.exp(1j * f.direction))

    def _profile(self, value, x):
        return np.interp(x, *np.transpose(value)) if isinstance(value, tuple) else np.full(np.shape(x), value)

    def _height(self, x):
        return self._profile(self.scenario.beam.section.height, x)

    def area(self, x):
        b = self.scenario.beam
        return b.section.width * self._height(x) if b.section.shape else self._profile(b.area, x)

    def second_moment(self, x):
        b = self.scenario.beam
        if b.section.shape:
            return b.section.width * self._height(x) ** 3 / 12.0
        return self._profile(b.second_moment, x)

    def fibre(self, x):
        b = self.scenario.beam
        if b.section.shape:
            return 0.5 * self._height(x)
        return self._profile(b.outer_fibre, x) if b.outer_fibre else np.sqrt(self.area(x) / np.pi)

    def integrals(self, f):
        """Integrals along the beam of f (samples, points): up to the edges, and up to the points."""
        panels = f.reshape(len(f), -1, POINTS.size)
        whole = np.cumsum(self.halves * (panels @ WEIGHTS), axis=1)
        at_edges = np.concatenate([np.zeros((len(f), 1)), whole], axis=1)
        inside = at_edges[:, :-1, None] + self.halves[:, None] * (panels @ INNER.T)
        return at_edges, inside.reshape(f.shape)

    @cached_property
    def pieces(self):
        """Samples between jumps."""
        jumps = np.flatnonzero(self.time[1:] == np.nextafter(self.time[:-1], np.inf)) + 1
        return [piece for piece in np.split(np.arange(self.time.size), jumps) if piece.size > 1]

    def over(self, piece, f):
        """Integral over time of f (samples, ...), from the beginning of a piece to each of its samples."""
        spline = make_interp_spline(self.time[piece], f[piece], k=3 if piece.size > 5 else 1)
        return spline.antiderivative()(self.time[piece]) - spline.antiderivative()(self.time[piece[0]])

    @property
    def contact_place(self):
        return self.z[:, self.touch]

    @property
    def contact_velocity(self):
        return self.v[:, self.touch]

    @cached_property
    def contact_force(self):
        return sum(
            np.nan_to_num(self.history[name].values) * direction
            for name, direction in (("lambda_n", self.normal), ("lambda_tau", self.tangent))
        )

    @cached_property
    def felt(self):
        """Gravity that is felt on a shaken base, (samples, 1)."""
        base = self.scenario.base
        a = base.acceleration * np.sin(2.0 * np.pi * base.frequency * self.time[:, None])
        return -1j * self.scenario.gravity - a * np.exp(1j * base.direction)

    @cached_property
    def gravity_energy(self):
        return self.scenario.gravity * self.z_points.imag @ self.mass

    @cached_property
    def total(self):
        return self.kinetic + self.elastic + self.gravity_energy


class FloatingBeam(_Beam):
    """The beam in its floating frame, q = [theta, B]."""

    def __init__(self, history):
        super().__init__(history)
        s, d = self.scenario, self.scenario.discretization
        self.theta, self.spin = self.q[:, 0], self.qd[:, 0]
        self.kept = 0.0 if d.kinetics == "zeroth-order" else 1.0
        self.B, self.Bd = self.q[:, 1:], self.qd[:, 1:]
        values, slopes, self.curvatures = (self.shapes(self.points, k) for k in range(3))
        at_stations, self.station_slopes = (self.shapes(self.x, k) for k in range(2))
        at = self.places_of_masses
        self.values, self.mass_slopes = np.concatenate([values, self.shapes(at, 0)]), self.shapes(at, 1)
        self.slopes, self.root_slope = slopes, self.shapes(np.zeros(1), 1)[0]
        B, Bd = self.B, self.Bd
        slope, rate = B @ slopes.T, Bd @ slopes.T
        edge_ux, point_ux = self.integrals(-0.5 * self.kept * slope**2)
        edge_rate, point_rate = self.integrals(-self.kept * slope * rate)
        self.ux, self.ux_dot = edge_ux[:, self.at_stations], edge_rate[:, self.at_stations]
        self.uy, self.uy_dot = B @ at_stations.T, Bd @ at_stations.T
        self.z, self.v = self._turned(self.radius + self.x + self.ux, self.uy, self.ux_dot, self.uy_dot)
        self.edge_ux, self.edge_rate = edge_ux, edge_rate
        mass_ux, mass_rate = edge_ux[:, self.at_masses], edge_rate[:, self.at_masses]
        self.arms = self.radius + np.append(self.points, at)
        self.short = np.concatenate([point_ux, mass_ux], axis=1)
        self.z_points, self.v_points = self._turned(
            self.arms + self.short,
            B @ self.values.T,
            np.concatenate([point_rate, mass_rate], axis=1),
            Bd @ self.values.T,
        )
        bend = B @ self.station_slopes.T
        self.axis_tangent = 1.0 - 0.5 * self.kept * bend**2 + 1j * bend
        # damping by mass and by mode is a load from outside that does not turn beam and hub
        X, slowed = self.mass * (self.arms + self.short), self.slowed @ self.values.T
        hub, sections = self.slowed @ self.root_slope, self.slowed @ self.mass_slopes.T
        turn = (X * slowed).sum(axis=1) + self.hub_inertia * hub + sections @ self.inertias
        turn = -turn / (X @ self.arms + self.hub_inertia + self.inertias.sum())
        turn = turn if s.root.kind != "driven" else 0.0 * turn
        self.drag = -1j * self.mass * (slowed + np.outer(turn, self.arms)) * np.exp(1j * self.theta)[:, None]
        self.hub_drag = -self.hub_inertia * (hub + turn)
        # sections have no rotary inertia, point masses may have
        self.turning, self.turning_drag = np.zeros((2, *self.v_points.shape))
        self.turning[:, -at.size :] = self.inertias * (self.spin[:, None] + Bd @ self.mass_slopes.T)
        self.turning_drag[:, -at.size :] = -self.inertias * (sections + turn[:, None])

    def moved(self, place):
        """Where a place of the axis is and how fast, (samples,) each."""
        k, shape = np.searchsorted(self.edges, place - 1e-12), self.shapes(np.array([place]), 0)
        x, rate = self.radius + place + self.edge_ux[:, [k]], self.edge_rate[:, [k]]
        return [z[:, 0] for z in self._turned(x, self.B @ shape.T, rate, self.Bd @ shape.T)]

    def across(self, place):
        """Direction across the axis at a place, (samples,)."""
        slope = self.B @ self.shapes(np.array([place]), 1)[0]
        return np.exp(1j * self.theta) * 1j * (1.0 - 0.5 * self.kept * slope**2 + 1j * slope)

    def _turned(self, x, y, xd, yd):
        turn, spin = np.exp(1j * self.theta)[:, None], self.spin[:, None]
        w = x + 1j * y
        return turn * w, turn * (xd + 1j * yd + 1j * spin * w)

    def shapes(self, x, derivative):
        """Shape functions or their derivatives at places x, (x, n)."""
        d, length = self.scenario.discretization, self.scenario.beam.length
        if d.method == "modal":
            modes = [textbook(d.frame, k, length) for k in range(d.modes)]
            found = np.stack([mode[derivative](x) for mode in modes], axis=1)
            if d.frame == "mean-axis" and self.scenario.masses:  # each without angular momentum
                arms = np.append(self.points, self.places_of_masses)
                value, slope = (np.stack([mode[k](arms) for mode in modes], axis=1) for k in range(2))
                turns = (self.mass * arms) @ value + self.inertias @ slope[-self.inertias.size :]
                turns /= self.mass @ arms**2 + self.inertias.sum()
                found -= np.outer((x, np.ones_like(x), np.zeros_like(x))[derivative], turns)
            return found
        return hermite(self.nodes, x, derivative) @ self._modes

    @cached_property
    def _modes(self):
        """Modes of the mesh (2 nodes, n) with the mass of the beam, positive at the tip; or all unknowns.

        In the mean-axis frame the root turns in them, and its hub with it.
        """
        s, d = self.scenario, self.scenario.discretization
        # of all nodes the slope of the root is one, in the tangent frame always 0
        free = np.arange(2 if d.frame == "tangent" and d.modes else 1, 2 * self.nodes.size)
        if d.modes == 0:
            return np.eye(2 * self.nodes.size)[:, free]
        values, curvatures = (hermite(self.nodes, self.points, k)[:, free] for k in (0, 2))
        stiffness = s.beam.youngs_modulus * self.second_moment(self.points) * self.weights
        M = values.T @ (self.mass[: self.points.size, None] * values)
        masses = self.mass[self.points.size :]
        for k, weights in ((0, masses), (1, self.inertias)):
            rows = hermite(self.nodes, self.places_of_masses, k)[:, free]
            M += rows.T @ (weights[:, None] * rows)
        if d.frame == "mean-axis":
            M[0, 0] += self.hub_inertia
        _, modes = eigh(curvatures.T @ (stiffness[:, None] * curvatures), M)
        rigid = 0 if d.frame == "tangent" else 1
        modes = modes[:, rigid : rigid + d.modes] * np.sqrt(self.mass.sum())
        found = np.zeros((2 * self.nodes.size, d.modes))
        found[free] = modes * np.sign(modes[-2])
        return found

    @cached_property
    def elastic(self):
        return 0.5 * (self.B @ self.curvatures.T) ** 2 @ self.stiffnesses

    @cached_property
    def kinetic(self):
        hub = 0.5 * self.hub_inertia * (self.spin + self.Bd @ self.root_slope) ** 2
        hub = hub + 0.5 * (self.spin[:, None] + self.Bd @ self.mass_slopes.T) ** 2 @ self.inertias
        if self.scenario.discretization.kinetics == "full":
            return hub + 0.5 * np.abs(self.v_points) ** 2 @ self.mass
        # to second order in the deflection: (r + x)^2 + u_y^2 + 2 (r + x) u_x, and rates of u_y alone
        y, yd = self.B @ self.values.T, self.Bd @ self.values.T
        square = self.arms**2 + y**2 + 2.0 * self.arms * self.short
        spin = self.spin[:, None]
        return hub + 0.5 * (spin**2 * square + 2.0 * spin * self.arms * yd + yd**2) @ self.mass

    @cached_property
    def stiffnesses(self):
        """E I at the points, times their weights."""
        return self.scenario.beam.youngs_modulus * self.second_moment(self.points) * self.weights

    @cached_property
    def elastic_mass(self):
        """Mass in motions of the deflections alone, in which a root that is free turns as the swing leaves it."""
        mass = self.values.T @ (self.mass[:, None] * self.values)
        mass += self.hub_inertia * np.outer(self.root_slope, self.root_slope)
        mass += self.mass_slopes.T @ (self.inertias[:, None] * self.mass_slopes)
        swing = self.turned(np.eye(len(mass)))
        if self.scenario.root.kind != "driven":
            whole = self.arms**2 @ self.mass + self.hub_inertia + self.inertias.sum()
            mass -= np.outer(swing, swing) / whole
        return mass

    @cached_property
    def slowed(self):
        """Rates of B' by damping by mass and by mode, (samples, n)."""
        b = self.scenario.beam
        slowed = b.mass_proportional * self.Bd
        if b.modal_damping_ratio > 0.0:
            squares, modes = eigh(
                self.curvatures.T @ (self.stiffnesses[:, None] * self.curvatures), self.elastic_mass
            )
            rates = 2.0 * b.modal_damping_ratio * np.sqrt(squares)
            slowed = slowed + self.Bd @ self.elastic_mass @ (modes * rates) @ modes.T
        return slowed

    @cached_property
    def damping_power(self):
        """Power (W) of Kelvin-Voigt damping, and of that by mass and by mode."""
        bending = (self.Bd @ self.curvatures.T) ** 2 @ self.stiffnesses
        moving = (self.Bd @ self.elastic_mass * self.slowed).sum(axis=1)
        return self.scenario.beam.kelvin_voigt * bending + moving

    @cached_property
    def hub_spin(self):
        return self.spin + self.Bd @ self.root_slope

    def turned(self, B):
        """Sum of m (r + x) u_y + J phi, in the frame, of deflections or of their rates B (samples, n)."""
        turned = self.hub_inertia * (B @ self.root_slope) + B @ self.mass_slopes.T @ self.inertias
        return B @ self.values.T @ (self.mass * self.arms) + turned

    def gradients(self, k):
        """Derivatives by q, in the frame, of places of mass (points, n + 1) and of the contact point (n + 1,)."""
        B = self.B[k]
        edges, points = self.integrals(((self.slopes @ B)[:, None] * self.slopes).T)
        HB = self.kept * np.concatenate([points, edges[:, self.at_masses]], axis=1).T
        at = self.kept * edges[:, self.at_stations[self.touch]] * self.scenario.contact.shortening
        own = np.exp(-1j * self.theta[k])
        places = np.column_stack([1j * own * self.z_points[k], 1j * self.values - HB])
        contact = 1j * self.seen_by_contact[k] * own
        shape = self.shapes(self.x[self.touch : self.touch + 1], 0)[0]
        return places, np.append(contact, 1j * shape - at)

    @cached_property
    def seen_by_contact(self):
        """Place of the contact point as gap and slip know it."""
        if self.scenario.contact.shortening:
            return self.contact_place
        return self.contact_place - np.exp(1j * self.theta) * self.ux[:, self.touch]

    @cached_property
    def rate_seen_by_contact(self):
        if self.scenario.contact.shortening:
            return self.contact_velocity
        turn, at = np.exp(1j * self.theta), self.touch
        return self.contact_velocity - turn * (self.ux_dot[:, at] + 1j * self.spin * self.ux[:, at])

    def mass_matrix(self, k):
        """Mass matrix at a sample, of the order of the scenario's kinetics."""
        places, _ = self.gradients(k)
        M = np.real(places.conj().T @ (self.mass[:, None] * places))
        if self.scenario.discretization.kinetics != "full":
            y = self.values @ self.B[k]
            M[0, 0] = (self.arms**2 + y**2 + 2.0 * self.arms * self.short[k]) @ self.mass
            M[0, 1:] = M[1:, 0] = self.values.T @ (self.mass * self.arms)
            M[1:, 1:] = self.values.T @ (self.mass[:, None] * self.values)
        turning = np.insert(np.vstack([self.root_slope, self.mass_slopes]), 0, 1.0, axis=1)
        return M + turning.T @ (np.append(self.hub_inertia, self.inertias)[:, None] * turning)


class ExactBeam(_Beam):
    """The geometrically exact beam, q = [x, y, phi] node by node, two nodes an element."""

    def __init__(self, history):
        super().__init__(history)
        s = self.scenario
        self.knots = np.sort(np.append(self.nodes, 0.5 * (self.nodes[1:] + self.nodes[:-1])))
        self.places, self.rates = (q[:, 0::3] + 1j * q[:, 1::3] for q in (self.q, self.qd))
        at_stations, slopes = (quadratic(self.knots, self.x, k) for k in range(2))
        of_mass = np.append(self.points, self.places_of_masses)
        points = quadratic(self.knots, of_mass, 0)
        self.z, self.v = (nodal @ at_stations.T for nodal in (self.places, self.rates))
        self.z_points, self.v_points = (nodal @ points.T for nodal in (self.places, self.rates))
        arms = self.mass * (self.radius + of_mass)
        if s.discretization.frame == "tangent":
            self.theta, self.spin = self.q[:, 2], self.qd[:, 2]
        else:
            # deflections from the mean axis, times m (r + x), sum up to 0
            sums, rates = self.z_points @ arms, self.v_points @ arms
            near, inertia = self.q[:, 2], self.inertias.sum()
            turns, turn_rates = (
                q[:, 2::3] @ points[-self.inertias.size :].T @ self.inertias for q in (self.q, self.qd)
            )
            self.theta = near + np.angle(sums * np.exp(-1j * near))
            for _ in range(20):
                turned = sums * np.exp(-1j * self.theta)
                self.theta = self.theta + (turned.imag + turns - inertia * self.theta) / (turned.real + inertia)
            turned, turning = (z * np.exp(-1j * self.theta) for z in (sums, rates))
            self.spin = (turning.imag + turn_rates) / (turned.real + inertia)
        turn = np.exp(-1j * self.theta)[:, None]
        u = turn * self.z
        rate = turn * self.v - 1j * self.spin[:, None] * u
        u = u - self.radius - self.x
        self.ux, self.uy, self.ux_dot, self.uy_dot = u.real, u.imag, rate.real, rate.imag
        self.axis_tangent = turn * (self.places @ slopes.T)
        rotary = s.beam.density * self.second_moment(self.points) * self.weights
        self.turning = (self.qd[:, 2::3] @ points.T) * np.append(rotary, self.inertias)
        self.drag, self.turning_drag = np.zeros_like(self.z_points), np.zeros_like(self.turning)
        self.hub_spin = self.qd[:, 2]

    def moved(self, place):
        """Where a place of the axis is, and how fast, (samples,) each."""
        row = quadratic(self.knots, np.array([place]), 0)[0]
        return self.places @ row, self.rates @ row

    def across(self, place):
        """Direction across the section at a place, (samples,)."""
        return 1j * np.exp(1j * (self.q[:, 2::3] @ quadratic(self.knots, np.array([place]), 0)[0]))

    @cached_property
    def kinetic(self):
        turn = self.qd[:, 2::3] @ quadratic(self.knots, np.append(self.points, self.places_of_masses), 0).T
        rotary = self.scenario.beam.density * self.second_moment(self.points) * self.weights
        rotary = np.append(rotary, self.inertias)
        hub = 0.5 * self.hub_inertia * self.hub_spin**2
        return hub + 0.5 * np.abs(self.v_points) ** 2 @ self.mass + 0.5 * turn**2 @ rotary

    @cached_property
    def elastic(self):
        """Strain energy by the two Gauss points of each element, as the elements are defined."""
        half, middle = 0.5 * np.diff(self.nodes), 0.5 * (self.nodes[1:] + self.nodes[:-1])
        x = (middle[:, None] + half[:, None] * np.array([-1.0, 1.0]) / np.sqrt(3.0)).ravel()
        values, slopes = (quadratic(self.knots, x, k) for k in range(2))
        phi, curvature = self.q[:, 2::3] @ values.T, self.q[:, 2::3] @ slopes.T
        strain = np.exp(-1j * phi) * (self.places @ slopes.T) - 1.0
        stiffness = self.scenario.beam.youngs_modulus
        squares = self.area(x) * (strain.real**2 + SHEAR * strain.imag**2) + self.second_moment(x) * curvature**2
        return 0.5 * stiffness * squares @ np.repeat(half, 2)

    @property
    def damping_power(self):
        return np.zeros(self.time.size)

    @property
    def seen_by_contact(self):
        return self.contact_place

    @property
    def rate_seen_by_contact(self):
        return self.contact_velocity


def recomputed(history):
    """Return the beam of a history."""
    absolute = history.scenario.discretization.method == "absolute"
    return (ExactBeam if absolute else FloatingBeam)(history)
