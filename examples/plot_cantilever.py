r"""
A cantilever between two pegs
=============================

A steel strip, 300 x 20 x 1 mm, hangs from its clamp in a frame that is shaken across it with the acceleration
:math:`A \sin \omega t`, between two pegs on springs, 20 mm above its tip: 1 mm from one face and 1.5 mm from the
other. Seen from the frame, and without the small effect of gravity, its deflection :math:`u(x, t)` obeys

.. math::

   m\, \ddot u + E I\, (u + \eta\, \dot u)'''' = -m A \sin \omega t + \sum_k \lambda_k\, \delta(x - x_k), \qquad
   u = u' = 0 \ \text{at the clamp}, \quad u'' = u''' = 0 \ \text{at the tip},

with the forces :math:`\lambda_k \geq 0` of the pegs, a spring and a dashpot each, on the place :math:`x_k` that
touches. While nothing touches, the steady response is known:

.. math::

   u(L, t) = \mathrm{Im} \left[ -\frac{A}{\omega^2}
   \left( \frac{\cosh z + \cos z}{1 + \cosh z \cos z} - 1 \right) \mathrm{e}^{\mathrm{i} \omega t} \right], \qquad
   z^4 = \frac{m\, \omega^2 L^4}{E I\, (1 + \mathrm{i}\, \omega \eta)}.

By hand: :math:`f_1 = 3.516/(2 \pi)\, \sqrt{E I / m L^4}` is 9.3 Hz, and there the tip would swing by
:math:`1.57\, A/\omega^2` over twice the damping, which is 0.5 % of critical: by 46 mm, if it had the room.

The model is the full one, with all nodes of its mesh, marched by generalized-alpha.
"""

import tempfile
import warnings
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from oblique_impact import Scenario, SimulationWarning, renders, simulate
from oblique_impact.renders import Style, render
from oblique_impact.renders.style import GREY, SERIES, figure_style
from oblique_impact.validation import sweep
from oblique_impact.validation.studies.design import load_plan

docs = Path(renders.__file__).parents[1] / "docs"
strip = Scenario.builtin("cantilever")
beam, base = strip.beam, strip.base
stiffness, mass = beam.youngs_modulus * beam.second_moment, beam.density * beam.area


def swing(frequency):
    """Return the amplitude (m) of the tip if nothing touches."""
    omega = 2.0 * np.pi * frequency
    z = (mass * omega**2 * beam.length**4 / (stiffness * (1.0 + 1j * omega * beam.kelvin_voigt))) ** 0.25
    gain = (np.cosh(z) + np.cos(z)) / (1.0 + np.cosh(z) * np.cos(z)) - 1.0
    return np.abs(base.acceleration / omega**2 * gain)


# %%
# The run starts at rest. The strip first strikes the nearer peg, and after two seconds each of them once a period.

history = simulate(strip)
print(f"{len(history.contacts)} contacts, at most {max(c.peak_force for c in history.contacts):.3f} N")
print(f"energy that no entry explains: {history.balance['unaccounted']:.1e} J")

with figure_style():
    figure = Figure(figsize=(7.2, 3.8), layout="constrained")
    tip, force = figure.subplots(2, 1, sharex=True)
    tip.plot(history["time"], 1e3 * history["deflection"], color=SERIES[0], lw=0.9)
    tip.set(ylabel="deflection of the tip (mm)", xlim=(0.0, 2.0))
    for number, name in enumerate(("peg on the right, 1 mm away", "peg on the left, 1.5 mm away")):
        pushes = np.nan_to_num(history["contact_lambda_n"].values[:, number])
        force.plot(history["time"], pushes, color=SERIES[number], lw=0.9, label=name)
    force.set(xlabel="time (s)", ylabel="force (N)", ylim=(0.0, 0.45))
    force.legend(loc="upper right", ncols=2)
    figure.savefig("cantilever_1_run.svg")

# %%
# Response up and down
# --------------------
#
# The steady response at 16 frequencies, each from the state in which the one before has ended: the sweep
# ``docs/studies/cantilever.toml``, in all nodes of sixteen elements. The pegs stiffen the strip, so that its
# resonance leans to higher frequencies. On the way up it goes on striking both pegs until it falls off behind 15
# Hz; on the way down it touches neither until 11 Hz, and its swing is that of the closed form, but for gravity,
# which stiffens the hanging strip a little. At 10 Hz the motion takes two periods of the frame; at 12.5 and 13 Hz
# the large one repeats after many, if at all.

with tempfile.TemporaryDirectory() as folder:
    plan = load_plan(docs / "studies" / "cantilever.toml")
    found = sweep(plan, folder, workers=2).frame

ways = {way: found[found["direction"] == way].sort_values("base.frequency") for way in ("up", "down")}
for way, rows in ways.items():
    jump = rows["impacts_per_period"].ne(0.0).to_numpy()
    touching = rows["base.frequency"].to_numpy()[jump]
    print(f"on the way {way} it strikes from {touching.min():g} to {touching.max():g} Hz")
free = ways["down"][ways["down"]["impacts_per_period"] == 0.0]
apart = free["max:deflection"] / [swing(frequency) for frequency in free["base.frequency"]] - 1.0
print(f"without contact the swing is the closed form's, within {100.0 * apart.abs().max():.2f} %")

