"""The program as a library: a documented, typed call for every command, silent, quick to import."""

from __future__ import annotations

import doctest
import inspect
import json
import re
import subprocess
import sys
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any, get_args, get_type_hints

import numpy as np
import pytest
import typer

from oblique_impact import InputError, Progress, Scenario, natural_frequencies, simulate
from oblique_impact.command_line import application as cli
from oblique_impact.renders import Style, campbell_diagram, export, render
from oblique_impact.renders.exports.command import READERS, Format
from oblique_impact.renders.geometry import QUANTITIES
from oblique_impact.renders.scene import CAMERAS
from oblique_impact.renders.style import THEMES, CameraName, Colour, ThemeName
from oblique_impact.validation import (
    AxisSection,
    SweepFile,
    compare,
    predictability,
    refine,
    reproduce,
    sweep,
    validate,
)
from oblique_impact.validation.reproduction import command as reproduction
from oblique_impact.validation.reproduction.claims import Finding, Judged
from oblique_impact.validation.reproduction.material import Material
from oblique_impact.validation.studies.design import load_plan

ROOT = Path(__file__).parents[2]
PACKAGES = ("oblique_impact", "oblique_impact.validation", "oblique_impact.renders")

#: options that are not an argument of the same name of the first call, and what they are in Python
ELSEWHERE = {
    ("*", "scenario"): Scenario.load,
    ("*", "changes"): Scenario.load,
    ("*", "as_json"): "oblique_impact.command_line.words.plain",
    ("init", "recommended"): "oblique_impact.beam.recommended.recommended",
    ("run", "out"): "oblique_impact.history.history.History.save",
    ("refine", "predictability"): "oblique_impact.validation.studies.predictability.predictability",
    ("modes", "out"): campbell_diagram,
    ("compare", "out"): "oblique_impact.validation.comparison.save_comparison",
    ("export", "all_samples"): (export, "every"),
    ("render", "size"): (Style, "size"),
    ("render", "deformation"): (Style, "deformation"),
    ("render", "colour"): (Style, "quantity"),
    ("render", "camera"): (Style, "camera"),
    ("render", "theme"): (Style, "theme"),
    ("render", "layout"): (Style, "layout"),
    ("render", "letters"): (Style, "letters"),
    ("render", "dpi"): (Style, "dpi"),
    ("render", "title"): (Style, "title"),
    ("render", "preset"): (Style.of, "preset"),
    ("render", "bare"): (Style, "charts"),
    ("render", "magnify"): (render, "magnify_difference"),
}


def commands() -> dict:
    """Click commands by name, from the command line itself."""
    return typer.main.get_command(cli.application()).commands


def table() -> dict[str, list[str]]:
    """Names in the column of calls of the reference, by command, and those in the column of results."""
    text = (ROOT / "docs" / "reference" / "python.rst").read_text(encoding="utf-8")
    part = text.partition(":class: commands-and-calls")[2].partition("\nA scenario as on")[0]
    rows = re.findall(r"\* - ``(\w+)``\n(.*?)(?=\n   \* - |\Z)", part, re.DOTALL)
    return {command: re.findall(r":py:\w+:`~([\w.]+)`", cells) for command, cells in rows}


def found(path: str):
    """The object of a dotted path."""
    parts = path.split(".")
    for split in range(len(parts) - 1, 0, -1):
        try:
            thing = import_module(".".join(parts[:split]))
        except ModuleNotFoundError:
            continue
        for part in parts[split:]:
            thing = getattr(thing, part)
        return thing
    raise AssertionError(path)


def pages() -> str:
    folder = ROOT / "docs" / "reference" / "api"
    return "\n".join(file.read_text(encoding="utf-8") for file in folder.glob("*.rst"))


def test_every_command_has_a_row_with_its_call():
    assert table().keys() == commands().keys()
    assert len(table()) >= 9


