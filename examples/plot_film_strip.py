"""
A strip of the first contacts
=============================

The beam before, during and after its first contacts, coloured by bending stress. Without given times the
strip chooses them by the events. The same from the command line:
``oblique-impact render out/paper --strip --out film_strip.png``.
"""

from oblique_impact import Scenario, simulate
from oblique_impact.renders import Style, render

history = simulate(Scenario.builtin("paper", ["end_time=0.4"]))
times = [0.3, 0.319, 0.3245, 0.345]  # s
render(history, "film_strip.png", Style(size=(1000, 160)), strip=True, times=times)

# %%
# The last row tells what the colours mean and by which factor the deflection is magnified.
