"""The pictures of the pages: right by the numbers of the runs that they show, current, legible on both papers."""

from __future__ import annotations

import ast
import re
import shutil
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

from docs.pictures import contacts, draw, mechanics, sketch
from docs.pictures.paper import FOLDER
from oblique_impact import Scenario
from oblique_impact.contact.state import State
from oblique_impact.renders.style import DARK

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
PAGES = [page for folder in ("theory", "howto") for page in sorted((DOCS / folder).glob("*.md"))]


@pytest.fixture(scope="module")
def sketched():
    """The drawn sketch, and the runs' numbers at its two times."""
    figure, history = sketch.sketch(), sketch.run()
    return figure, [history.at(time) for time in sketch.moments(history)]


def arrows(axes) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Beginning and end (m) of the arrows that have a name."""
    return {
        patch.get_label(): tuple(map(np.asarray, patch._posA_posB))
        for patch in axes.patches
        if patch.get_label() and hasattr(patch, "_posA_posB")
    }


def turned(vector, angle: float) -> np.ndarray:
    """Components of a vector along axes that are turned by an angle (rad)."""
    x = np.array([np.cos(angle), np.sin(angle)])
    return np.array([vector @ x, vector @ np.array([-x[1], x[0]])])


def test_the_sketch_is_right_by_the_numbers_of_its_run(sketched):
    figure, (now, _) = sketched
    axes, scenario = figure.axes[0], Scenario.from_toml(sketch.run().scenario_toml)
    drawn = arrows(axes)
    theta, alpha = float(now["theta"]), scenario.slope.angle
    start, end = drawn["deflection"]
    assert turned(end - start, theta) == pytest.approx([0.0, float(now["deflection"])], abs=1e-12)
    assert turned(end, theta)[0] == pytest.approx(scenario.beam.length + float(now["shortening"]), abs=1e-12)
    assert end == pytest.approx([float(now["tip_x"]), float(now["tip_y"])])
    start, end = drawn["gap"]
    assert turned(end - start, alpha) == pytest.approx([0.0, float(now["gap"])], abs=1e-12)
    start, end = drawn["slip"]
    assert turned(end - start, alpha) == pytest.approx([float(now["slip"]), 0.0], abs=1e-12)
    # a dimension beside its line
    assert turned(start - np.array(scenario.slope.origin), alpha)[0] == pytest.approx(0.0, abs=1e-12)
    assert turned(np.subtract(*drawn["gravity"]), 0.0)[1] > 0.0
    (beam,) = [line for line in axes.lines if line.get_label() == "beam"]
    assert np.stack(beam.get_data(), axis=1)[[0, -1]] == pytest.approx(
        np.array([[0.0, 0.0], drawn["deflection"][1]])
    )
    # what the labels say of the signs
    words = {text.get_text() for text in axes.texts}
    assert {"$u_y > 0$", "$Z_n > 0$"} <= words
    assert float(now["deflection"]) > 0.05
    assert float(now["gap"]) > 0.1


def test_forces_of_the_sketch_act_on_the_beam_as_the_run_says(sketched):
    figure, (_, now) = sketched
    axes, alpha = figure.axes[1], Scenario.from_toml(sketch.run().scenario_toml).slope.angle
    drawn = {name: turned(end - start, alpha) for name, (start, end) in arrows(axes).items()}
    normal, tangential = float(now["lambda_n"]), float(now["lambda_tau"])
    assert State(int(now["state"])) is State.SLIP
    scale = drawn[r"$\lambda_n \geq 0$"][1] / normal
    assert scale > 0.0
    assert drawn[r"$\lambda_n \geq 0$"][0] == pytest.approx(0.0, abs=1e-12)
    assert drawn[r"$\lambda_\tau$"] == pytest.approx([scale * tangential, 0.0], abs=1e-12)
    assert drawn["slip rate"][0] * float(now["slip_rate"]) > 0.0
    assert tangential * float(now["slip_rate"]) < 0.0
    (sign,) = [text.get_text()[-4:-1] for text in axes.texts if "dot" in text.get_text()]
    assert sign == ("< 0" if float(now["slip_rate"]) < 0.0 else "> 0")


def test_the_diagram_of_states_shows_what_runs_do(run):
    """Every event of four runs is an arrow, and each arrow stands in the picture."""
    seen = set()
    for name in ("paper", "sticking", "bouncing", "elastic-stop"):
        before = State.FREE
        for event in run(name).events:
            seen.add((before, event.kind, event.state))
            before = event.state
    assert seen <= contacts.EDGES
    assert len(seen) >= 5
    between = {(before, after): kind.value for before, kind, after in contacts.EDGES if before != after}
    assert between == {states: text.partition("\n")[0] for states, (_, text, _) in contacts._ARROWS.items()}


def test_the_scheme_of_the_picture_has_the_limits_that_it_is_made_for():
    for rho in (0.0, 0.5, 0.8, 1.0):
        assert contacts.spectral_radius(rho, 1e-3) == pytest.approx(1.0, abs=1e-8)
        # a threefold eigenvalue is known to the third root of rounding
        assert contacts.spectral_radius(rho, 1e9) == pytest.approx(rho, abs=1e-5)


def test_the_law_of_the_touch_down_is_that_of_its_check():
    """2 Z v0 sqrt(t/pi), 1.0087 times as large where the slope is inclined as the paper's."""
    history = mechanics.paper("contact.friction=frictionless")
    speed = -history.events[0].normal_velocity
    impedance = (68.952e9 * 7.85e-9) ** 0.25 * (2766.7 * 3.14e-4) ** 0.75 / np.sqrt(2.0)
    (found,) = contacts.touch_down_law(history, np.array([1e-3]))
    assert found / (2.0 * impedance * speed * np.sqrt(1e-3 / np.pi)) == pytest.approx(1.0087, abs=5e-5)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: f"{page.parent.name}-{page.stem}")
