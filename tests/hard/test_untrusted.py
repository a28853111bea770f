"""Files from elsewhere: nothing is executed, no other file is read or written, no memory is taken unseen."""

from __future__ import annotations

import ast
import json
import os
import resource
import subprocess
import sys
import time
from pathlib import Path

import h5py
import numpy as np
import pytest

import oblique_impact
from oblique_impact import History, InputError, Scenario
from oblique_impact.history.netcdf import MAX_BESIDES, MAX_BYTES
from validation.sweeps.plan import load_plan, make_plan
from validation.sweeps.store import open_store

ROOT = Path(oblique_impact.__file__).parents[1]
SOURCES = [
    file
    for name in ("oblique_impact", "modal", "fem_beam", "validation", "renders")
    for file in (ROOT / name).rglob("*.py")
]

#: modules that make objects, or code, of what they read
MODULES = {
    "pickle",
    "cPickle",
    "dill",
    "cloudpickle",
    "marshal",
    "shelve",
    "joblib",
    "yaml",
    "runpy",
    "code",
    "imp",
}
#: names called that do
CALLS = {"eval", "exec", "compile", "__import__", "system", "popen", "read_pickle", "to_pickle", "allow_pickle"}


def dangers(text: str) -> list[str]:
    found = []
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import):
            found += [a.name for a in node.names if a.name.partition(".")[0] in MODULES]
        elif isinstance(node, ast.ImportFrom):
            found += [node.module] if (node.module or "").partition(".")[0] in MODULES else []
        elif isinstance(node, ast.Call):
            name = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
            module = getattr(getattr(node.func, "value", None), "id", "")
            found += [name] if name in CALLS and module not in ("re", "platform") else []
            found += [k.arg for k in node.keywords if k.arg in ("allow_pickle", "shell")]
    return found


def test_no_source_makes_code_or_objects_of_what_it_reads():
    assert len(SOURCES) > 100
    assert {file.name: dangers(file.read_text()) for file in SOURCES if dangers(file.read_text())} == {}


@pytest.mark.parametrize(
    "text",
    [
        "import pickle",
        "from marshal import loads",
        "eval(x)",
        "np.load(f, allow_pickle=True)",
        "run(c, shell=True)",
    ],
)
def test_the_search_finds_what_it_should(text):
    assert dangers(text)


@pytest.fixture(scope="module")
def saved(run, tmp_path_factory):
    return run("paper", "end_time=0.33").save(tmp_path_factory.mktemp("paper")) / "history.nc"


@pytest.fixture
def crafted(saved, tmp_path):
    """A copy to do harm with."""
    copy = tmp_path / "crafted.nc"
    copy.write_bytes(saved.read_bytes())
    return copy


def refused(file: Path) -> str:
    clock = time.monotonic()
    with pytest.raises(InputError) as error:
        History.load(file)
    assert time.monotonic() - clock < 2.0
    line = str(error.value)
    assert len(line.splitlines()) == 1
    assert str(file) in line
    return line


def replaced(file: Path, name: str, make):
    with h5py.File(file, "r+") as root:
        shape = root[name].shape
        del root[name]
        make(root, name, shape)


def external_link(root, name, shape):
    with h5py.File(f"{root.filename}.other", "w") as other:
        other["secret"] = np.zeros(shape)
    root[name] = h5py.ExternalLink(f"{root.filename}.other", "/secret")


def soft_link(root, name, shape):
    root[name] = h5py.SoftLink("/gap_rate")


def virtual(root, name, shape):
    layout = h5py.VirtualLayout(shape, "f8")
    layout[:] = h5py.VirtualSource(f"{root.filename}.other", "secret", shape)
    root.create_virtual_dataset(name, layout)


def external_storage(root, name, shape):
    root.create_dataset(name, shape, "f8", external=[("/etc/passwd", 0, 8 * shape[0])])


def group(root, name, shape):
    root.create_group(name)["loop"] = root["/"]


def objects(root, name, shape):
    root.create_dataset(name, shape, h5py.string_dtype())


def references(root, name, shape):
    root.create_dataset(name, shape, h5py.ref_dtype)