with figure_style():
    figure = Figure(figsize=(7.2, 6.0), layout="constrained")
    panels = figure.subplots(3, 1, sharex=True, gridspec_kw={"height_ratios": [1.4, 1.0, 1.0]})
    scales = {"max:deflection": 1e3, "max:bending_stress": 1e-6, "impacts_per_period": 1.0}
    names = "largest deflection\nof the tip (mm)", "largest bending\nstress (MPa)", "impacts\nper period"
    for axes, name, (column, scale) in zip(panels, names, scales.items(), strict=True):
        for (way, rows), colour, size in zip(ways.items(), SERIES[1::-1], (7.0, 4.0), strict=True):
            line = {"color": colour, "marker": "o", "ms": size, "lw": 0.7, "label": f"on the way {way}"}
            axes.plot(rows["base.frequency"], scale * rows[column], **line)
        axes.set(ylabel=name)
    frequencies = np.linspace(8.0, 16.5, 400)
    exact = np.array([swing(frequency) for frequency in frequencies])
    panels[0].plot(frequencies, 1e3 * exact, color=GREY, lw=0.9, ls="--", label="closed form without pegs")
    panels[0].set(ylim=(0.0, 2.4), xlim=(8.2, 16.3))
    panels[0].legend(loc="upper right")
    panels[-1].set(xlabel="frequency of the frame (Hz)", ylim=(-0.15, 2.6))
    figure.savefig("cantilever_2_response.svg")

# %%
# Refinement
# ----------
#
# The impulse of all contacts within 0.3 s, of the strip shaken twice as strongly, against 24 modes with events
# located: over the elements of the mesh, in steps of 2.5 µs, and over the steps, in 32 elements. The pegs stand at
# three quarters of the length, where every mesh has a node: a peg that pushes inside of an element of length h
# finds up to h³/(192 E I) too little compliance there. Elements are of fourth order, steps of second.

pegs = [peg.model_dump() | {"origin": (peg.origin[0], -0.75 * beam.length)} for peg in strip.obstacles]
struck = strip.replace(obstacles=pegs, base__acceleration=2.0, end_time=0.3, solver__contact_step=2.5e-6)
events = {"scheme": "event", "tolerance": 1e-10}
warnings.simplefilter("ignore", SimulationWarning)  # four elements are too few, which a run says


def in_modes(scenario, **discretization):
    """Return a scenario in modes, with events located."""
    data = scenario.model_dump(mode="json", exclude_unset=True)
    return Scenario.from_dict(data | {"discretization": discretization, "solver": events})


def impulse(scenario):
    """Return the impulse (N s) of all contacts."""
    return sum(contact.normal_impulse for contact in simulate(scenario).contacts)


limit = impulse(in_modes(struck, modes=24))
elements, steps = np.array([4, 8, 16]), 1e-4 * 2.0 ** np.arange(2, -3, -1)
fine = struck.replace(discretization__elements=32)
series = {
    "elements": (1.0 / elements, [struck.replace(discretization__elements=int(count)) for count in elements]),
    "steps": (steps, [fine.replace(solver__free_step=step, solver__contact_step=step) for step in steps]),
}
errors = {}
for name, (sizes, scenarios) in series.items():
    errors[name] = np.abs([impulse(scenario) / limit - 1.0 for scenario in scenarios])
    observed = np.diff(np.log(errors[name])) / np.diff(np.log(sizes))
    print(f"observed orders over the {name}:", *(f"{order:.2f}" for order in observed))

with figure_style():
    figure = Figure(figsize=(7.2, 3.2), layout="constrained")
    left, right = figure.subplots(1, 2, sharey=True)
    for axes, along, name, order in ((left, elements, "elements", -4), (right, 1e6 * steps, "steps", 2)):
        slope = errors[name][0] * (along / along[0]) ** order
        axes.loglog(along, errors[name], "o-", color=SERIES[0], lw=0.9)
        axes.loglog(along, slope, "--", color=GREY, lw=0.9, label=f"order {abs(order)}")
        axes.set_xticks(along, [f"{number:g}" for number in along])
        axes.minorticks_off()
        axes.legend()
    left.set(xlabel="elements", ylabel="relative error of the impulse")
    right.set(xlabel="step (µs)")
    figure.savefig("cantilever_3_refinement.svg")

# %%
# Modes, elements and nodes
# -------------------------
#
# When the contacts of the first 0.3 s begin, and their impulses: by assumed modes, by elements reduced to as many
# modes, and in all nodes.

begin = strip.replace(end_time=0.3, solver__contact_step=1e-5)
runs = {
    "eight assumed modes": in_modes(begin, modes=8),
    "24 elements, eight modes": in_modes(begin, method="fem", elements=24, modes=8),
    "24 elements, all nodes": begin,
}
for name, scenario in runs.items():
    contacts = simulate(scenario).contacts
    print(name.ljust(25), *(f"{1e3 * c.start:9.4f} ms {1e3 * c.normal_impulse:.4f} mN s" for c in contacts))

# %%
# Its film
# --------
#
# A tenth of a second, from peg to peg and back. From close by the strip and its pegs are seen at their true scale,
# with the force on the place that touches.

look = Style(size=(720, 560), ghosts=False)
render(history, "cantilever_4.gif", look, between=(1.86, 1.96), seconds=7.0, fps=12)
