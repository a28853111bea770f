"""The documentation: complete references, examples that run, a build without a warning and without network."""

from __future__ import annotations

import ast
import json
import math
import re
import runpy
import subprocess
import sys
import tomllib
from importlib import import_module
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from oblique_impact import Scenario, simulate, simulate_system
from oblique_impact.scenario.rules import RULES
from oblique_impact.scenario.schema import key_schemas
from oblique_impact.validation.checks import registry

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"


@pytest.fixture
def extension(monkeypatch):
    """Import an extension of the documentation by name."""
    monkeypatch.syspath_prepend(str(DOCS / "_ext"))
    return import_module


def test_reference_page_has_every_key_and_every_rule(extension):
    page = extension("scenario_keys").reference()
    for path in key_schemas():
        assert f"``{path.rpartition('.')[2]}``" in page, path
    for row in [
        ["``density``", "kg/m³", "number, > 0", "``2766.7``", "mass per volume"],
        ["``mu_static``", "1", "number, ≥ 0", "``0.3``", "static coefficient of friction"],
        ["``modes``", "1", "whole number, ≥ 0, ≤ 100", "``2``"],
        ["``enabled``", "–", "``true``, ``false``", "``true``", "whether the slope is there at all"],
        ["``point``", "m", "number, > 0", "not given"],
        ["``method``", "–", '``"absolute"``, ``"fem"``, ``"modal"``', '``"modal"``'],
        ["``root.inertia``, ``root.torque``", 'only with root.kind = "hub" (it is "…")'],
        ["``beam.modal_damping_ratio``", r"the full nodal model has no modes to damp; use beam.kelvin\_voigt"],
    ]:
        assert "   * - " + "\n     - ".join(row) in page, row
    assert page.count("   * - ") == page.count(":header-rows: 1") + len(key_schemas()) + len(RULES)


def test_command_line_reference_has_every_command_and_option(extension):
    module = extension("command_line")
    page = module.reference()
    help_text = subprocess.run(
        [sys.executable, "-m", "oblique_impact", "--help"],
        capture_output=True,
        text=True,
        check=True,
    ).stdout
    commands = re.findall(r"^  ([a-z]+)  ", help_text.partition("Commands:")[2], re.MULTILINE)
    assert {"run", "render", "export"} <= set(commands)
    for command in commands:
        _, _, section = page.partition(f".. program:: oblique-impact {command}\n")
        section = section.partition(".. program::")[0]
        assert section, command
        for parameter in module.commands()[command].params:
            for option in parameter.opts:
                shown = option if option.startswith("-") else (parameter.metavar or option.upper())
                assert re.search(rf"^\.\. option:: .*{re.escape(shown)}", section, re.MULTILINE), (command, option)
            assert " ".join((parameter.help or "").split())[:20].replace("_", r"\_") in section


def test_every_displayed_equation_of_the_theory_names_its_code():
    """Displayed formulas are `equation` directives, which refuse to be without code; none stands outside."""
    pages = sorted((DOCS / "theory").glob("*.md"))
    texts = [page.read_text(encoding="utf-8") for page in pages]
    assert sum(text.count("```{equation}") for text in texts) > 70
    for page, text in zip(pages, texts, strict=True):
        assert "$$" not in text, page
        assert "```{math}" not in text, page
        assert text.count("```{equation}") == len(re.findall(r"```{equation}\n:label: .+\n:code: .+\n", text)), (
            page
        )


def test_docstrings_keep_their_formulas(extension):
    lines = ["Title |x|.", "", "    |a| <= b", "", "Then `|c|` and |d|.", "", "a : int", "    text |e|"]
    extension("docstrings").prepare(None, "function", "f", None, None, lines)
    assert lines[:5] == [r"Title \|x\|.", "", "::", "", "    |a| <= b"]
    assert lines[6] == r"Then `|c|` and \|d\|."
    assert lines[-1] == r"    text \|e\|"


def examples() -> list[Path]:
    return sorted((ROOT / "examples").glob("plot_*.py"))


@pytest.mark.slow  # the build of the documentation runs them too
@pytest.mark.parametrize("file", examples(), ids=lambda file: file.stem)
def test_example_runs(file, tmp_path, monkeypatch):
    """An example is a script: started in a folder it leaves its pictures there, and nothing else."""
    monkeypatch.chdir(tmp_path)
    runpy.run_path(str(file), run_name="__main__")
    written = list(tmp_path.iterdir())
    assert written
    for picture in written:
        if picture.name == "session":  # the folder that the tutorial works in
            continue
        assert picture.suffix in (".png", ".svg")
        assert picture.stat().st_size > 10_000


