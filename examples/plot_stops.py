"""
A strip between stops
=====================

A clamped steel strip on a shaken base, 2 mm from one stop or between two: its steady response at 200 frequencies,
up and down, each from the state in which the one before has ended: the sweep ``docs/studies/stops.toml``, of
two minutes and a quarter on two cores. Columns of its table, results.parquet, are kept beside this page.
"""

from pathlib import Path

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from oblique_impact import renders
from oblique_impact.renders.style import GREY, SERIES, figure_style
from oblique_impact.validation import periodic_response
from oblique_impact.validation.studies.design import load_plan
from oblique_impact.validation.studies.maps import draw_responses

docs = Path(renders.__file__).parents[1] / "docs"
plan = load_plan(docs / "studies" / "stops.toml")
kept = pd.read_csv(docs / "stops.csv")
columns = {"one stop": kept[~kept["slope.enabled"]], "stops on both sides": kept[kept["slope.enabled"]]}

# %%
# Stops stiffen the strip: its resonance at 13.4 Hz leans to higher frequencies. On the way up the strip goes on
# striking until it falls off, at 18 Hz from one stop and at 22 Hz from two; on the way down it does not touch
# until 16 Hz. Between these jumps two motions exist side by side, and the larger one has up to 13 times the
# stress. A motion that takes several periods of the base has as many samples, one that does not repeat a cloud of
# them, and no period.

with figure_style():
    figure = Figure(figsize=(7.2, 7.2), layout="constrained")
    draw_responses(figure, plan, columns)
    figure.savefig("stops.svg")

# %%
# Between 15 and 16 Hz the strip between two stops loses its period: the tip in the phase plane over one period
# of the response, or over 32 of the base. Dots are whole periods of the base, the samples of the picture above.
# Those of 15.6 Hz lie on a closed curve: the motion is quasi-periodic, and at 15.2 Hz locked to three periods.

with figure_style():
    figure = Figure(figsize=(7.2, 2.8), layout="constrained")
    for axes, frequency in zip(figure.subplots(1, 3, sharey=True), (14.0, 15.2, 15.6), strict=True):
        scenario = plan.runs[-1].scenario.replace(base__frequency=frequency)
        history = periodic_response(scenario, settings=plan.file.periodic).histories["response"]
        found = history.summary["periodic"]
        whole = np.arange(found["measured"]) / frequency
        tip, velocity = (np.interp(whole, history["time"], history[name]) for name in ("tip_x", "tip_vx"))
        axes.plot(1e3 * history["tip_x"], history["tip_vx"], lw=0.5, color=SERIES[0])
        axes.plot(1e3 * tip, velocity, "o", ms=3.0, color=SERIES[1])
        axes.set(title=f"{frequency:g} Hz, period {found['period'] or 'none'}", xlabel="tip (mm)")
        for stop in (-2.0, 2.0):
            axes.axvline(stop, color=GREY, lw=0.6)
        axes.grid(visible=False)
    figure.axes[0].set(ylabel="velocity (m/s)")
    figure.savefig("stops_phase_plane.svg")