@pytest.mark.parametrize("command", sorted(commands()))
def test_the_call_of_a_command_is_documented_typed_and_returns_something(command):
    first, *others = table()[command]
    call = found(first)
    # it is imported from its package, and it is the thing that the package means by that name
    package = import_module(first.partition(".")[0])
    name = first.rpartition(".")[2]
    assert name in package.__all__
    assert getattr(package, name) is call
    hints = get_type_hints(call)
    parameters = inspect.signature(call).parameters
    assert set(parameters) <= hints.keys()
    assert hints["return"] not in (type(None), list[str], str)
    result = get_args(hints["return"])[-1:] or (hints["return"],)
    if result[0] is not Any:  # a dictionary of plain values
        assert found(others[-1]) is result[0], "the table says what it returns"
    for section in ("Parameters\n-", "Returns\n-", "Raises\n-", "Examples\n-"):
        # a run raises nothing: how it ended is its outcome; the list of scenarios takes nothing
        said = inspect.getdoc(call) or ""
        without = {("run", "Raises"), ("scenarios", "Raises"), ("scenarios", "Parame")}
        assert section in said or (command, section[:6]) in without, (first, section)
    for path in (first, *others):
        module = next(
            m for m in (path.rsplit(".", n)[0] for n in (1, 2)) if isinstance(sys.modules.get(m), ModuleType)
        )
        assert f".. automodule:: {module}\n" in pages(), path
    for parameter in parameters:
        assert re.search(rf"^[\w*, ]*\b{parameter}\b[\w, ]* : ", inspect.getdoc(call) or "", re.MULTILINE), (
            parameter
        )


@pytest.mark.parametrize("command", sorted(commands()))
def test_every_option_is_an_argument(command):
    """What the command line can say can be said in Python, by the same name where there is no better one."""
    call = found(table()[command][0])
    arguments = inspect.signature(call).parameters
    for option in commands()[command].params:
        if option.name in ("help", *arguments):
            continue
        place = ELSEWHERE.get((command, option.name), ELSEWHERE.get(("*", option.name)))
        if command in ("render", "export") and option.name in ("histories", "history"):
            continue
        assert place is not None, f"{command}: {option.name}"
        if isinstance(place, tuple):
            assert place[1] in inspect.signature(place[0]).parameters
        else:
            assert callable(found(place) if isinstance(place, str) else place)


def test_words_that_calls_take_are_those_that_are_known():
    assert set(get_args(Format)) == READERS.keys()
    assert set(get_args(CameraName)) == CAMERAS.keys()
    assert set(get_args(ThemeName)) == {*THEMES, "auto"}
    assert set(get_args(Colour)) == QUANTITIES.keys() - {"elastic_displacement", "velocity"}


@pytest.mark.parametrize("package", PACKAGES)
def test_public_names_are_there_and_stay_what_they_are(package):
    """A call keeps its name when the submodule of the same name has been imported."""
    module = import_module(package)
    for name in module.__all__:
        assert not isinstance(getattr(module, name), ModuleType), name
        assert name in dir(module)
        assert f"`{name}`" in module.__doc__ or inspect.isclass(getattr(module, name)), name
    with pytest.raises(AttributeError):
        module.nonsense  # noqa: B018


def test_packages_load_little():
    """Importing all three packages loads none of the large libraries, nor the modules of the calls."""
    code = (
        "import sys, oblique_impact, validation, renders\n"
        "large = 'numpy scipy numba xarray pydantic rich matplotlib pyvista vtk pyarrow'.split()\n"
        "print(*(name for name in large if name in sys.modules), sep=',', end=';')\n"
        "from validation import sweep, compare\n"
        "print(callable(sweep), 'matplotlib' in sys.modules, 'pyvista' in sys.modules)"
    )
    shown = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert shown == ";True False False\n"


@pytest.mark.parametrize(
    "module",
    [
        "oblique_impact.beam.frequencies",
        "oblique_impact.validation.comparison",
        "oblique_impact.validation.studies.refinement",
    ],
)
def test_examples_of_the_docstrings_say_the_truth(module):
    tested = doctest.testmod(import_module(module))
    assert (tested.failed, tested.attempted > 2) == (0, True)


def test_reproduce_without_a_folder_writes_nothing(monkeypatch, tmp_path):
    """The simulations are those of the command's test; here they are what they might be."""
    monkeypatch.chdir(tmp_path)
    told: list[Progress] = []
    finding = Finding("partly", {}, "")
    judged = [Judged(None, {"event": finding}), Judged(None, {"event": Finding("reproduced", {}, "")})]

    def collect(workers, on_progress):
        on_progress(Progress(1, 1, f"{workers} worker"))
        return Material({}, {}, judged, [], [], (0.0, []))

    monkeypatch.setattr(reproduction, "collect", collect)
    result = reproduce(workers=1, on_progress=told.append)
    assert result.verdicts == {"reproduced": 1, "partly": 1, "not reproduced": 0}
    assert (result.claims, result.report) == (judged, None)
    assert told == [Progress(1, 1, "1 worker")]
    assert list(tmp_path.iterdir()) == []