def test_the_tutorial_is_a_notebook_whose_cells_run(tmp_path, monkeypatch, capsys):
    """The notebook that is kept, cell by cell in an empty folder, as Jupyter would; it is the program's."""
    from docs.notebook import NOTEBOOK, notebook

    kept = json.loads(NOTEBOOK.read_text(encoding="utf-8"))
    assert kept == notebook(), "python -m docs.notebook writes it anew"
    cells = ["".join(cell["source"]) for cell in kept["cells"] if cell["cell_type"] == "code"]
    assert len(cells) > 8
    monkeypatch.chdir(tmp_path)
    names: dict = {"__name__": "__main__"}
    for cell in cells:
        exec(cell, names)
    # what a cell ends with is what Jupyter shows
    shown = [eval(cell.strip().splitlines()[-1], names) for cell in cells[3:5]]
    assert shown[0]._repr_png_().startswith(b"\x89PNG")
    assert "data:image/png" in shown[1]._repr_html_()
    assert repr(names["study"]).splitlines()[1:] == [
        f"  {name}: {names['study'].quantity(name).analysis.words}" for name in ("impulse", "peak_force")
    ]
    said = capsys.readouterr().out
    assert "paper, 1 s, 3 collisions:\n" in said
    assert names["history"].outcome.label == "completed"
    assert names["study"].quantity("impulse").analysis.verdict == "converged"
    assert names["found"].largest_shift < 1e-5
    assert said.splitlines()[-1].startswith("beam.material = 'aluminum': should be")
    assert said.splitlines()[-1].endswith("did you mean 'aluminium'?")
    assert {"session_overview.svg", "session_still.png", "session"} == {path.name for path in tmp_path.iterdir()}
    # a second time in the same folder
    for cell in cells[:3]:
        exec(cell, names)


def test_gallery_takes_every_example_in_the_order_of_reading(extension):
    """Each has a title and a text; the order names none that is missing and misses none."""
    for file in examples():
        docstring = ast.get_docstring(ast.parse(file.read_text(encoding="utf-8"))) or ""
        title, rule, _, text, *_ = docstring.split("\n")
        assert rule == "=" * len(title), file
        assert len(text) > 40, file
    pictures = extension("pictures")
    names = sorted(examples(), key=lambda file: pictures.place(file.name))
    assert tuple(file.stem.removeprefix("plot_") for file in names) == pictures.ORDER


def test_gallery_moves_the_pictures_of_a_block(extension, tmp_path):
    (tmp_path / "examples").mkdir()
    (tmp_path / "examples" / "one.png").write_bytes(b"picture")
    (tmp_path / "examples" / "one-dark.png").write_bytes(b"at night")
    (tmp_path / "examples" / "two.svg").write_bytes(b"drawing")
    targets = iter([tmp_path / "gallery_001.png", tmp_path / "gallery_002.png"])
    block_vars = {"src_file": tmp_path / "examples" / "plot_one.py", "image_path_iterator": targets}
    markup = extension("pictures").scrape(None, block_vars, {"src_dir": str(tmp_path)})
    assert re.findall(r"image:: (\S+)", markup) == ["/gallery_001.png", "/gallery_002.svg"]
    assert (tmp_path / "gallery_001.png").read_bytes() == b"picture"
    assert (tmp_path / "gallery_001-dark.png").read_bytes() == b"at night"
    assert (tmp_path / "gallery_002.svg").read_bytes() == b"drawing"
    assert not [file for file in (tmp_path / "examples").iterdir() if file.suffix != ".py"]


def test_the_example_that_changes_something_changes_what_the_page_says(run):
    page = (DOCS / "first-run.md").read_text(encoding="utf-8")
    (command,) = re.findall(r"^oblique-impact run paper (--set .*) --out", page, re.MULTILINE)
    changes = re.findall(r"--set (\S+)", command)
    (python,) = re.findall(r'Scenario\.builtin\("paper", (\[.*?\])\)', page)
    assert ast.literal_eval(python) == changes
    plain, changed = (run("paper", *keys).summary["macro_collisions"] for keys in ((), changes))
    impulses = [collisions[0]["normal_impulse"] for collisions in (changed, plain)]
    thirds = [collisions[2]["start"] for collisions in (changed, plain)]
    said = " ".join(page.split())
    assert "({:.3f} instead of {:.3f} N s)".format(*impulses) in said
    assert "comes at {:.3f} s instead of {:.3f} s".format(*thirds) in said
    assert impulses[0] != pytest.approx(impulses[1], rel=5e-4)


