r"""
A ruler on a shaker
===================

A steel ruler stands clamped on a base that is shaken across it; 200 mm of it are free, and 20 mm below its tip
a stop stands 2 mm beside its face. As the frequency of the base grows past the ruler's own, the ruler strikes
the stop and goes on striking it, well beyond the frequency at which it would have come to rest; as the
frequency falls again the ruler passes the stop by until it suddenly strikes. Between these two *jumps* two
motions exist, and which of them one sees depends on where one comes from.

By hand, for a ruler of the bending stiffness :math:`E I` and the mass :math:`m` per length, with
:math:`\beta L = 1.8751` of the first mode of a cantilever:

* its first frequency, :math:`f_1 = (\beta L)^2/(2 \pi)\, \sqrt{E I/(m L^4)}`. Standing it carries its own
  weight, which takes away its stiffness as far as it is near the weight under which it would buckle by itself,
  :math:`7.837\, E I/L^2`;
* its static stiffness where the stop is, :math:`3 E I/a^3`;
* the frequencies at which it begins to strike. The steady swing of the first mode under the acceleration
  :math:`A \sin \omega t` is :math:`\Gamma \phi(a) A/|\omega_1^2 - \omega^2|`, with the part :math:`\Gamma
  \phi(L)` = 1.566 of the acceleration at the tip. It is as wide as the gap at :math:`\omega^2 = \omega_1^2 \mp
  \Gamma \phi(a) A/\mathrm{gap}`. Up to the lower of the two the ruler is free on the way up, down to the upper
  one on the way down.
"""

import tempfile

import numpy as np
from matplotlib.figure import Figure

from oblique_impact import Scenario, frequencies_at_rest, simulate
from oblique_impact.renders import Style, render
from oblique_impact.renders.style import SERIES, figure_style
from oblique_impact.validation import AxisSection, PeriodicSection, SweepFile, periodic_response, sweep

ruler = Scenario.from_toml(
    """
    beam.length = "200 mm"
    beam.material = "steel"
    beam.kelvin_voigt = 8e-5  # s, 0.5 % of critical
    beam.section = { shape = "rectangle", width = "25 mm", height = "1 mm" }
    root.kind = "driven"      # held
    initial.angle = "90 deg"  # it stands
    base = { acceleration = 1.0, frequency = "22 Hz", direction = 0.0 }
    slope.enabled = false
    contact = { where = "anywhere", normal = "spring", stiffness = 1e4, friction = "frictionless" }
    obstacles = [{ kind = "point", origin = ["2 mm", "180 mm"] }]
    discretization.modes = 4
    """
)
beam, gap, place = ruler.beam, 2e-3, 0.18
bending, mass = beam.youngs_modulus * beam.second_moment, beam.density * beam.area

# %%
# The first frequency, from the vibrations about the ruler's rest, and the stiffness, from a ruler that is held
# away from the stop by a force.

weight = mass * beam.length * ruler.gravity
hand = 3.5160 / (2.0 * np.pi) * np.sqrt(bending / (mass * beam.length**4))
hand *= np.sqrt(1.0 - weight * beam.length**2 / (7.837 * bending))
first = float(frequencies_at_rest(ruler, 1).frequencies[0]) / (2.0 * np.pi)
pull = 0.1  # N
held = {"initial__state": "plucked", "initial__place": place, "initial__force": pull}
pulled = simulate(ruler.replace(end_time=1e-3, base={}, **held))
sag = float(np.interp(place, pulled["station"], pulled["uy"][0]))
print(f"first frequency: {first:.3f} Hz, by hand {hand:.3f} Hz")
print(f"stiffness at the stop: {pull / sag:.1f} N/m, by hand {3.0 * bending / place**3:.1f} N/m")
assert abs(first / hand - 1.0) < 1e-3
assert abs(pull / sag / (3.0 * bending / place**3) - 1.0) < 0.01

# %%
# Up and down
# -----------
#
# The steady response at each frequency, from the state in which the one before has ended: ``oblique-impact sweep``
# does the same with a file (:doc:`/howto/cluster`). It brackets the jumps itself.