def compound(root, name, shape):
    root.create_dataset(name, shape, np.dtype([("PICKLE", "f8"), ("class", "i4")]))


def complex_numbers(root, name, shape):
    root.create_dataset(name, shape, "c16")


def lists(root, name, shape):
    root.create_dataset(name, shape, h5py.vlen_dtype(np.float64))


def strange_filter(root, name, shape):
    root.create_dataset(name, data=np.zeros(shape), compression="lzf")


def three_dimensions(root, name, shape):
    root.create_dataset(name, data=np.zeros((*shape, 1, 1)))


def scalar(root, name, shape):
    root.create_dataset(name, data=1.0)


def empty(root, name, shape):
    root.create_dataset(name, data=h5py.Empty("f8"))


def too_short(root, name, shape):
    root.create_dataset(name, data=np.zeros(shape[0] - 1))


def never_written(root, name, shape):
    root.create_dataset(name, shape, "f8")


def astronomic(root, name, shape):
    root.create_dataset(name, (10**12, 1000), "f8", chunks=(1000, 1000), fillvalue=1.0)


def many_pieces_missing(root, name, shape):
    dataset = root.create_dataset(name, (10**8,), "f8", chunks=(1000,), fillvalue=1.0)
    dataset[0] = 1.0


HARM = {
    external_link: "is a link",
    soft_link: "is a link",
    virtual: "lies in another file",
    external_storage: "lies in another file",
    group: "is not a variable",
    objects: "does not hold numbers",
    references: "does not hold numbers",
    compound: "does not hold numbers",
    complex_numbers: "does not hold numbers",
    lists: "does not hold numbers",
    strange_filter: "is packed with a filter",
    three_dimensions: "one or two dimensions",
    scalar: "one or two dimensions",
    empty: "one or two dimensions",
    too_short: "values along time",
    never_written: "are not there",
    astronomic: "at most",
    many_pieces_missing: "are not there",
}


@pytest.mark.parametrize("harm", HARM, ids=lambda harm: harm.__name__)
@pytest.mark.parametrize("name", ["gap", "unknown"])
def test_what_a_history_never_holds_is_refused(crafted, harm, name):
    with h5py.File(crafted, "r+") as root:
        if name == "unknown":
            root.create_dataset(name, data=np.zeros(root["gap"].shape))
    replaced(crafted, name, harm)
    assert HARM[harm] in refused(crafted)


def test_a_variable_of_another_length_than_its_dimension_is_refused(crafted):
    with h5py.File(crafted, "r+") as root:
        time, size = root["time"], root["gap"].shape[0]
        del root["gap"]
        root.create_dataset("gap", data=np.zeros(size - 1)).dims[0].attach_scale(time)
    assert "are not there" in refused(crafted)


@pytest.mark.parametrize("name", ["coordinate", "unknown"])
def test_a_dimension_is_not_taken_for_its_values(crafted, name):
    """The check of the description leaves the empty variable of a dimension out."""
    with h5py.File(crafted, "r+") as root:
        if name in root:
            del root[name]
        root.create_dataset(name, (10**12,), "f8", chunks=(1000,), fillvalue=1.0).make_scale()
    assert "are not there" in refused(crafted) or "at most" in refused(crafted)


def test_attributes_are_words_and_numbers(crafted):
    with h5py.File(crafted, "r+") as root:
        root["gap"].attrs["__reduce__"] = np.array([1.0, 2.0])
    assert "__reduce__" not in History.load(crafted)["gap"].attrs
    for kind in ("code", "reference"):
        with h5py.File(crafted, "r+") as root:
            code = np.void(b"cos\nsystem\n(S'touch /tmp/owned'\ntR.")
            root.attrs["odd"] = root["gap"].ref if kind == "reference" else code
        assert "attribute odd is no word or number" in refused(crafted)