def blocks(page: str, language: str) -> list[str]:
    text = (DOCS / page).read_text(encoding="utf-8")
    return re.findall(rf"^```{language}\n(.*?)^```", text, re.DOTALL | re.MULTILINE)


def test_scenarios_of_the_how_to_are_valid():
    complete, texts, with_schema, words, tables, _ = blocks("howto/scenario.md", "toml")
    tapered = Scenario.from_toml(words)
    assert (tapered.beam.density, tapered.beam.outer_fibre) == (2700.0, ((0.0, 0.015), (1.0, 0.006)))
    assert Scenario.from_toml(complete).contact.point == 0.4
    assert Scenario.from_toml(with_schema).end_time == 0.8
    units = Scenario.from_toml(texts)
    assert (units.beam.length, units.beam.density, units.beam.youngs_modulus) == (0.8, 7850.0, 2.1e11)
    assert (units.slope.origin, units.slope.angle) == ((0.25, 0.0), math.pi / 10)
    varying = Scenario.from_toml(tables, ["discretization.method=fem"])
    assert varying.beam.tip_mass == 0.05


def test_parts_of_the_how_to_run_and_the_law_sticks_until_the_spring_is_strong_enough(tmp_path, monkeypatch):
    names: dict = {}
    contact_law, friction, on_belt, integrator = blocks("howto/own-parts.md", "python")
    assert "simulate_system" in on_belt
    for block in (contact_law, friction, integrator):
        exec(block, names)
    assert names["history"].summary["energy"]["lost_damping"] > 0.1
    base = Scenario.builtin("paper").replace(end_time=0.01)
    exact = float(simulate(base)["theta"][-1])
    assert float(simulate(base.replace(solver__scheme="heun"))["theta"][-1]) == pytest.approx(exact, abs=1e-5)
    entry_point, scenario = map(tomllib.loads, blocks("howto/own-parts.md", "toml"))
    assert "oblique_impact.contact_laws" in entry_point["project"]["entry-points"]
    assert Scenario.from_dict(scenario).part("normal") == names["Hertz"](1e8, 0.2)
    law = names["ViscousCoulomb"]()
    forwards, backwards = law.branch(0.1, 1), law.branch(-0.1, -1)
    assert forwards.intercept + forwards.slope * 0.1 == pytest.approx(-(0.3 + 0.05 * 0.1))
    assert backwards.intercept - backwards.slope * 0.1 == pytest.approx(0.3 + 0.05 * 0.1)
    monkeypatch.chdir(tmp_path)
    belt = SimpleNamespace(**runpy.run_path(str(ROOT / "examples" / "plot_own_system.py")))
    start = np.zeros(2), np.array([belt.BELT, 0.0])
    history = simulate_system(belt.MassOnBelt(), *start, end_time=1.0, friction=law)
    breaks = [event.time for event in history.events if event.kind.value == "slip"]
    assert breaks[0] == pytest.approx(0.3 * belt.MASS * belt.GRAVITY / belt.SPRING / belt.BELT, abs=1e-9)


def test_check_of_the_how_to_passes(monkeypatch):
    monkeypatch.setattr(registry, "_CHECKS", {})
    names: dict = {}
    exec(blocks("howto/check.md", "python")[0], names)
    assert list(registry._CHECKS) == ["mine.hinged-frequency"]
    assert names["hinged_frequency"]().verdict == "pass"


