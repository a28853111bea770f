"""Files from elsewhere: no other file is read or written, no memory is taken unseen."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import h5py
import numpy as np
import pytest

from oblique_impact import History, InputError, Scenario
from oblique_impact.history.netcdf import MAX_BYTES
from oblique_impact.validation.studies.design import load_plan, make_plan


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
    with pytest.raises(InputError) as error:
        History.load(file)
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


def three_dimensions(root, name, shape):
    root.create_dataset(name, data=np.zeros((*shape, 1, 1)))


def scalar(root, name, shape):
    root.create_dataset(name, data=1.0)


def empty(root, name, shape):
    root.create_dataset(name, data=h5py.Empty("f8"))


def too_short(root, name, shape):
    root.create_dataset(name, data=np.zeros(shape[0] - 1))


def astronomic(root, name, shape):
    root.create_dataset(name, (10**12, 1000), "f8", chunks=(1000, 1000), fillvalue=1.0)


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
    three_dimensions: "one or two dimensions",
    scalar: "one or two dimensions",
    empty: "one or two dimensions",
    too_short: "values along time",
    astronomic: "values along time",
}


@pytest.mark.parametrize("harm", HARM, ids=lambda harm: harm.__name__)
@pytest.mark.parametrize("name", ["gap", "unknown"])
def test_what_a_history_never_holds_is_refused(crafted, harm, name):
    with h5py.File(crafted, "r+") as root:
        if name == "unknown":
            root.create_dataset(name, data=np.zeros(root["gap"].shape))
    replaced(crafted, name, harm)
    said = refused(crafted)
    assert HARM[harm] in said.partition(f"{name}: ")[2], said


def test_a_refused_file_harms_no_one_who_keeps_the_error(crafted):
    """HDF5 crashes at exit if a property list of a virtual layout is still open."""
    replaced(crafted, "gap", virtual)
    code = (
        "import ctypes, sys\nfrom oblique_impact import History, InputError\n"
        "try:\n    History.load(sys.argv[1])\n"
        "except InputError as error:\n    ctypes.pythonapi.Py_IncRef(ctypes.py_object(error))"
    )
    assert subprocess.run([sys.executable, "-c", code, str(crafted)], timeout=60).returncode == 0


def test_a_variable_of_another_length_than_its_dimension_is_refused(crafted):
    with h5py.File(crafted, "r+") as root:
        time, size = root["time"], root["gap"].shape[0]
        del root["gap"]
        root.create_dataset("gap", data=np.zeros(size - 1)).dims[0].attach_scale(time)
    assert "does not have the size of its dimensions" in refused(crafted)


@pytest.mark.parametrize("name", ["coordinate", "unknown"])
def test_a_dimension_is_not_taken_for_its_values(crafted, name):
    """The check of the description leaves the empty variable of a dimension out."""
    with h5py.File(crafted, "r+") as root:
        if name in root:
            del root[name]
        root.create_dataset(name, (10**12,), "f8", chunks=(1000,), fillvalue=1.0).make_scale()
    assert "not packed like that" in refused(crafted)


def test_attributes_are_words_and_numbers(crafted):
    with h5py.File(crafted, "r+") as root:
        root["gap"].attrs["__reduce__"] = np.array([1.0, 2.0])
        root["gap"].attrs["odd"] = np.void(b"cos\nsystem\n(S'touch /tmp/owned'\ntR.")
    assert set(History.load(crafted)["gap"].attrs) == {"units", "long_name", "comment"}
    with h5py.File(crafted, "r+") as root:
        root["gap"].attrs["odd"] = root["gap"].ref
    assert refused(crafted)


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
        packed = root.create_dataset(
            name, (2**27,), "f8", chunks=(2**24,), compression="gzip", data=np.zeros(2**27)
        )
        packed.dims[0].attach_scale(root["time"])

    replaced(crafted, "gap", bomb)  # 1 GB in 1 MB
    said, taken = measured(crafted)
    assert "a history is not packed like that" in said
    assert taken < 50


def test_the_limits_let_every_run_pass():
    """What a scenario may ask for, with two samples more for each event, can be read again."""
    from oblique_impact.marching.loop import MAX_EVENTS
    from oblique_impact.scenario.rules import MAX_VALUES, _values_per_sample

    assert 8 * (MAX_VALUES + 3 * MAX_EVENTS * _values_per_sample(Scenario.builtin("paper"))) < MAX_BYTES


def attribute(root, name, content):
    root.attrs[name] = np.bytes_(content)


CONTENTS = {
    "no json": ("events", "[", "Invalid JSON"),
    "deep json": ("events", "[" * 60_000, "Invalid JSON"),
    "other json": ("events", "{}", "should be a valid array"),
    "short event": ("events", "[[0.1]]", "is not an event"),
    "strange event": ("events", '[[0.1, "boom", 0, 0, 0, 0, "free", 0, 0, 0]]', "is not an event"),
    "strange state": ("events", '[[0.1, "impact", 0, 0, 0, 0, 1, 0, 0, 0]]', "is not an event"),
    "strange contact": (
        "contacts",
        '[[0.1, 0.2, "much", 0, 0, 0, 0]]',
        "contacts: 0: 2: Input should be a valid number",
    ),
    "short contact": ("contacts", "[[0.1, 0.2]]", "contacts: 0: 2: Field required"),
    "late event": ("events", '[[9.9, "impact", 0, 0, 0, 0, "free", 0, 0, 0]]', "times should be ascending"),
    "event at no time": ("events", '[[NaN, "impact", 0, 0, 0, 0, "free", 0, 0, 0]]', "times should be ascending"),
    "large number": ("events", f'[[{"9" * 5000}, "impact", 0, 0, 0, 0, 0, "free"]]', "Invalid JSON"),
    "no object": ("summary", "[]", "should be an object"),
    "no outcome": ("summary", '{"outcome": "done"}', "end_time: Field required"),
    "no toml": ("scenario", "end_time = [", "not valid TOML"),
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
    "wall_time": [],
    "macro_gap": "short",
    "macro_collisions": [{"start": 0.0}],
    "energy": {"initial": 1.0},
    "warnings": "no list",
    "clearance": {"distance": 0.0},
    "outcome": ["completed"],
}


@pytest.fixture(scope="module")
def summary(saved):
    return History.load(saved).summary


@pytest.mark.parametrize("key", SUMMARIES)
def test_every_key_of_the_summary_is_checked(crafted, summary, key):
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


@pytest.mark.parametrize("name", ["slip_rate", "tip_y"])
def test_a_missing_variable_is_named(crafted, name):
    with h5py.File(crafted, "r+") as root:
        del root[name]
    assert f"has no variable {name!r}" in refused(crafted)


# --- scenarios and sweeps


@pytest.mark.parametrize("read", [Scenario.load, load_plan])
def test_sources_without_end_or_beginning(tmp_path, read):
    fifo, large = tmp_path / "fifo.toml", tmp_path / "large.toml"
    os.mkfifo(fifo)
    with large.open("wb") as file:
        file.truncate(10 * 10**9)
    for source in (fifo, large, "/dev/zero", tmp_path, "x" * 5000, "a\0b"):
        with pytest.raises(InputError) as error:
            read(str(source))
        assert len(str(error.value).splitlines()) == 1


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
        with pytest.raises(InputError) as error:
            read(NESTED[case])
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


def test_links_in_the_folder_of_a_run_are_replaced_not_followed(run, tmp_path):
    precious, out = tmp_path / "precious", tmp_path / "out"
    precious.write_text("mine")
    out.mkdir()
    for name in ("history.nc", "summary.json", "events.csv", "scenario.toml"):
        (out / name).symlink_to(precious)
    run("paper", "end_time=0.33").save(out)
    assert precious.read_text() == "mine"
    assert not (out / "summary.json").is_symlink()
