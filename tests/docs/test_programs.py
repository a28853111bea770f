"""Programs of the documentation run: examples, the tutorial, the how-tos' code; the sketch shows its run."""

from __future__ import annotations

import json
import runpy
import shlex
import subprocess
from pathlib import Path

import numpy as np
import pytest

from docs.notebook import NOTEBOOK, notebook
from docs.pictures import sketch
from oblique_impact import Scenario
from oblique_impact.validation import fit
from oblique_impact.validation.checks import registry
from tests.docs.test_commands import DOCS, ROOT, blocks

EXAMPLES = sorted((ROOT / "examples").rglob("plot_*.py"))


@pytest.mark.slow  # the build of the documentation runs them too
@pytest.mark.parametrize("file", EXAMPLES, ids=lambda file: file.stem)
def test_example_runs_and_leaves_pictures(file, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    runpy.run_path(str(file), run_name="__main__")
    assert {path.suffix for path in tmp_path.iterdir()} & {".png", ".svg", ".gif"}


def test_the_demo_of_the_readme_runs(tmp_path):
    """With a film of two frames; the rest as `make demo`."""
    runpy.run_path(str(ROOT / "examples" / "paper_demo.py"))["main"](str(tmp_path), "2")
    assert {"modal", "fem", "compared.txt", "overview.png", "still.png", "paper.html", "paper.mp4"} == {
        path.name for path in tmp_path.iterdir()
    }


def fit_line(page: str) -> list[str]:
    """Words of the first line of a page that fits keys, before the folder of the report."""
    lines = (ROOT / page).read_text("utf-8").splitlines()
    return shlex.split(next(x for x in lines if x.startswith("oblique-impact fit ")).partition(" --out")[0])


@pytest.mark.parametrize("page", ["docs/howto/fit.md", "docs/what-it-can.md"])
def test_the_fit_of_the_pages_finds_what_its_data_were_made_with(page, monkeypatch):
    """As the data say, a damping of 2e-4 s and a stop of 2e4 N/m; from one start instead of four."""
    monkeypatch.chdir(ROOT)
    _, _, scenario, data, *options = fit_line(page)
    assert "kelvin_voigt = 2e-4 s and a stop of 2e4 N/m" in Path(data).read_text("utf-8")
    assert options[::2] == ["--vary", "--vary"]
    found = fit(Scenario.load(scenario), data, vary=options[1::2], starts=1)
    for key, true in {"beam.kelvin_voigt": 2e-4, "contact.stiffness": 2e4}.items():
        low, high = found[key][["low", "high"]]
        assert low < true < high < 2.0 * low


def test_the_fit_of_the_readme_needs_nothing_but_the_readme(tmp_path, monkeypatch):
    """Its data come from the line before; they are two frequencies of a strip of 200 GPa, rounded."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "out").mkdir()
    (line,) = (x for x in (ROOT / "README.md").read_text("utf-8").splitlines() if x.startswith("printf "))
    subprocess.run(["bash", "-c", line], check=True)
    _, _, scenario, data, *options = fit_line("README.md")
    assert options == ["--vary", "beam.youngs_modulus"]
    low, high = fit(Scenario.load(scenario), data, vary=options[1:], starts=1)[options[1]][["low", "high"]]
    assert low < 200e9 < high < 1.02 * low


HIGHEST = {"angle": 85, "friction": 1.0, "rigid": True, "stiffness": 1e7, "damping": 1e-4, "modes": 8}


def test_the_page_of_knobs_shows_the_run_that_its_knobs_ask_for():
    """As it opens it is the paper's case but for the frame; at the upper ends of all knobs it runs too."""
    pytest.importorskip("marimo")
    app = runpy.run_path(str(ROOT / "examples" / "explore.py"))["app"]
    outputs, names = app.run()
    assert names["history"].scenario == Scenario.builtin("paper").replace(discretization__frame="mean-axis")
    assert "<iframe" in outputs[-1].text
    _, names = app.run(defs={"settings": HIGHEST})
    scenario = names["history"].scenario
    assert scenario.initial.angle == pytest.approx(np.radians(85))
    assert scenario.contact.mu_static == scenario.contact.mu_kinetic == 1.0
    assert scenario.contact.normal == "rigid"
    assert (scenario.beam.kelvin_voigt, scenario.discretization.modes) == (1e-4, 8)
    assert names["history"].outcome.label == "completed"


def test_the_tutorial_runs_cell_by_cell(tmp_path, monkeypatch):
    kept = json.loads(NOTEBOOK.read_text(encoding="utf-8"))
    assert kept == notebook(), "python -m docs.notebook writes it anew"
    monkeypatch.chdir(tmp_path)
    names: dict = {"__name__": "__main__"}
    for cell in kept["cells"]:
        if cell["cell_type"] == "code":
            exec("".join(cell["source"]), names)
    assert names["history"].outcome.label == "completed"
    assert names["study"]["impulse"].verdict == "converged"


@pytest.mark.slow
def test_the_code_of_the_how_to_for_python_runs(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    names: dict = {}
    for block in blocks(DOCS / "howto" / "library.md", "python"):
        exec(block, names)
    assert len(names["results"].failed) == 0 < len(names["results"].frame)


def test_the_check_of_the_how_to_passes(monkeypatch):
    monkeypatch.setattr(registry, "_CHECKS", {})
    names: dict = {}
    exec(blocks(DOCS / "howto" / "check.md", "python")[0], names)
    assert names["hinged_frequency"]().verdict == "pass"


def turned(vector: np.ndarray, angle: float) -> np.ndarray:
    """Components of a vector along axes that are turned by an angle (rad)."""
    x = np.array([np.cos(angle), np.sin(angle)])
    return np.array([vector @ x, vector @ np.array([-x[1], x[0]])])


def arrows(axes) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Beginning and end (m) of the arrows that have a name."""
    return {
        patch.get_label(): tuple(map(np.asarray, patch._posA_posB))
        for patch in axes.patches
        if patch.get_label() and hasattr(patch, "_posA_posB")
    }


def test_the_sketch_of_the_theory_shows_signs_and_lengths_of_its_run():
    """Deflection, gap, slip and forces as the run says: a wrong sign there misleads every reader."""
    figure, history = sketch.sketch(), sketch.run()
    scenario = Scenario.from_toml(history.scenario_toml)
    alpha = scenario.slope.angle
    flight, contact = [history.at(time) for time in sketch.moments(history)]
    drawn = {name: end - start for name, (start, end) in arrows(figure.axes[0]).items()}
    assert turned(drawn["deflection"], float(flight["theta"])) == pytest.approx([0.0, float(flight["deflection"])])
    assert turned(drawn["gap"], alpha) == pytest.approx([0.0, float(flight["gap"])])
    assert turned(drawn["slip"], alpha) == pytest.approx([float(flight["slip"]), 0.0])
    drawn = {name: turned(end - start, alpha) for name, (start, end) in arrows(figure.axes[1]).items()}
    normal, tangential = drawn[r"$\lambda_n \geq 0$"], drawn[r"$\lambda_\tau$"]
    assert normal[1] > 0.0
    assert tangential[0] / normal[1] == pytest.approx(float(contact["lambda_tau"]) / float(contact["lambda_n"]))
    assert drawn["slip rate"][0] * float(contact["slip_rate"]) > 0.0
