r"""
A panel between two stops
=========================

A panel of aluminium, clamped at one edge in a cabinet, gets a shock: half a sine wave of 30 m/s² in 11 ms. Two
rubber stops 3 mm from its faces keep its free edge from swinging out. How large does the moment at the clamp
become, and how well is this number known?

By hand, without the stops: each mode of a cantilever answers the shock as an oscillator does, by Duhamel's
integral,

.. math::

   q_n(t) = -\frac{\Gamma_n}{\omega_n} \int_0^t a(s)\, \sin \omega_n (t - s)\, \mathrm{d}s, \qquad
   M(t) = \sum_n E I\, \phi_n''(0)\, q_n(t).

The shock is over before the first mode has moved far. So this mode gets the velocity :math:`\Gamma_1 \Delta v`
from it, :math:`\Delta v = (2/\pi)\, 30\ \mathrm{m/s^2} \cdot 11\ \mathrm{ms}`, and for the swing that follows
the length of the panel cancels out: :math:`M_1 = 1.566\, \Delta v \sqrt{E I\, m}`. The other modes add to it,
and so do the stops.
"""

import numpy as np
from matplotlib.figure import Figure

from oblique_impact import Scenario, simulate
from oblique_impact.renders import Style, render
from oblique_impact.renders.style import GREY, SERIES, figure_style
from oblique_impact.validation import refine

strength, lasts = 30.0, 0.011  # m/s^2, s
instants = np.linspace(0.0, lasts, 45)
shock = [[time, strength * np.sin(np.pi * time / lasts).item()] for time in instants.tolist()]
panel = Scenario.from_toml(
    """
    end_time = 0.08
    gravity = 0.0
    beam.length = "600 mm"
    beam.material = "aluminium"
    beam.kelvin_voigt = 9.3e-5  # s, 0.2 % of critical
    beam.section = { shape = "rectangle", width = "200 mm", height = "3 mm" }
    root.kind = "driven"  # held
    initial.angle = 0.0
    base.direction = "90 deg"
    slope.enabled = false
    contact = { where = "anywhere", normal = "spring", stiffness = 5e4, friction = "frictionless" }
    obstacles = [
        { kind = "point", origin = ["590 mm", "-3 mm"] },
        { kind = "point", origin = ["590 mm", "3 mm"] },
    ]
    discretization.modes = 12
    solver.output_interval = "0.05 ms"
    """
).replace(base__table=shock)
free = panel.adapted(contact__enabled=False)
beam = panel.beam
bending, mass = beam.youngs_modulus * beam.second_moment, beam.density * beam.area

# %%
# Without the stops
# -----------------
#
# Duhamel's integral of six modes beside the program's moment, which it computes from the equilibrium of the panel.

roots = np.array([1.87510, 4.69409, 7.85476, 10.99554, 14.13717, 17.27876]) / beam.length
share = 2.0 / (roots * beam.length) * np.array([0.73410, 1.01847, 0.99922, 1.00003, 1.0, 1.0])  # Gamma, phi(L) = 2
frequencies = roots**2 * np.sqrt(bending / mass)  # rad/s
fine = np.arange(0.0, panel.end_time, 2e-5)
pulse = np.interp(fine, *np.transpose(shock), right=0.0)
moment = np.zeros_like(fine)
for root, part, omega in zip(roots, share, frequencies, strict=True):
    damping = 0.5 * beam.kelvin_voigt * omega**2  # 1/s
    answer = np.exp(-damping * fine) * np.sin(omega * fine) / omega
    moment += bending * 2.0 * root**2 * part * 2e-5 * np.convolve(pulse, answer)[: fine.size]
alone = simulate(free)
computed = -alone.section_forces()["moment"].values[:, 0]
by_hand = np.interp(alone["time"], fine, moment)
change = 2.0 / np.pi * strength * lasts  # m/s
print(f"first mode: {1.566 * change * np.sqrt(bending * mass):.3f} N m")
print(f"six modes, Duhamel: {np.abs(moment).max():.3f} N m; computed {np.abs(computed).max():.3f} N m")
assert np.abs(computed - by_hand).max() < 0.02 * np.abs(moment).max()

# %%
# With the stops
# --------------
#
# The study adds modes until the number stays, and says how far it may still be from that of the beam, with what
# the samples miss of the maximum.

found = refine(panel, modes=[4, 8, 16, 32], quantities=["peak:moment"], workers=1)
number = found["peak:moment"]
print(f"largest moment: {number.value:.4f} N m, uncertain by {number.uncertainty:.1g} N m, {number.verdict}")
struck = simulate(panel.replace(discretization__modes=16))
assert number.verdict == "converged"
assert number.uncertainty < 1e-3 * number.value

with figure_style():
    figure = Figure(figsize=(7.2, 3.6), layout="constrained")
    axes = figure.subplots()
    axes.plot(1e3 * fine, moment, color=GREY, lw=4.0, alpha=0.5, label="without stops, by hand")
    axes.plot(1e3 * alone["time"], computed, color=SERIES[0], label="without stops")
    held = -struck.section_forces()["moment"].values[:, 0]
    axes.plot(1e3 * struck["time"], held, color=SERIES[1], label="between stops")
    for contact in struck.contacts:
        axes.axvspan(1e3 * contact.start, 1e3 * contact.end, color=SERIES[1], alpha=0.12, lw=0.0)
    axes.set(xlabel="time (ms); shaded: a stop touches", ylabel="moment at the clamp (N m)")
    axes.legend()
    figure.savefig("panel_1_moment.svg")

# %%
# That is the uncertainty of the computation. What is known of the rubber and of the damping weighs more:

print("stop (N/m)   damping   largest moment (N m)")
others = []
for stiffness, ratio in ((2.5e4, 0.002), (5e4, 0.002), (1e5, 0.002), (5e4, 0.001), (5e4, 0.01)):
    damping = (2.0 * ratio / frequencies[0]).item()
    like = panel.replace(contact__stiffness=stiffness, beam__kelvin_voigt=damping, end_time=0.04)
    others.append(np.abs(simulate(like).section_forces()["moment"].values).max())
    print(f"{stiffness:10.1e} {100 * ratio:7.1f} % {others[-1]:12.3f}")
assert np.ptp(others) > 100.0 * number.uncertainty

# %%
# At its largest moment the free edge has just left the stop: the wave that the contact sent has come to the clamp.

look = Style(size=(720, 360), charts=False, ghosts=False)
render(struck, "panel_2.png", look, time=struck["time"].values[np.abs(held).argmax()].item())