def test_every_page_of_theory_and_how_tos_has_a_picture(page):
    if page == DOCS / "howto" / "index.md":  # a list of the others
        return
    text = page.read_text(encoding="utf-8")
    pictures = re.findall(r"!\[([^\]]+)\]\(([^)]+)\)", text)
    assert pictures or "```{player}" in text
    for text, file in pictures:
        assert len(text) > 30, f"{file}: what those read who do not see it"
        assert (page.parent / file).is_file()


def test_every_committed_picture_is_drawn_here_and_shown():
    files = {file.stem.removesuffix("-dark") for file in FOLDER.iterdir() if file.suffix in (".svg", ".png")}
    assert files == {*draw.DRAWINGS, *draw.SCENES}
    text = "".join(page.read_text(encoding="utf-8") for page in DOCS.rglob("*.md"))
    shown = set(re.findall(r"pictures/([\w-]+)\.(?:svg|png)", text))
    assert shown == files


def vertices(drawing: str) -> list[np.ndarray]:
    """Corners of the paths of a drawing, in the order of the file."""
    return [
        np.array(re.findall(r"(-?[\d.e-]+) (-?[\d.e-]+)", path), dtype=float).reshape(-1, 2)
        for path in re.findall(r'<path[^>]* d="([^"]+)"', drawing)
    ]


def distance(points: np.ndarray, line: np.ndarray) -> float:
    """Largest distance of points from a line through corners: its corners may be others, its course may not."""
    first, along = line[:-1, None], np.diff(line, axis=0)[:, None]
    length = np.maximum(np.sum(along**2, axis=-1), 1e-30)
    part = np.clip(np.sum((points - first) * along, axis=-1) / length, 0.0, 1.0)
    return float(np.max(np.min(np.linalg.norm(points - first - part[..., None] * along, axis=-1), axis=0)))


def difference(one: str, other: str) -> float:
    """How far (points of the page) two drawings are apart; infinite if they are not of the same parts."""
    left, right = vertices(one), vertices(other)
    if len(left) != len(right):
        return np.inf
    both = [(a, b) for a, b in zip(left, right, strict=True) if len(a) > 1 and len(b) > 1]
    return max(max(distance(a, b), distance(b, a)) for a, b in both)


QUICK = ("sketch", "kinematics")


@pytest.mark.parametrize(
    "name", [pytest.param(n, marks=() if n in QUICK else pytest.mark.slow) for n in draw.DRAWINGS]
)
def test_a_committed_drawing_is_what_is_drawn_now(name, tmp_path):
    """Else: python -m docs.pictures.draw NAME."""
    (file,) = draw.draw(name, tmp_path)
    found = difference((FOLDER / file.name).read_text(encoding="utf-8"), file.read_text(encoding="utf-8"))
    assert found < 0.5, f"{name}: {found:.2g} points"