@pytest.mark.slow  # each call by itself: `tests/command_line/test_library.py`
def test_the_how_to_of_the_library_runs(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    names: dict = {}
    for block in blocks("howto/library.md", "python"):
        exec(block, names)
    assert names["found"].largest_shift < 1e-6
    assert not names["found"].only_left
    assert names["both"].summary["joints"] == [0.1]
    assert names["study"].report == tmp_path.relative_to(tmp_path) / "out/refine/report.html"
    assert names["result"].outcomes == {"completed": 3}
    assert all(result.verdict == "pass" for result in names["results"])
    shown = capsys.readouterr().out
    assert "modes and elements, 0 to 0.34 s" in shown
    assert "3 of 3" in shown
    assert "t = 0.340 s" in shown
    written = {path.relative_to(tmp_path).as_posix() for path in (tmp_path / "out").iterdir()}
    pictures = {
        "out/page.html",
        "out/impact.png",
        "out/beam",
        "out/beam.pvd",
        "out/film.gif",
        "out/beam.vtp",
        "out/overview.svg",
        "out/mine.toml",
        "out/campbell.svg",
        "out/force.svg",
    }
    assert written == {"out/paper", "out/both", "out/refine", "out/friction", *pictures}


def build(folder: Path, source: Path) -> subprocess.CompletedProcess[str]:
    # -N: where CI is set Sphinx colours what it says, terminal or not, and its lines begin with escapes
    options = ["-b", "html", "-W", "--keep-going", "-n", "-q", "-N"]
    return subprocess.run(
        [sys.executable, "-m", "sphinx", *options, str(source), str(folder)], capture_output=True, text=True
    )


def test_equation_with_a_wrong_name_fails_the_build(tmp_path):
    """The names of functions beside the equations are checked, and so is that there is one."""
    source = tmp_path / "source"
    source.mkdir()
    (source / "conf.py").write_text(
        f"import sys\nsys.path.insert(0, {str(DOCS / '_ext')!r})\n"
        'extensions = ["myst_parser", "sphinx.ext.mathjax", "equation"]\n',
        encoding="utf-8",
    )
    right = ":code: oblique_impact.installed._all\n"
    faults = {
        "wrong": (":code: oblique_impact.nowhere.nothing\n", "reference target not found: oblique_impact.nowhere"),
        "private": (":code: oblique_impact.errors._nothing\n", "there is no oblique_impact.errors._nothing"),
        "without": ("", "an equation needs :code:"),
    }
    for name, code in {"index": right, **{name: code for name, (code, _) in faults.items()}}.items():
        text = f"---\norphan: true\n---\n# Page\n\n```{{equation}}\n:label: {name}\n{code}a = b\n```\n"
        (source / f"{name}.md").write_text(text, encoding="utf-8")
    built = build(tmp_path / "built", source)
    assert built.returncode != 0
    # a warning is what fails the build, and a quiet one says nothing else
    said = re.findall(r"/(\w+)\.md:\d+: (?:WARNING|ERROR): (.*(?:\n(?!/).*)*)", built.stderr)
    assert {name for name, _ in said} == faults.keys(), built.stderr
    for name, (_, complaint) in faults.items():
        assert any(complaint in text for page, text in said if page == name), built.stderr


WIDTHS = (360, 768, 1024, 1300, 1360, 1420, 1920)


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    folder = tmp_path_factory.mktemp("site")
    built = build(folder, DOCS)
    assert built.returncode == 0, built.stderr[-3000:]
    return folder


@pytest.mark.slow
def test_no_page_of_the_site_scrolls_sideways(site, page):
    found = []
    for file in sorted(site.rglob("*.html")):
        page.goto(file.as_uri())
        for width in WIDTHS:
            page.set_viewport_size({"width": width, "height": 800})
            if page.evaluate("document.documentElement.scrollWidth") > width:
                found.append(f"{file.relative_to(site)} at {width} px")
    assert found == []


@pytest.mark.slow
def test_all_formulas_are_typeset_without_network(site, page):
    """By the MathJax of the site; what it does not know would stand there in red."""
    shown = 0
    for file in sorted((site / "theory").glob("*.html")):
        page.goto(file.as_uri())
        page.wait_for_function("() => window.MathJax?.startup?.promise?.then(() => true)")
        formulas = page.locator(".math").count()
        assert page.locator(".math mjx-container").count() == formulas, file
        assert page.locator("mjx-merror, [data-mjx-error]").count() == 0, file
        shown += formulas
    assert shown > 300


@pytest.mark.slow
def test_every_picture_of_the_site_is_that_of_the_theme(site, page):
    """One of each pair is shown; all that are shown have come."""
    pictures = "[...document.querySelectorAll('article img:not([src*=_static])')]"  # no signs of the theme
    shown = f"{pictures}.map(i => [i.src, i.getClientRects().length > 0])"
    seen = 0
    for theme in ("light", "dark"):
        page.emulate_media(color_scheme=theme)
        for file in sorted(site.rglob("*.html")):
            page.goto(file.as_uri())
            found = page.evaluate(shown)
            for source, there in found:
                assert there == (Path(source).stem.endswith("-dark") == (theme == "dark")), (file, source)
            assert page.evaluate(f"{pictures}.filter(i => i.complete && !i.naturalWidth).map(i => i.src)") == []
            seen += len(found)
    assert seen > 150


@pytest.fixture
def front(site, page):
    """The front page, and the player in it."""

    def show(**media):
        page.emulate_media(**media)
        page.goto((site / "index.html").as_uri())
        frame = page.frame_locator(".player iframe")
        frame.locator("#scene").wait_for()
        return page, page.frames[1]

    return show


@pytest.mark.slow
def test_the_front_page_moves_by_itself_and_nothing_on_it_jumps(front):
    page, frame = front()
    frame.wait_for_function("() => window.player && player.now().playing && player.now().time > 0.01")
    shifts = """new Promise(done => new PerformanceObserver(list => done(
        list.getEntries().reduce((sum, entry) => sum + entry.value, 0)
    )).observe({type: 'layout-shift', buffered: true}))"""
    none = "new Promise(done => setTimeout(() => done(0), 500))"
    assert page.evaluate(f"Promise.race([{shifts}, {none}])") < 0.01
    box = page.locator(".player").bounding_box()
    assert box["y"] + box["height"] < 900


@pytest.mark.slow
def test_the_front_page_stands_still_for_those_who_want_no_motion(front):
    _, frame = front(reduced_motion="reduce")
    frame.wait_for_function("() => window.player")
    frame.wait_for_timeout(300)
    assert frame.evaluate("[player.now().playing, player.now().time]") == [False, 0]


@pytest.mark.slow
def test_the_embedded_player_follows_the_switch_of_the_theme(front):
    page, frame = front(color_scheme="light")
    theme = "document.documentElement.dataset.chosen"
    for name in ("dark", "light", "auto"):
        page.evaluate(f"document.body.dataset.theme = '{name}'")
        frame.wait_for_function(f"() => {theme} === '{name}'")


@pytest.mark.slow
def test_neither_private_names_nor_constants_stand_in_the_api(site):
    names = [
        name
        for file in (site / "reference" / "api").glob("*.html")
        for name in re.findall(r'<dt class="sig[^>]*id="([^"]+)"', file.read_text(encoding="utf-8"))
    ]
    assert len(names) > 500
    assert not [name for name in names if any(part.startswith("_") for part in name.split("."))]
    modules = [name for name in names if re.fullmatch(r"[A-Z][A-Z0-9_]+", name.rpartition(".")[2])]
    # members of enumerations and of classes are part of the API: NORMAL of Outcome, E of a beam
    assert not [name for name in modules if name.split(".")[-2][0].islower()]


@pytest.mark.slow
def test_formulas_lead_to_their_code(site):
    """Where they are documented, private functions to the line of their source, which leads back."""
    seen = 0
    for file in (site / "theory").glob("*.html"):
        lines = re.findall(r'<div class="computed-by.*?</div>', file.read_text(encoding="utf-8"), re.DOTALL)
        for target in re.findall(r'href="([^"]+)"', "".join(lines)):
            path, _, name = target.partition("#")
            assert f'id="{name}"' in (file.parent / path).read_text(encoding="utf-8"), target
            seen += "_modules" in path
    assert seen > 20
    source = (site / "_modules/oblique_impact/beam/floating_frame.html").read_text(encoding="utf-8")
    back = re.findall(r'href="(\S+theory/\S+)">\[docs\]', source)
    assert back
    for target in back:
        path, _, name = target.partition("#")
        page = (site / "_modules/oblique_impact/beam" / path).resolve().read_text(encoding="utf-8")
        assert f'id="{name}"' in page


@pytest.mark.slow
def test_documentation_builds_without_a_warning_and_needs_no_network(site):
    pages = list(site.rglob("*.html"))
    assert len(pages) > 40
    for page in pages:
        text = page.read_text(encoding="utf-8")
        loaded = re.findall(r"<(?:script|img|link|iframe)[^>]*?(?:src|href)=\"(?:https?:)?//[^\"]+", text)
        assert not loaded, (page, loaded)
    theory = (site / "theory" / "motion.html").read_text(encoding="utf-8")
    assert theory.count('class="math') > 30
    assert 'href="../_modules/oblique_impact/beam/floating_frame.html#_first_order"' in theory
    keys = (site / "reference" / "scenario.html").read_text(encoding="utf-8")
    assert all(f">{path.rpartition('.')[2]}<" in keys for path in key_schemas())
