"""
A user-defined system: a mass on a belt
=======================================

A mass on a spring rides on a belt that moves at a constant speed, pressed down by its weight. It sticks to the
belt until the spring is strong enough, slips back and is caught again.
"""

import numpy as np
from matplotlib.figure import Figure

from oblique_impact import MechanicalSystem, simulate_system
from oblique_impact.contact.friction import Coulomb
from oblique_impact.contact.state import State
from oblique_impact.kernels.system import ContactRows
from oblique_impact.renders.style import GREY, STATE_COLOURS, figure_style

MASS, SPRING, GRAVITY, BELT = 1.0, 40.0, 9.81, 0.2  # kg, N/m, m/s^2, m/s
STATIC, KINETIC = 0.4, 0.25

# %%
# Four methods describe the system; contact states, friction law and scheme are those of the beam.


class MassOnBelt(MechanicalSystem):
    """q = [x, y]: the mass stands at y = 0 on a belt that moves in x."""

    size = 2

    def mass_matrix(self, t, q):
        """Return M."""
        return MASS * np.eye(2)

    def forces(self, t, q, qd):
        """Return spring and weight."""
        return np.array([-SPRING * q[0], -MASS * GRAVITY])

    def contact(self, t, q, qd):
        """Return gap and slip relative to the belt."""
        rows = np.array([0.0, 1.0]), np.array([1.0, 0.0])
        return ContactRows(q[1], q[0] - BELT * t, qd[1], qd[0] - BELT, *rows)

    def energy(self, t, q, qd):
        """Return kinetic, elastic and gravity energy."""
        return 0.5 * MASS * float(qd @ qd), 0.5 * SPRING * q[0] ** 2, MASS * GRAVITY * q[1]


# %%
# It starts with the belt, and must break away when the spring pulls with :math:`\mu_s m g`:

start = np.array([0.0, 0.0]), np.array([BELT, 0.0])
law = Coulomb(static=STATIC, kinetic=KINETIC)
history = simulate_system(MassOnBelt(), *start, end_time=5.0, friction=law, output_interval=5e-3)
breaks = [event.time for event in history.events if event.kind.value == "slip"]
exact = STATIC * MASS * GRAVITY / SPRING / BELT
print(f"breaks away first at {breaks[0]:.9f} s; mu_s m g / (k v) = {exact:.9f} s")

# %%
# The dashed lines are the positions where static and kinetic friction balance the spring.

with figure_style():
    figure = Figure(figsize=(7.2, 3.2), layout="constrained")
    axes = figure.subplots()
    for member in (State.SLIP, State.STICK):
        there = np.where(history["state"] == member, 1e3 * history["q"][:, 0], np.nan)
        axes.plot(history["time"], there, color=STATE_COLOURS[member], label=member.name.lower())
    for coefficient in (STATIC, KINETIC):
        axes.axhline(1e3 * coefficient * MASS * GRAVITY / SPRING, color=GREY, linestyle="--", linewidth=0.9)
    axes.set(xlabel="time (s)", ylabel="position of the mass (mm)", xlim=(0.0, 5.0))
    axes.legend(ncols=2, loc="lower right")
    figure.savefig("own_system.svg")
