"""
Two discretizations, one motion
===============================

The paper's beam by two clamped assumed modes, and by Hermite finite elements that are reduced to two of their
own modes. Both use the same contact, so they differ in the discretization only.
"""

from matplotlib.figure import Figure

from oblique_impact import Scenario, simulate
from oblique_impact.renders.style import GREY, SERIES, figure_style
from oblique_impact.validation import compare

scenario = Scenario.builtin("paper", ["end_time=0.335"])
modal = simulate(scenario)

# %%
# A comparison pairs the events of two histories, here the eight of the first macro-collision:

elements = [8, 16, 32, 64]
differences = []
for count in elements:
    fem = scenario.replace(discretization__method="fem", discretization__elements=count)
    found = compare(modal, simulate(fem), names=("modes", "elements"))
    differences.append(found.about["largest_shift"])
    events = len(found.tables["events"])
    print(f"{count:3d} elements: {events} events, largest difference of a time {differences[-1]:.2e} s")

# %%
# They approach each other with the fourth power of the element length, as the eigenfrequencies of cubic elements
# do. This compares the discretizations. It cannot show an error in what both share; closed forms and balances do.

with figure_style():
    figure = Figure(figsize=(5.6, 3.6), layout="constrained")
    axes = figure.subplots()
    axes.loglog(elements, differences, "o-", color=SERIES[0], label="finite elements against modes")
    fourth_order = [differences[0] * (elements[0] / count) ** 4 for count in elements]
    axes.loglog(elements, fourth_order, "--", color=GREY, label="fourth order")
    axes.set(xlabel="elements (1)", ylabel="largest difference of\nan event time (s)")
    axes.set_xticks(elements, [str(count) for count in elements])
    axes.minorticks_off()
    axes.legend()
    figure.savefig("two_discretizations.svg")
