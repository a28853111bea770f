"""Whatever stands in a file: exit code 0, 1 or 2, one line, no traceback, no end in sight neither."""

from __future__ import annotations

import contextlib
import faulthandler
import io
import json
import os
import resource
import string
import sys
import tempfile
import tomllib
from pathlib import Path

import h5netcdf
import h5py
import numpy as np
import pytest
import tomli_w
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from oblique_impact import History, InputError, Interrupted, Scenario, simulate
from oblique_impact.command_line.application import main
from oblique_impact.renders import export
from oblique_impact.renders.player.content import content_of
from oblique_impact.renders.story import story_of
from oblique_impact.scenario.scenario import builtin_names
from oblique_impact.validation.studies.design import load_plan, make_plan, shipped_names

pytestmark = pytest.mark.slow

often = settings(max_examples=1500, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
seldom = settings(often, max_examples=300)

SWEEPS = [load_plan(name).to_toml().replace('"scenario.toml"', '"paper"') for name in shipped_names()]

numbers = st.one_of(
    st.floats(),
    st.integers(),
    st.sampled_from([0, -1, 1e308, 5e-324, 10**400, 2**63, -(2**63), 1e30, 1e-30, float("nan"), float("inf")]),
)
words = st.one_of(
    st.text(max_size=20),
    st.sampled_from(
        ["modal", "fem", "event", "paper", "../x", "scenario.toml", "contact.mu_static", "theta@end", "/"]
    ),
)
values = st.recursive(
    st.one_of(numbers, words, st.booleans(), st.dates(), st.datetimes()),
    lambda inner: st.one_of(st.lists(inner, max_size=4), st.dictionaries(words, inner, max_size=4)),
    max_leaves=8,
)


def one_line(error: InputError) -> None:
    line = str(error)
    assert line
    assert len(line.splitlines()) == 1
    assert line.isprintable()
    assert len(line) < 3000


@st.composite
def damaged(draw, texts):
    """A text with pieces that are gone, doubled, or replaced."""
    text = draw(st.sampled_from(texts))
    for _ in range(draw(st.integers(1, 5))):
        start = draw(st.integers(0, len(text)))
        end = start + draw(st.sampled_from([0, 1, 2, 10, 100]))
        piece = draw(
            st.one_of(
                st.sampled_from(
                    ["", "nan", "inf", "-1", "1e999", "[", "]", "{", "=", '"', "'''", "\0", "\n", "true"]
                ),
                st.text(alphabet=string.printable, max_size=10),
                st.just(text[start:end] * 2),
            )
        )
        text = text[:start] + piece + text[end:]
    return text


@st.composite
def changed(draw, texts):
    """A file with keys of other values, some of them new."""
    data = tomllib.loads(draw(st.sampled_from(texts)))
    for _ in range(draw(st.integers(1, 4))):
        target = data
        sections = [key for key, value in data.items() if isinstance(value, dict)]
        if sections and draw(st.booleans()):
            target = data[draw(st.sampled_from(sections))]
        key = draw(st.one_of(st.sampled_from(sorted(target) or ["x"]), words))
        target[key] = draw(values)
    try:
        return tomli_w.dumps(data)
    except (ValueError, TypeError):
        return ""


@seldom
@given(st.one_of(damaged(SWEEPS), changed(SWEEPS)))
def test_sweeps(text):
    try:
        plan = make_plan(text)
    except InputError as error:
        one_line(error)
    else:
        assert plan.design.size <= 100_000
        assert plan.fingerprint


# --- histories: in a process that may not take long, for HDF5 may crash


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    scenario = Scenario.builtin("paper", ["end_time=0.33", "solver.output_interval=5e-3"])
    folder = simulate(scenario).save(tmp_path_factory.mktemp("paper"))
    return (folder / "history.nc").read_bytes()


def use(file: Path) -> None:
    """Load a history; what loads is exported and made a page."""
    try:
        history = History.load(file)
        with tempfile.TemporaryDirectory() as folder, np.errstate(over="ignore", invalid="ignore"):
            for name in ("a.pvd", "a.xdmf"):
                export(history, Path(folder) / name, every=50)
            content_of(story_of([history]), 50)
    except InputError as error:
        one_line(error)


def in_a_process(action, *arguments) -> None:
    """Do something in a process of its own, of 20 s and 8 GB at most; an exception there is one here."""
    ours, theirs = os.pipe()
    child = os.fork()
    if child == 0:
        said = b""
        try:
            faulthandler.disable()
            resource.setrlimit(resource.RLIMIT_CPU, (20, 20))
            resource.setrlimit(resource.RLIMIT_AS, (8 * 2**30,) * 2)
            with contextlib.redirect_stderr(io.StringIO()):
                action(*arguments)
        except BaseException as error:
            said = f"{type(error).__name__}: {error}".encode()[:4000] or b"?"
        os.write(theirs, said)
        os._exit(0)
    os.close(theirs)
    with os.fdopen(ours, "rb") as pipe:
        said = pipe.read().decode(errors="replace")
    _, status = os.waitpid(child, 0)
    assert status == 0, f"ended by signal {os.WTERMSIG(status)}"
    assert not said, said


@st.composite
def bytes_changed(draw, size):
    """Where bytes change, and to what; headers are changed as often as everything else together."""
    place = st.one_of(st.integers(0, min(size, 20_000) - 1), st.integers(0, size - 1))
    return draw(st.lists(st.tuples(place, st.integers(0, 255)), min_size=1, max_size=30))


@pytest.mark.parametrize("part", range(4))
def test_histories_with_other_bytes(whole, tmp_path, part):
    file = tmp_path / "x.nc"
    # what older layouts of HDF5 do without a checksum is the harder test
    content = whole if part % 2 else older(whole, tmp_path)

    @settings(seldom, max_examples=250)
    @given(bytes_changed(len(content)), st.integers(0, 10**9))
    def damage(changes, _):
        damaged = bytearray(content)
        for place, value in changes:
            damaged[place] = value
        file.write_bytes(damaged)
        in_a_process(use, file)

    damage()


def older(content: bytes, folder: Path) -> bytes:
    """The same history in the oldest layout of HDF5, as other programs write it."""
    new, old = folder / "new.nc", folder / "old.nc"
    new.write_bytes(content)
    with h5py.File(new) as source, h5netcdf.File(old, "w", libver=("earliest", "v108")) as target:
        data = History.load(new).data
        target.dimensions = dict(data.sizes)
        for name, variable in data.variables.items():
            target.create_variable(name, variable.dims, data=variable.values)
        for name in ("format", "scenario", "events", "contacts", "summary"):
            target.attrs[name] = np.bytes_(source.attrs[name])
    assert History.load(old).events == History.load(new).events
    return old.read_bytes()


@seldom
@given(data=st.data())
def test_histories_cut_or_with_something_in_between(whole, data):
    start = data.draw(st.integers(0, len(whole)))
    end = data.draw(st.integers(start, len(whole)))
    content = whole[:start] + data.draw(st.binary(max_size=200)) + whole[end:]
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "x.nc"
        file.write_bytes(content)
        in_a_process(use, file)


def replace_variable(root, name: str, how: str, value: float, row: int, size: int, kind: str) -> None:
    old, shape = root[name][()], list(root[name].shape)
    if how == "value":
        old[row % shape[0]] = np.nan_to_num(value) if old.dtype.kind != "f" else value
    elif how == "shape":
        shape[row % len(shape)] = size
        old = np.zeros(shape)
    elif how == "type":
        old = np.nan_to_num(old).astype(kind)
    del root[name]
    if how != "gone":
        root[name] = old


@seldom
@given(
    name=st.integers(0, 10**6),
    how=st.sampled_from(["value", "shape", "type", "gone"]),
    value=st.sampled_from([np.nan, np.inf, 0.0, -1.0, 100.0, 1e308, 1e-308, 1e150, 1e12]),
    row=st.integers(0, 10**6),
    size=st.integers(0, 5),
    kind=st.sampled_from(["i1", "u8", "f2", "f4", ">f8", "S3", "?", "c8"]),
)
def test_histories_with_other_variables(whole, name, how, value, row, size, kind):
    with tempfile.TemporaryDirectory() as folder, np.errstate(all="ignore"):
        file = Path(folder) / "x.nc"
        file.write_bytes(whole)
        with h5py.File(file, "r+") as root:
            names = sorted(key for key in root if key != "coordinate")
            value = min(max(value, -100.0), 100.0) if names[name % len(names)] == "state" else value
            replace_variable(root, names[name % len(names)], how, value, row, size, kind)
        in_a_process(use, file)


@seldom
@given(data=st.data())
def test_histories_with_other_attributes(texts, whole, data):
    label = data.draw(st.sampled_from(sorted(texts)))
    text = data.draw(st.one_of(damaged([texts[label]]), values.map(lambda v: json.dumps(v, default=str))))
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "x.nc"
        file.write_bytes(whole)
        with h5py.File(file, "r+") as root:
            root.attrs[label] = np.bytes_(text.replace("\0", "").encode()[:60_000] or b" ")
        in_a_process(use, file)


@pytest.fixture(scope="module")
def texts(whole):
    with h5py.File(io.BytesIO(whole)) as root:
        found = {label: root.attrs[label] for label in ("events", "summary", "scenario", "format")}
    return {label: text if isinstance(text, str) else text.decode() for label, text in found.items()}


# --- runs


@st.composite
def scenarios(draw):
    """Possible scenarios of impossible things."""
    data = Scenario.builtin(draw(st.sampled_from(builtin_names()))).model_dump()
    data["end_time"] = min(data["end_time"], 0.05)
    extremes = st.sampled_from([0.0, 1e-30, 1e-12, 1e-6, 1e-3, 0.1, 1.0, 10.0, 1e3, 1e6, 1e12, 1e20, 1e30])
    for _ in range(draw(st.integers(1, 4))):
        section = draw(st.sampled_from([name for name, value in data.items() if isinstance(value, dict)]))
        key = draw(st.sampled_from(sorted(data[section])))
        if isinstance(data[section][key], float):
            data[section][key] = draw(st.one_of(extremes, extremes.map(lambda x: -x)))
        elif isinstance(data[section][key], int) and not isinstance(data[section][key], bool):
            data[section][key] = draw(st.sampled_from([0, 1, 3, 10]))
    return data


@pytest.fixture(scope="module")
def compiled():
    """A process of its own that had to compile would be taken for one that hangs."""
    nodal = ("discretization.method=fem", "discretization.modes=0", "discretization.elements=4")
    for changes in ((), ("solver.scheme=fixed-step",), ("solver.scheme=generalized-alpha",)):
        simulate(Scenario.builtin("paper", ["end_time=0.35", "discretization.frame=mean-axis", *changes]))
    simulate(
        Scenario.builtin(
            "paper",
            ["end_time=0.35", "discretization.frame=mean-axis", "solver.scheme=generalized-alpha", *nodal],
        )
    )


@seldom
@given(data=scenarios())
def test_runs(compiled, data):
    try:
        scenario = Scenario.from_dict(data)
    except InputError as error:
        one_line(error)
        return
    in_a_process(run_for_a_second, scenario)


def run_for_a_second(scenario: Scenario) -> None:
    """Run until it ends, or a second long: by then it must have told its progress, and it must stop when told."""
    import time

    clock = time.monotonic()

    def stop(status):
        if time.monotonic() - clock > 1.0:
            raise KeyboardInterrupt

    with np.errstate(all="ignore"):
        try:
            history = simulate(scenario, stop)
        except Interrupted as interrupted:
            history = interrupted.history
    with tempfile.TemporaryDirectory() as folder:
        History.load(history.save(folder))


@pytest.mark.parametrize("change", ["end_time=1e30", "solver.output_interval=1e-30", "solver.free_step=1e-30"])
def test_what_would_never_end_is_refused(tmp_path, capfd, change):
    scheme = ("--set", "solver.scheme=fixed-step")
    with pytest.raises(SystemExit) as stopped:
        main(["run", "paper", *scheme, "--set", change, "--out", str(tmp_path / "never")])
    assert stopped.value.code == 2
    assert capfd.readouterr().err.count("\n") == 1
    assert sys.getrecursionlimit() < 10_000