def test_a_line_that_is_drawn_elsewhere_is_noticed():
    drawing = (FOLDER / "kinematics.svg").read_text(encoding="utf-8")
    path = max(re.findall(r' d="([^"]+)"', drawing), key=len)
    number = re.findall(r"-?\d+\.\d+", path)[7]
    moved = drawing.replace(path, path.replace(number, f"{float(number) + 3.0:.6f}"))
    assert moved != drawing
    assert difference(drawing, drawing) == 0.0
    assert difference(drawing, moved) > 0.5


@pytest.mark.slow
@pytest.mark.parametrize("name", draw.SCENES)
def test_scenes_can_be_drawn(name, tmp_path):
    if name == "paraview" and not (shutil.which("pvpython") and shutil.which("xvfb-run")):
        pytest.skip("there is no ParaView (Debian: python3-paraview, xvfb)")
    assert [file.name for file in draw.draw(name, tmp_path)] == [f"{name}.png", f"{name}-dark.png"]


def luminance(colour: str) -> float:
    """Relative luminance of #rrggbb (WCAG 2)."""
    parts = np.array([int(colour[k : k + 2], 16) for k in (1, 3, 5)]) / 255.0
    linear = np.where(parts <= 0.04045, parts / 12.92, ((parts + 0.055) / 1.055) ** 2.4)
    return float(linear @ [0.2126, 0.7152, 0.0722])


def contrast(one: str, other: str) -> float:
    high, low = sorted((luminance(one), luminance(other)), reverse=True)
    return (high + 0.05) / (low + 0.05)


@pytest.fixture
def themes(monkeypatch):
    monkeypatch.syspath_prepend(str(DOCS / "_ext"))
    return import_module("two_themes")


def drawings() -> list[Path]:
    return [*sorted(DOCS.glob("*.svg")), *sorted(FOLDER.glob("*.svg"))]


@pytest.mark.parametrize("file", [f for f in drawings() if not f.stem.endswith("-dark")], ids=lambda f: f.stem)
def test_the_dark_twin_of_a_drawing_can_be_read(themes, file):
    """Each colour has its dark one, and what is ink stands out from the paper as it did in the light."""
    text = file.read_text(encoding="utf-8")
    used = {colour.lower() for colour in re.findall(r"(?:fill|stroke): (#[0-9a-fA-F]{6})", text)}
    table = themes.colours()
    assert used <= set(table)
    faint = {"#ffffff", *(colour for colour in used if contrast(colour, "#ffffff") < 3.0)}
    for colour in used - faint:
        assert contrast(table[colour], DARK.background) > 3.0, colour
    dark = themes.darken(text)
    assert not used & set(re.findall(r"(?:fill|stroke): (#[0-9a-fA-F]{6})", dark)) - set(table.values())
    assert f'<svg fill="{DARK.ink}" ' in dark  # letters that have no colour


def test_a_picture_in_pixels_has_its_twin(themes, tmp_path):
    for file in FOLDER.glob("*.png"):
        if not file.stem.endswith("-dark"):
            assert themes.make_twin(file) == themes.twin_of(file)
    alone = tmp_path / "alone.png"
    shutil.copy(FOLDER / "film.png", alone)
    assert themes.make_twin(alone) is None


def imports(code: str) -> set[str]:
    """Names that a program takes from the packages of this project."""
    found = set()
    for node in ast.walk(ast.parse(code)):
        if isinstance(node, ast.ImportFrom) and node.module.partition(".")[0] == "oblique_impact":
            found |= {f"{node.module}.{alias.name}" for alias in node.names}
    return found


def test_the_gallery_uses_the_calls_that_the_how_tos_use():
    """What an example imports stands in the code of a how-to, or is a link in its text."""
    told, linked = set(), set()
    for page in [*(DOCS / "howto").glob("*.md"), DOCS / "first-run.md"]:
        text = page.read_text(encoding="utf-8")
        for block in re.findall(r"^```python\n(.*?)^```", text, re.DOTALL | re.MULTILINE):
            told |= imports(block)
        linked |= {name.rpartition(".")[2] for name in re.findall(r"{py:\w+}`~([\w.]+)`", text)}
    for file in sorted((ROOT / "examples").glob("plot_*.py")):
        missing = imports(file.read_text(encoding="utf-8")) - told
        assert {name.rpartition(".")[2] for name in missing} <= linked, file.name
