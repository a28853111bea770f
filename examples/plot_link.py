r"""
A robot's link that strikes a corner
====================================

A link of aluminium tube turns on the hub of its motor, unpowered, and strikes the corner of a fixture with its
middle. How large is the push on the link and on the fixture?

By hand, for a link that does not bend: it turns with :math:`\omega` about the hub and has, with the hub, the
moment of inertia :math:`J = J_\mathrm{hub} + m L^2/3`. At the distance :math:`a` it strikes as a mass

.. math:: m_\mathrm{eff} = J/a^2 \quad\text{with the velocity}\quad v = \omega a,

so that a corner on a spring :math:`k` without losses throws it back with the impulse :math:`2\,
m_\mathrm{eff}\, v = 2 J \omega/a`; the largest force is :math:`v \sqrt{k\, m_\mathrm{eff}}`, and contact lasts
:math:`\pi \sqrt{m_\mathrm{eff}/k}`. This is right as long as the contact lasts long beside the vibrations of
the link, 7 ms in its first mode. On a hard corner the link bends while it is struck, and keeps vibrating with
part of its energy: it is thrown back with less.
"""

import numpy as np
from matplotlib.figure import Figure

from oblique_impact import Scenario, simulate
from oblique_impact.renders import Style, render
from oblique_impact.renders.style import GREY, SERIES, figure_style

link = Scenario.from_toml(
    """
    end_time = 0.18
    gravity = 0.0  # it turns in a horizontal plane
    beam.length = "800 mm"
    beam.material = "aluminium"
    beam.kelvin_voigt = 4.5e-6  # s, 0.2 % of critical
    beam.section = { shape = "tube", diameter = "40 mm", thickness = "2 mm" }
    root = { kind = "hub", inertia = 0.02 }
    initial = { angle = "10 deg", angular_velocity = -2.0 }
    slope.enabled = false
    contact = { where = "anywhere", normal = "spring", stiffness = 1e6, mu_static = 0.2, mu_kinetic = 0.2 }
    obstacles = [{ kind = "point", origin = ["400 mm", 0] }]
    discretization = { frame = "mean-axis", modes = 8 }
    solver.output_interval = "0.5 ms"
    """
)
beam, spin = link.beam, abs(link.initial.angular_velocity)
inertia = link.root.inertia + beam.density * beam.area * beam.length**3 / 3.0


def strike(stiffness, place=0.4):
    """Return the history of a link that strikes a corner of a stiffness (N/m) at a place (m)."""
    return simulate(link.replace(contact__stiffness=stiffness, obstacles__1__origin=[place, 0.0]))


print("stiffness (N/m)   impulse (N s)   by hand    largest force (N)   by hand    contact (ms)   by hand")
for stiffness in (1e3, 1e4, 1e5, 1e6, 1e7):
    (collision,) = strike(stiffness).macro_collisions
    impulse, force = collision["normal_impulse"], collision["peak_force"]
    lasts = collision["end"] - collision["start"]
    mass, speed = inertia / 0.4**2, spin * 0.4
    hand = 2.0 * mass * speed, speed * np.sqrt(stiffness * mass), np.pi * np.sqrt(mass / stiffness)
    print(f"{stiffness:15.0e} {impulse:15.4f} {hand[0]:9.4f} {force:20.1f} {hand[1]:9.1f}", end="")
    print(f" {1e3 * lasts:15.2f} {1e3 * hand[2]:9.2f}")
    if stiffness <= 1e4:
        assert abs(impulse / hand[0] - 1.0) < 2e-3
        assert abs(force / hand[1] - 1.0) < 0.01
        assert abs(lasts / hand[2] - 1.0) < 0.01
    assert impulse <= 1.002 * hand[0]

# %%
# What the corner takes is what the turning of the link loses: whatever the link does meanwhile, the impulse times
# its distance from the hub is the change of the angular momentum. In the frame of the mean axis of the link this
# is the moment of inertia times the change of the frame's angular velocity. Friction has no lever arm but the
# deflection.

struck = strike(1e6)
(collision,) = struck.macro_collisions
lost = inertia * (struck["theta_dot"][-1] - struck["theta_dot"][0]).item()
print(f"angular momentum: {lost:.5f} N m s, impulse times distance {0.4 * collision['normal_impulse']:.5f} N m s")
assert abs(0.4 * collision["normal_impulse"] / lost - 1.0) < 1e-3

# %%
# Where along the link
# --------------------
#
# The impulse over the place of the corner. On soft rubber, 1e4 N/m, it is the rigid link's everywhere. On a hard
# corner it is less, by 13 % at 0.27 m and by 29 % at 0.67 m; at 0.45 m the link returns almost as a rigid one.

places = np.linspace(0.15, 0.79, 17)
found = {k: [strike(k, x).macro_collisions[0]["normal_impulse"] for x in places.tolist()] for k in (1e4, 1e6)}
assert np.allclose(found[1e4], 2.0 * inertia * spin / places, rtol=0.01)
with figure_style():
    figure = Figure(figsize=(7.2, 3.4), layout="constrained")
    axes = figure.subplots()
    axes.plot(1e3 * places, 2.0 * inertia * spin / places, color=GREY, lw=4.0, alpha=0.5, label="rigid, by hand")
    for (stiffness, impulses), colour in zip(found.items(), SERIES, strict=False):
        axes.plot(1e3 * places, impulses, color=colour, label=f"{stiffness:.0e} N/m")
    axes.set(xlabel="place of the corner (mm from the hub)", ylabel="impulse (N s)", ylim=(0.0, None))
    axes.legend()
    figure.savefig("link_1_places.svg")

# %%
# The link in the middle of its contact: its outer half whips on.

look = Style(size=(720, 380), charts=False)
render(struck, "link_2.png", look, time=float(struck["time"][struck["lambda_n"].values.argmax()]))
