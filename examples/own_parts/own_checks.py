"""User-defined checks: run with the others by ``oblique-impact validate``, alone by ``--only own``."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from own_parts import Hertz

from oblique_impact import simulate_system
from oblique_impact.kernels.system import ContactRows, MechanicalSystem
from oblique_impact.validation.checks.registry import Measurement, checks_of, within

check = checks_of("own", "User-defined parts")


class FlyingMass(MechanicalSystem):
    """A mass of 1 kg over a plane, without weight."""

    size = 1

    def mass_matrix(self, t, q):
        return np.eye(1)

    def forces(self, t, q, qd):
        return np.zeros(1)

    def contact(self, t, q, qd):
        return ContactRows(q[0], 0.0, qd[0], 0.0, np.ones(1), np.zeros(1))

    def energy(self, t, q, qd):
        return 0.5 * float(qd @ qd), 0.0, 0.0


@check("A mass meets a Hertzian stop: its depth of penetration.", seconds=0.3)
def hertz_depth() -> Measurement:
    """All energy is in the stop at the deepest point: 1/2 m v^2 = 2/5 k d^2.5 (Johnson 1985, Sec. 11.4)."""
    law, speed = replace(Hertz(), stiffness=1e6), 0.5
    history = simulate_system(
        FlyingMass(), np.array([1e-3]), np.array([-speed]), 0.02, stop=law, output_interval=1e-6
    )
    depth = (5.0 * speed**2 / (4.0 * law.stiffness)) ** 0.4
    # samples every 1e-6 s miss the deepest point by up to 1/8 (force / mass) (1e-6 s)^2, 6e-9 of the depth
    return within("deepest", -float(history["gap"].min()), depth, "m", 1e-8, "energy balance")