@pytest.fixture(scope="module")
def swing():
    return Scenario.builtin("paper").replace(end_time=0.05, discretization__frame="mean-axis")


def test_calls_are_silent_and_tell_how_far_they_are(swing, history, tmp_path, capfd):
    told: list[Progress] = []
    study = refine(swing, elements=[4, 8, 16], quantities=["theta@end"], workers=1, on_progress=told.append)
    assert [(p.done, p.total) for p in told] == [(n, told[0].total) for n in range(len(told))]
    assert told[-1].done == told[-1].total >= 3
    assert study.report is None
    told.clear()
    frames = export(history, tmp_path / "beam", format="xdmf", every=50, on_progress=told.append).samples
    assert (told[0], told[-1]) == (Progress(0, frames), Progress(frames, frames))
    told.clear()
    chosen = ["statics.own-weight", "statics.inclined"]
    assert {r.verdict for r in validate(only=chosen, workers=1, on_progress=told.append)} == {"pass"}
    assert told[0].done == 0
    assert told[-1].done == told[-1].total == len(told) - 1
    assert told[-1].last.startswith("statics.")
    compare(history, history, ["theta"])
    assert capfd.readouterr() == ("", "")


def test_frequencies_are_those_of_the_command(capsys):
    found = natural_frequencies(Scenario.builtin("spin-up"), [0.0, 6.0], 3)
    with pytest.raises(SystemExit):
        cli.main(["modes", "spin-up", "--speeds", "0,6", "--count", "3", "--json"])
    assert json.loads(capsys.readouterr().out) == found.to_dict()
    assert found.flapwise.shape == found.chordwise.shape == (2, 3)
    assert np.all(np.diff(found.flapwise, axis=1) > 0.0)


def test_refine_writes_the_report_of_the_command(swing, tmp_path, capsys):
    file = tmp_path / "swing.toml"
    file.write_text(swing.to_toml())
    with pytest.raises(SystemExit):
        cli.main(
            [
                *("refine", str(file), "--modes", "1,2,3", "--quantity", "theta@end"),
                *("--workers", "1", "--out", str(tmp_path / "a")),
            ]
        )
    assert "theta@end" in capsys.readouterr().out
    result = refine(
        swing, modes=[1, 2, 3], quantities=["theta@end"], out=tmp_path / "b", name="swing.toml", workers=1
    )
    assert result.report == tmp_path / "b" / "report.html"
    ours, theirs = (json.loads((tmp_path / n / "results.json").read_text()) for n in "ba")
    assert ours.pop("command") == ""
    # what was typed
    rest = f"--modes 1,2,3 --quantity theta@end --out {tmp_path / 'a'} --workers 1"
    assert theirs.pop("command") == f"oblique-impact refine {file} {rest}"
    for data in (ours, theirs):
        del data["times"]
        for ladder in data["ladders"]:
            ladder.pop("times", None)
    assert ours == theirs
    values = result.ladders[0].runs["theta@end"].tolist()
    assert result.quantity("theta@end").values == tuple(values)


def test_a_sweep_in_python_is_that_of_its_file(swing, tmp_path, capfd):
    (tmp_path / "swing.toml").write_text(swing.to_toml())
    (tmp_path / "sweep.toml").write_text(
        'scenario = "swing.toml"\nquantities = ["theta@end"]\nhistories = true\n'
        '[[axes]]\nkey = "gravity"\nrange = [9.0, 9.8]\ncount = 3\n'
    )
    axis = AxisSection(key="gravity", range=(9.0, 9.8), count=3)
    ours = SweepFile(axes=[axis], quantities=["theta@end"], histories=True)
    told: list[Progress] = []
    result = sweep(ours, tmp_path / "out", base=swing, workers=1, on_progress=told.append)
    assert (told[0], told[-1].done) == (Progress(0, 3), 3)
    assert capfd.readouterr() == ("", "")
    # the same fingerprint: the file goes on in this folder, where there is nothing left to do
    again = sweep(tmp_path / "sweep.toml", tmp_path / "out", workers=1)
    assert (result.earlier, again.earlier) == (0, 3)
    assert again.frame.equals(result.frame)
    assert result.outcomes == {"completed": 3}
    assert result.report.is_file()
    frame = result.frame
    assert frame["gravity"].tolist() == pytest.approx([9.0, 9.4, 9.8])
    assert frame["theta@end"][2] == result.history(3)["theta"].values[-1]


