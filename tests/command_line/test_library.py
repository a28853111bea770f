"""The program as a library: calls are silent, say how far they are, and refuse bad input in one line."""

from __future__ import annotations

import doctest

import numpy as np
import pytest

<<<<<<< HEAD
from oblique_impact import InputError, Progress, Scenario, natural_frequencies, scenario_schema, simulate
from oblique_impact.beam import frequencies
from oblique_impact.scenario import schema
from oblique_impact.validation import refine, validate
=======
from oblique_impact import InputError, Progress, Scenario, natural_frequencies, simulate
from oblique_impact.command_line import application as cli
from oblique_impact.renders import Style, campbell_diagram, export, render
from oblique_impact.renders.exports.command import Format
from oblique_impact.renders.exports.target import SUFFIXES
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
>>>>>>> w-paper


def test_examples_of_the_docstrings_hold():
    for module in (frequencies, schema):
        tested = doctest.testmod(module)
        assert (tested.failed, tested.attempted > 0) == (0, True)


<<<<<<< HEAD
def test_calls_are_silent_and_say_how_far_they_are(capfd):
    swing = Scenario.builtin("paper").replace(end_time=0.05, discretization__frame="mean-axis")
    assert simulate(swing).events == []
    assert scenario_schema()["properties"]
    told: list[Progress] = []
    refine(swing, elements=[4, 8, 16], quantities=["theta@end"], workers=1, on_progress=told.append)
=======
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
    assert set(get_args(Format)) == SUFFIXES.keys()
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


@pytest.fixture(scope="module")
def swing():
    return Scenario.builtin("paper").replace(end_time=0.05, discretization__frame="mean-axis")


def test_calls_are_silent_and_tell_how_far_they_are(swing, history, tmp_path, capfd):
    told: list[Progress] = []
    study = refine(swing, elements=[4, 8, 16], quantities=["theta@end"], workers=1, on_progress=told.append)
>>>>>>> w-paper
    assert [(p.done, p.total) for p in told] == [(n, told[0].total) for n in range(len(told))]
    assert told[-1].done == told[-1].total >= 3
    told.clear()
    chosen = ["statics.own-weight", "statics.inclined"]
    assert {r.verdict for r in validate(only=chosen, workers=1, on_progress=told.append)} == {"pass"}
    assert told[-1].done == told[-1].total
    assert capfd.readouterr() == ("", "")


def test_frequencies_ascend():
    found = natural_frequencies(Scenario.builtin("spin-up"), [0.0, 6.0], 3)
    assert found.flapwise.shape == found.chordwise.shape == (2, 3)
    assert np.all(np.diff(found.flapwise, axis=1) > 0.0)


@pytest.mark.parametrize(
    ("speeds", "count", "words"),
    [([float("nan")], None, "--speeds nan"), ([], None, "--speeds"), ([0.0], 0, "--count 0")],
)
def test_bad_arguments_are_one_line(speeds, count, words):
    with pytest.raises(InputError, match=words) as refused:
        natural_frequencies(Scenario(), speeds, count)
    assert "\n" not in str(refused.value)