def measured(file: Path) -> tuple[str, int]:
    """What loading says, and the most memory (MB) that it took besides what the program takes anyway."""
    code = (
        "import sys, resource\nfrom oblique_impact import History, InputError\n"
        "before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss\nsaid = 'loaded'\n"
        "try:\n    History.load(sys.argv[1])\nexcept InputError as error:\n    said = str(error)\n"
        "print(said); print((resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) // 1024)"
    )
    done = subprocess.run([sys.executable, "-c", code, str(file)], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    said, taken = done.stdout.splitlines()
    return said, int(taken)


@pytest.mark.slow
def test_a_packed_bomb_is_refused_before_it_is_unpacked(crafted):
    def bomb(root, name, shape):
        root.create_dataset(name, (2**27,), "f8", chunks=(2**24,), compression="gzip", data=np.zeros(2**27))

    replaced(crafted, "gap", bomb)  # 1 GB in 1 MB
    said, taken = measured(crafted)
    assert "a history is not packed like that" in said
    assert taken < 50


@pytest.mark.slow
def test_large_attributes_are_refused_before_they_are_read(crafted):
    with h5py.File(crafted, "r+", libver="latest") as root:
        root["gap"].attrs.create("x", np.zeros(MAX_BESIDES // 8 + 1))
    said, taken = measured(crafted)
    assert "an attribute is larger" in said
    assert taken < 50


def test_the_limits_let_every_run_pass():
    """What a scenario may ask for, with two samples more for each event, can be read again."""
    from oblique_impact.marching.loop import MAX_EVENTS
    from oblique_impact.scenario.rules import MAX_VALUES, _values_per_sample

    assert 8 * (MAX_VALUES + 3 * MAX_EVENTS * _values_per_sample(Scenario.builtin("paper"))) < MAX_BYTES
    assert 500 * MAX_EVENTS < MAX_BESIDES


def attribute(root, name, content):
    root.attrs[name] = np.bytes_(content)


CONTENTS = {
    "no json": ("events", "[", "is not JSON"),
    "deep json": ("events", "[" * 60_000, "is not JSON"),
    "other json": ("events", "{}", "should be a list"),
    "short event": ("events", "[[0.1]]", "is not an event"),
    "strange event": ("events", '[[0.1, "boom", 0, 0, 0, 0, "free", 0, 0, 0]]', "is not an event"),
    "strange state": ("events", '[[0.1, "impact", 0, 0, 0, 0, 1, 0, 0, 0]]', "is not an event"),
    "strange contact": ("contacts", '[[0.1, 0.2, "much", 0, 0, 0, 0]]', "is not a contact"),
    "short contact": ("contacts", "[[0.1, 0.2]]", "is not a contact"),
    "late event": ("events", '[[9.9, "impact", 0, 0, 0, 0, "free", 0, 0, 0]]', "times should be ascending"),
    "event at no time": ("events", '[[NaN, "impact", 0, 0, 0, 0, "free", 0, 0, 0]]', "times should be ascending"),
    "large number": ("events", f'[[{"9" * 5000}, "impact", 0, 0, 0, 0, 0, "free"]]', "is not JSON"),
    "no object": ("summary", "[]", "should be a dict"),
    "no outcome": ("summary", "{}", "outcome should be one of"),
    "version": ("format", "oblique-impact history 0", "not of this version"),
}


@pytest.mark.parametrize("case", CONTENTS)
def test_contents_are_checked(crafted, case):
    name, content, words = CONTENTS[case]
    with h5py.File(crafted, "r+") as root:
        attribute(root, name, content)
    assert words in refused(crafted)


SUMMARIES = {
    "end_time": "x",
    "events": None,
    "steps": True,
    "wall_time": 10**400,
    "macro_gap": "short",
    "macro_collisions": [{"start": 0.0}],
    "energy": {"initial": 1.0},
    "warnings": "no list",
    "clearance": {"distance": 0.0},
    "outcome": ["completed"],
}


@pytest.mark.parametrize("key", SUMMARIES)
def test_every_key_of_the_summary_is_checked(crafted, saved, key):
    summary = History.load(saved).summary
    with h5py.File(crafted, "r+") as root:
        attribute(root, "summary", json.dumps(summary | {key: SUMMARIES[key]}))
    assert key in refused(crafted)


VALUES = {
    "time": (5, np.nan, "finite and ascending"),
    "time backwards": (5, -1.0, "finite and ascending"),
    "state": (0, 7, "should be one of 0, 1, 2"),
    "station": (0, 0.9, "finite and ascending"),
}


@pytest.mark.parametrize("case", VALUES)
def test_values_are_checked(crafted, case):
    place, value, words = VALUES[case]
    with h5py.File(crafted, "r+") as root:
        root[case.split()[0]][place] = value
    assert words in refused(crafted)


def test_a_missing_variable_is_named(crafted):
    with h5py.File(crafted, "r+") as root:
        del root["slip_rate"]
    assert "has no variable 'slip_rate'" in refused(crafted)


# --- scenarios and sweeps


def limited() -> None:
    resource.setrlimit(resource.RLIMIT_AS, (4 * 2**30,) * 2)


@pytest.mark.parametrize("command", ["run", "sweep"])
def test_sources_without_end_or_beginning(tmp_path, command):
    fifo, large, nulls = tmp_path / "fifo.toml", tmp_path / "large.toml", "a\0b"
    os.mkfifo(fifo)
    with large.open("wb") as file:
        file.truncate(10 * 10**9)
    for source in (fifo, large, Path("/dev/zero"), tmp_path, Path("x" * 5000)):
        done = subprocess.run(
            [sys.executable, "-m", "oblique_impact", command, str(source), "--out", str(tmp_path / "never")],
            capture_output=True,
            text=True,
            timeout=20,
            preexec_fn=limited,
        )
        assert done.returncode == 2
        assert done.stderr.count("\n") == 1, done.stderr
    assert not (tmp_path / "never").exists()
    with pytest.raises(InputError):
        Scenario.load(nulls)
    with pytest.raises(InputError):
        load_plan(nulls)


NESTED = {
    "arrays": "x = " + "[" * 300_000,
    "tables": "x = " + "{a=" * 100_000,
    "keys": "a." * 400_000 + "b = 1",
    "quoted keys": "'=' . " * 100_000 + "b = 1",
    "header": "[" + "a." * 400_000 + "b]",
    "inline": "x = {" + 'a."\\"". ' * 90_000 + "b = 1}",
    "number": "end_time = " + "9" * 500_000,
    "string": 'scenario = "' + "x" * 900_000 + '"',
}


@pytest.mark.parametrize("case", NESTED)
def test_nesting_and_length_are_bounded(case):
    for read in (Scenario.from_toml, make_plan):
        clock = time.monotonic()
        with pytest.raises(InputError) as error:
            read(NESTED[case])
        assert time.monotonic() - clock < 5.0
        assert len(str(error.value)) < 2000
        assert len(str(error.value).splitlines()) == 1


# --- nothing is written elsewhere

STUDY = """
title = "../../title"
changes.end_time = 0.02
histories = true
[[axes]]
key = "contact.mu_static"
values = [0.3, 0.4]
"""


def test_no_file_is_named_by_what_a_file_says(tmp_path):
    with pytest.raises(InputError, match="not a key"):
        make_plan(STUDY.replace("contact.mu_static", "../../evil"))
    with pytest.raises(InputError):
        make_plan(STUDY.replace("histories = true", 'quantities = ["../../evil"]'))


@pytest.mark.parametrize("name", ["rows.jsonl", "histories", ".scratch", "results.parquet"])
def test_links_inside_a_sweep_are_not_followed(tmp_path, name):
    elsewhere, out = tmp_path / "elsewhere", tmp_path / "out"
    for folder in (elsewhere, out):
        folder.mkdir()
    (out / name).symlink_to(elsewhere)
    with pytest.raises(InputError, match="leads elsewhere"), open_store(out, make_plan(STUDY)):
        pass
    assert list(elsewhere.iterdir()) == []


def test_links_in_the_folder_of_a_run_are_replaced_not_followed(run, tmp_path):
    precious, out = tmp_path / "precious", tmp_path / "out"
    precious.write_text("mine")
    out.mkdir()
    for name in ("history.nc", "summary.json", "events.csv", "scenario.toml"):
        (out / name).symlink_to(precious)
    run("paper", "end_time=0.33").save(out)
    assert precious.read_text() == "mine"
    assert not (out / "summary.json").is_symlink()
