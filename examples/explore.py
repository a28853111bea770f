"""
Turn knobs
==========

The paper's case as a notebook of marimo, with angle, friction, stop, damping and modes on sliders::

    pip install "oblique-impact[explore]"
    marimo run examples/explore.py

The page of the run is drawn anew when a knob is let go.
"""

import marimo

app = marimo.App(width="medium", app_title="A beam strikes a slope")

with app.setup:
    from pathlib import Path
    from tempfile import TemporaryDirectory

    import marimo as mo

    from oblique_impact import Scenario, simulate
    from oblique_impact.renders import render


@app.cell
def _():
    knobs = mo.ui.dictionary(
        {
            "angle": mo.ui.slider(30, 85, value=45, debounce=True, show_value=True, label="angle (°)"),
            "friction": mo.ui.slider(
                0.0, 1.0, 0.05, value=0.3, debounce=True, show_value=True, label="friction coefficient"
            ),
            "rigid": mo.ui.switch(value=True, label="rigid stop, or one of"),
            "stiffness": mo.ui.slider(
                steps=[1e4, 1e5, 1e6, 1e7], value=1e6, debounce=True, show_value=True, label="stiffness (N/m)"
            ),
            "damping": mo.ui.slider(
                steps=[0.0, 1e-6, 1e-5, 1e-4], debounce=True, show_value=True, label="Kelvin-Voigt damping (s)"
            ),
            "modes": mo.ui.slider(1, 8, value=2, debounce=True, show_value=True, label="modes"),
        }
    )
    return (knobs,)


@app.cell
def _(knobs):
    settings = knobs.value
    return (settings,)


@app.cell
def _(settings):
    stop = {"rigid": {}, "spring": {"contact__stiffness": settings["stiffness"]}}
    normal = "rigid" if settings["rigid"] else "spring"
    scenario = Scenario.builtin("paper").replace(
        initial__angle=f"{settings['angle']} deg",
        contact__mu_static=settings["friction"],
        contact__mu_kinetic=settings["friction"],
        contact__normal=normal,
        **stop[normal],
        beam__kelvin_voigt=settings["damping"],
        discretization__frame="mean-axis",  # the tangent frame is good for four modes at most
        discretization__modes=settings["modes"],
    )
    history = simulate(scenario)
    return (history,)


@app.cell
def _(history, knobs):
    with TemporaryDirectory() as folder:
        page = render(history, Path(folder) / "run.html").file.read_text(encoding="utf-8")
    mo.vstack([mo.hstack(knobs.values(), wrap=True, justify="start"), mo.iframe(page, height="900px")])
    return (page,)


if __name__ == "__main__":
    app.run()
