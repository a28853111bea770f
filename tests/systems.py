"""Small mechanical systems with closed-form motions and a contact law of a user, shared by the unit tests."""

from dataclasses import dataclass

import numpy as np

from oblique_impact import MechanicalSystem
from oblique_impact.contact.stops import ContactLaw
from oblique_impact.kernels.system import ContactRows


class Block(MechanicalSystem):
    """A point mass over the plane y = 0 under a force (fx, fy)(t, x, vx, y, vy); q = [x, y]."""

    size = 2

    def __init__(self, force, mass=1.0):
        self.force, self.mass = force, mass

    def mass_matrix(self, t, q):
        return self.mass * np.eye(2)

    def forces(self, t, q, qd):
        return np.array(self.force(t, q, qd), dtype=float)

    def contact(self, t, q, qd):
        return ContactRows(q[1], q[0], qd[1], qd[0], np.array([0.0, 1.0]), np.array([1.0, 0.0]))

    def energy(self, t, q, qd):
        return 0.5 * self.mass * float(qd @ qd), 0.0, 0.0


class Prescribed(MechanicalSystem):
    """A coordinate s with s'' = acceleration whose gap is g(s), with derivatives g1 and g2; q = [s]."""

    size = 1

    def __init__(self, g, g1, g2, acceleration=0.0):
        self.g, self.g1, self.g2, self.acceleration = g, g1, g2, acceleration

    def mass_matrix(self, t, q):
        return np.eye(1)

    def forces(self, t, q, qd):
        return np.array([self.acceleration])

    def contact(self, t, q, qd):
        slope = self.g1(q[0])
        bias = self.g2(q[0]) * qd[0] ** 2
        return ContactRows(self.g(q[0]), 0.0, slope * qd[0], 0.0, np.array([slope]), np.zeros(1), bias, 0.0)

    def energy(self, t, q, qd):
        return 0.5 * float(qd[0]) ** 2, 0.0, -self.acceleration * float(q[0])


@dataclass(frozen=True)
class PowerLaw(ContactLaw):
    """Hertz's stop; with an exponent of 1 the built-in one. One class, which is compiled once."""

    stiffness: float = 1e6
    exponent: float = 1.5
    damping: float = 0.0

    @staticmethod
    def normal_force(depth, rate, stiffness, exponent, damping):
        return stiffness * depth**exponent * (1.0 + damping * rate)
