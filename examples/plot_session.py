"""
A session of an hour
====================

From a scenario to a film, step by step. Each step names the page with more on it. It is a notebook as well,
``examples/session.ipynb``; in a terminal the steps are
``oblique-impact scenarios``, ``init``, ``run``, ``render``, ``refine``, ``compare``.

**Choose what to simulate.** The built-in cases:
"""

from pathlib import Path

from oblique_impact import Scenario, builtin_cases, natural_frequencies, simulate, start_scenario
from oblique_impact.renders import Style, render
from oblique_impact.validation import compare, refine

for case in builtin_cases():
    print(f"{case.name}, {case.end_time:g} s, {len(case.collisions)} collisions:")
    print(f"  {case.happens}")

# %%
# A file with every key, its meaning, unit and range, copied from one of them (an existing file is never
# replaced). Then an aluminium strip of 30 x 8 mm instead of the paper's rod, on an elastic stop. How to write a
# scenario: :doc:`/howto/scenario`.

work = Path("session")
if not (work / "mine.toml").exists():
    start_scenario(work / "mine.toml", "paper")
strip = Scenario.load(str(work / "mine.toml")).replace(
    beam__material="aluminium",
    beam__section__shape="rectangle",
    beam__section__width="30 mm",
    beam__section__height="8 mm",
    contact__normal="spring",
    contact__stiffness=2e5,
    contact__friction="frictionless",
    discretization__frame="mean-axis",
    discretization__modes=6,
    end_time=0.4,
)
print(natural_frequencies(strip, count=4).to_dict()["flapwise_hz"][0], "Hz")

# %%
# **Run it.** A history prints a summary and holds labelled arrays (xarray) and tables of events and contacts
# (pandas).

history = simulate(strip)
history.save(work / "modes")
print(history)
print(history.contact_table[["start", "end", "normal_impulse", "peak_force"]])

# %%
# **Look at it.** The overview first:

overview = history.plot()
overview.savefig("session_overview.svg")
overview

# %%
# A still at the largest force; ``show(history)`` opens a window to turn and zoom. Films and stills:
# :doc:`/howto/film`.

render(history, "session_still.png", Style(size=(960, 540)))

# %%
# The numbers at an instant; ``history.to_pyvista(t)`` gives the mesh with all results.

largest = float(history["lambda_n"].idxmax())
print(f"largest force at {largest:.5f} s:", float(history.at(largest)["lambda_n"]), "N")
mesh = history.to_pyvista(largest)
print("largest bending stress there:", round(float(abs(mesh["bending_stress"]).max()) / 1e6, 1), "MPa")

# %%
# **Refine.** Are six modes enough? Get a verdict, with its reason, before you quote a number; what converges and
# what does not: :doc:`/convergence`.

study = refine(strip, modes=[4, 8, 12, 16], quantities=["impulse", "peak_force"], workers=1)
for found in (study.quantity("impulse"), study.quantity("peak_force")):
    print(found.quantity.name, [round(value, 4) for value in found.values], found.analysis.words)

# %%
# **Compare.** The same strip on finite elements: other shape functions, the same answer. Events are aligned first.

elements = simulate(strip.replace(discretization__method="fem", discretization__elements=32))
found = compare(history, elements, names=("modes", "elements"))
print(*found.summary(), sep="\n")

# %%
# **Make a film**, here a small one of a few frames; ``work / "film.mp4"`` would be one for a talk, a ``.html`` a
# page to play with.

render(history, work / "film.gif", Style(size=(320, 180), charts=False), frames=6)
render(history, work / "page.html")
print(sorted(path.name for path in work.iterdir()))

# %%
# Bad input is refused in one line:

try:
    strip.replace(beam__material="aluminum")
except ValueError as error:
    print(error)