def test_pictures_from_python(run, tmp_path):
    history = run("paper", "end_time=0.34")
    still = render(history, tmp_path / "a.png", Style(size=(480, 320)), event=1)
    assert (still.file, still.size, still.timeline) == (tmp_path / "a.png", (480, 320), None)
    film = render(
        [history], str(tmp_path / "a.gif"), Style(size=(320, 180), charts=False), frames=2, between=(0.3, 0.34)
    )
    assert film.timeline is not None
    assert film.timeline.times.tolist() == pytest.approx([0.3, 0.34])
    assert film.factor == still.factor > 1.0


@pytest.fixture(scope="module")
def history(swing):
    return simulate(swing)


def bad(swing, history, tmp_path):
    small, wrong = (SweepFile(axes=[AxisSection(key=key, values=[9.0])]) for key in ("gravity", "nonsense"))
    return {
        "--speeds nan": lambda: natural_frequencies(swing, [float("nan")]),
        "--speeds ()": lambda: natural_frequencies(swing, []),
        "--count 0": lambda: natural_frequencies(swing, count=0),
        "--only nonsense": lambda: validate(only=["nonsense"]),
        "refine: give one of --elements": lambda: refine(swing),
        "refine: a scenario is needed": lambda: refine(elements=[1, 2, 3]),
        "--elements 4,8,16.5: should be whole": lambda: refine(swing, elements=[4, 8, 16.5]),
        "--elements 4,8: a verdict takes 3": lambda: refine(swing, elements=[4, 8]),
        "--elements together with --modes": lambda: refine(swing, elements=[4, 8, 16], modes=[1, 2, 3]),
        "--within 2": lambda: refine(swing, elements=[4, 8, 16], within=2.0),
        "scenario together with --study": lambda: refine(swing, study="steps"),
        "changes: are for a shipped study": lambda: refine(swing, elements=[4, 8, 16], changes={"gravity": 9.0}),
        "predictability: scenario = 'paper'": lambda: predictability("paper"),
        "changes: ": lambda: refine(study="steps", changes={"gravity": object()}),
        "--study": lambda: refine(study="nonsense"),
        "--out": lambda: reproduce(tmp_path / "file"),
        "nothing to sweep over": lambda: sweep(SweepFile(), tmp_path / "s"),
        "--workers 2 together": lambda: sweep(small, tmp_path / "s", workers=2, scheduler="tcp://127.0.0.1:1"),
        "base: a plan": lambda: sweep(load_plan("friction"), tmp_path / "s", base=swing),
        "axes.0.key = 'nonsense'": lambda: sweep(wrong, tmp_path),
        "axes = 3": lambda: SweepFile.from_dict({"axes": 3}),
        "should end with .png": lambda: render(history, tmp_path / "a.bmp"),
        "HISTORY: none given": lambda: render([], tmp_path / "a.png"),
        "films need even numbers": lambda: render(history, tmp_path / "a.mp4", Style(size=(481, 320))),
        "a page shows one": lambda: render([history] * 2, tmp_path / "a.html"),
        "--format: missing": lambda: export(history, tmp_path / "beam"),
        "--every 0": lambda: export(history, tmp_path / "beam", format="pvd", every=0),
    }


@pytest.mark.parametrize("number", range(27))
def test_bad_input_is_one_line_and_leaves_nothing(swing, history, tmp_path, number):
    (tmp_path / "file").write_text("in the way")
    cases = bad(swing, history, tmp_path)
    assert len(cases) == 27
    words, call = list(cases.items())[number]
    with pytest.raises(InputError) as refused:
        call()
    assert words in str(refused.value)
    assert "\n" not in str(refused.value)
    assert [p.name for p in tmp_path.iterdir()] == ["file"]