axis = AxisSection(key="base.frequency", range=[20.0, 25.0], count=11)
settings = PeriodicSection(tolerance=1e-4, transient=160)
wanted = ["max:deflection", "peak:bending_stress", "impacts_per_period", "period"]
with tempfile.TemporaryDirectory() as folder:
    result = sweep(SweepFile(axes=[axis], quantities=wanted, periodic=settings), folder, base=ruler, workers=1)
ways = {way: rows.sort_values("base.frequency") for way, rows in result.frame.groupby("direction")}
jumps = result.tables["jumps"].set_index("direction")

shape = 0.8624  # of the first mode at the stop, over that at the tip
edges = [np.sqrt((2 * np.pi * hand) ** 2 + sign * 1.566 * shape * 1.0 / gap) / (2 * np.pi) for sign in (-1.0, 1.0)]
touching = {way: rows["base.frequency"][rows["impacts_per_period"] > 0.0] for way, rows in ways.items()}
falls, strikes = (float(jumps.loc[way, "last before"]) for way in ("up", "down"))
print(f"way up: it strikes from {touching['up'].min():g} Hz, by hand from {edges[0]:.2f} Hz, to {falls:.2f} Hz")
print(f"way down: it strikes from {strikes:.2f} Hz, by hand from {edges[1]:.2f} Hz")
assert 0.0 <= touching["up"].min() - edges[0] <= 0.5
assert abs(strikes / edges[1] - 1.0) < 2e-3
assert falls > 1.1 * strikes
assert (result.frame["period"] == 1.0).all()

with figure_style():
    figure = Figure(figsize=(7.2, 4.6), layout="constrained")
    swing, stress = figure.subplots(2, 1, sharex=True)
    names = {"max:deflection": (swing, 1e3, "swing of the tip\naway from the stop (mm)")}
    names["peak:bending_stress"] = stress, 1e-6, "largest bending\nstress (MPa)"
    for column, (axes, scale, label) in names.items():
        for way, colour, size in (("down", SERIES[0], 7.0), ("up", SERIES[1], 4.0)):
            rows = ways[way]
            look = {"color": colour, "marker": "o", "ms": size, "lw": 0.8, "label": f"on the way {way}"}
            axes.plot(rows["base.frequency"], scale * rows[column], **look)
        axes.set(ylabel=label, ylim=(0.0, None))
        for edge in edges:
            axes.axvline(edge, color="0.6", lw=0.8, ls="--")
    swing.legend(loc="lower left")
    for edge, way, side in zip(edges, ("up", "down"), ("right", "left"), strict=True):
        stress.text(edge, 1.0, f" by hand,\n way {way} ", ha=side, va="bottom", size="small", color="0.4")
    stress.set(xlabel="frequency of the base (Hz)")
    figure.savefig("ruler_1_response.svg")

# %%
# At 24 Hz the ruler strikes once in each period if it was striking before, and does not touch the stop if it comes
# from rest.

striking = None
for frequency in (21.0, 22.0, 23.0, 24.0):
    shaken = ruler.replace(base__frequency=frequency)
    striking = periodic_response(shaken, striking, settings).histories["response"]
passing = periodic_response(ruler.replace(base__frequency=24.0), settings=settings).histories["response"]
assert len(striking.contacts) == 1
assert not passing.contacts

with figure_style():
    figure = Figure(figsize=(7.2, 2.8), layout="constrained")
    axes = figure.subplots()
    for name, history, colour in (("it strikes", striking, SERIES[1]), ("it passes by", passing, SERIES[0])):
        at_stop = [np.interp(place, history["station"], -row) for row in history["uy"].values]
        axes.plot(24.0 * history["time"], 1e3 * np.array(at_stop), color=colour, label=name)
    axes.axhline(1e3 * gap, color="0.6", lw=0.8, ls="--", label="stop")
    axes.set(xlabel="time (periods of the base)", ylabel="deflection at\nthe stop (mm)", ylim=(-2.8, 3.4))
    axes.legend(loc="upper center", ncols=3)
    figure.savefig("ruler_2_two_motions.svg")

look = Style(size=(720, 420), charts=False)
render(striking, "ruler_3.png", look, time=float(striking["time"][striking["lambda_n"].values.argmax()]))
