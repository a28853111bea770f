"""`oblique-impact export` as other programs call it."""

from __future__ import annotations

import os
import re
import runpy
import stat
import subprocess
import sys
import time
from unittest.mock import MagicMock

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from oblique_impact.renders import export
from oblique_impact.renders.exports import selection
from tests.renders.export_readers import read

FORMATS = ("vtkhdf", "pvd", "xdmf")


@pytest.fixture(scope="module")
def folder(run, tmp_path_factory):
    return run("paper", "end_time=0.34").save(tmp_path_factory.mktemp("paper"))


@pytest.mark.parametrize("format", FORMATS)
def test_export_says_what_it_wrote_and_nothing_else(folder, tmp_path, cli, format):
    target = tmp_path / "new" / f"beam.{format}"
    code, out, err = cli("export", folder, "--format", format, "--out", target, "--every", 400)
    assert code == 0
    assert err == ""
    frames = read(target)
    forecast, done, file, readers, opened = out.splitlines()
    assert re.fullmatch(rf"{len(frames)} frames, about [\d.]+ MB", forecast)
    times = np.array([frame.stamp for frame in frames])
    jumps = int(np.sum(times[1:] == np.nextafter(times[:-1], np.inf)))
    assert re.match(rf"{len(frames)} of \d+ samples, 0 to 0.34 s, both sides of {jumps} jumps; ", done)
    assert "true shapes (deformation factor 1)" in done
    assert file == f"  {format}: {target}"
    assert readers.startswith("  read by ParaView 5.1")
    assert (
        opened == f"  in ParaView with colours and arrows: paraview --script={target.with_suffix('.paraview.py')}"
    )
    assert float(frames[0].fields["deformation_factor"]) == 1.0


def test_the_state_for_paraview_has_the_parts_colours_and_arrow_of_the_run(run, tmp_path, monkeypatch):
    """What it tells ParaView, which is not there: the numbers of the parts, Pa and N as they are in the file."""
    history = run("paper", "end_time=0.34")
    exported = export(history, tmp_path / "beam.pvd", every=5000)
    names = re.findall(r"\b(?<!\.)([A-Z]\w+)\(", exported.state.read_text(encoding="utf-8"))
    simple = MagicMock(__all__=sorted(set(names)))
    monkeypatch.setitem(sys.modules, "paraview", MagicMock(simple=simple))
    monkeypatch.setitem(sys.modules, "paraview.simple", simple)
    monkeypatch.setattr(sys, "argv", ["pvpython"])
    runpy.run_path(str(exported.state))
    parts = [line.partition(" = ")[2] for line in read(exported.file)[0].fields["parts"].splitlines()]
    asked = [call.kwargs["LowerThreshold"] for call in simple.Threshold.call_args_list]
    assert [parts[number] for number in asked] == ["surface", "pin", "slope", "contact_point"]
    (low, high), _ = simple.GetColorTransferFunction.return_value.RescaleTransferFunction.call_args
    largest = float(np.abs(history["bending_stress"].values).max())
    assert largest <= high == -low <= 1.35 * largest
    assert simple.GetScalarBar.return_value.Title == "bending stress (Pa)"
    peak = float(np.hypot(history["lambda_n"], history["lambda_tau"]).max())
    arrow = simple.Glyph.return_value
    assert arrow.OrientationArray == arrow.ScaleArray == ["POINTS", "contact_force"]
    assert arrow.ScaleFactor * peak == pytest.approx(0.16)  # of the length of 1 m
    assert simple.AnnotateTimeFilter.call_args.kwargs["Format"] == "t = {time:.5f} s"


@pytest.mark.parametrize("format", FORMATS)
def test_names_with_signs_of_xml_and_python(run, tmp_path, monkeypatch, format):
    """Other programs find the numbers of an export whatever its name, and the state opens that file alone."""
    history = run("paper", "end_time=0.34")
    name = f'a & b < \'c\' """; raise SystemExit #.{format}'
    exported = export(history, tmp_path / name, every=5000)
    assert len(read(exported.file)) == exported.samples
    names = re.findall(r"\b(?<!\.)([A-Z]\w+)\(", exported.state.read_text(encoding="utf-8"))
    simple = MagicMock(__all__=sorted(set(names)))
    monkeypatch.setitem(sys.modules, "paraview", MagicMock(simple=simple))
    monkeypatch.setitem(sys.modules, "paraview.simple", simple)
    monkeypatch.setattr(sys, "argv", ["pvpython"])
    runpy.run_path(str(exported.state))
    opened = [call.kwargs["FileName"] for call in simple.mock_calls if "FileName" in call.kwargs]
    assert opened == [str(exported.file)]


def test_all_takes_every_sample_and_the_default_an_even_choice(folder, tmp_path, cli, monkeypatch):
    with xr.open_dataset(folder / "history.nc") as data:
        times = data["time"].values
    code, out, _ = cli("export", folder, "--out", tmp_path / "all.vtkhdf", "--all", "--between", "0.315,0.316")
    inside = int(np.sum((times >= 0.315) & (times <= 0.316)))
    assert (code, len(read(tmp_path / "all.vtkhdf"))) == (0, inside)
    assert out.startswith(f"{inside} frames, about ")
    monkeypatch.setattr(selection, "FRAMES", 30)  # a thousand take long
    code, out, _ = cli("export", folder, "--out", tmp_path / "beam.vtkhdf")
    count, whole = re.match(r"(\d+) frames, about [\d.]+ MB \(--all: (\d+) frames, [\d.]+ [MG]B\)\n", out).groups()
    assert (code, int(whole)) == (0, times.size)
    assert 30 <= int(count) <= 60


@pytest.mark.parametrize("case", ["paper", "elastic-stop"])
def test_a_table_of_the_time_series_is_read_back_as_it_was(run, tmp_path, case):
    history = run(case, "end_time=0.32")
    exported = export(history, tmp_path / "series", format="csv")
    table = pd.read_csv(exported.file)
    assert list(table)[:1] == ["time (s)"]
    assert {"lambda_n (N)", "theta (rad)", "energy_kinetic (J)"} <= set(table)
    names = [label.rpartition(" (")[0] for label in table]
    pd.testing.assert_frame_equal(
        table.set_axis(names, axis=1), history.time_series, check_dtype=False, rtol=1e-15
    )
    last = history["q"].sizes["coordinate"] - 1
    np.testing.assert_allclose(table[f"q_{last} (m or rad)"], history["q"].values[:, -1], rtol=1e-15)
    some = export(history, tmp_path / "some.csv", between=(0.1, 0.2), every=10)
    assert 0.1 <= pd.read_csv(some.file)["time (s)"].iloc[0] < 0.102


def test_a_history_file_alone_is_enough(folder, tmp_path, cli):
    alone = tmp_path / "alone.nc"
    alone.write_bytes((folder / "history.nc").read_bytes())
    assert cli("export", alone, "--out", tmp_path / "beam.pvd", "--every", 5000)[0] == 0
    assert len(read(tmp_path / "beam.pvd")) > 10


def test_options_select(folder, tmp_path, cli):
    with xr.open_dataset(folder / "history.nc") as data:
        times = data["time"].values
    arguments = ("--between", "0.31,0.33", "--around-events", "1e-3", "--deformation", "4", "--every", "3")
    code, out, _ = cli("export", folder, "--out", tmp_path / "beam.vtkhdf", *arguments)
    assert code == 0
    assert "magnified shapes (deformation factor 4)" in out
    frames = read(tmp_path / "beam.vtkhdf")
    found = np.array([frame.fields["time"] for frame in frames])
    assert np.all((found >= 0.31) & (found <= 0.33))
    assert np.all(np.isin(found, times))
    assert frames[0].fields["deformation_factor"] == 4.0


def test_suffix_and_format(folder, tmp_path, cli, refused):
    """A missing suffix is appended, a wrong one refused; a missing format is read from the suffix."""
    assert cli("export", folder, "--format", "pvd", "--out", tmp_path / "a", "--every", 5000)[0] == 0
    assert (tmp_path / "a.pvd").is_file()
    assert cli("export", folder, "--out", tmp_path / "b.xdmf", "--every", 5000)[0] == 0
    assert (tmp_path / "b.h5").is_file()
    assert "should end in .pvd" in refused("export", folder, "--format", "pvd", "--out", tmp_path / "c.vtkhdf")
    assert "--format" in refused("export", folder, "--out", tmp_path / "c")
    assert sorted(p.name for p in tmp_path.iterdir()) == [
        *("a", "a.paraview.py", "a.pvd"),
        *("b.h5", "b.paraview.py", "b.xdmf"),
    ]


BAD = {
    ("--format", "stl"): "--format stl",
    ("--every", "0"): "--every",
    ("--every", "x"): "--every",
    ("--between", "0.5,0.1"): "--between",
    ("--between", "0.5"): "--between",
    ("--between", "a,b"): "--between",
    ("--between", "nan,1"): "--between",
    ("--between", "5,6"): "covers 0 to 0.34 s",
    ("--around-events", "-1"): "--around-events",
    ("--around-events", "inf"): "--around-events",
    ("--deformation", "0"): "--deformation",
    ("--deformation", "nan"): "--deformation",
    ("--every", "5", "--all"): "--all and --every",
    ("--nonsense",): "--nonsense",
}


@pytest.mark.parametrize("options", BAD, ids=" ".join)
def test_bad_options_are_one_line_and_exit_2(folder, tmp_path, refused, options):
    place = tmp_path / "new" / "beam"
    assert BAD[options] in refused("export", folder, "--out", place, "--format", "pvd", *options)
    assert list(tmp_path.iterdir()) == []


def test_what_is_not_a_history_is_one_line(folder, tmp_path, refused):
    text, cut, beamless = tmp_path / "text.nc", tmp_path / "cut.nc", tmp_path / "beamless.nc"
    text.write_text("not a history")
    whole = (folder / "history.nc").read_bytes()
    cut.write_bytes(whole[: len(whole) // 2])
    with xr.open_dataset(folder / "history.nc") as data:
        data.load().drop_vars("shear").to_netcdf(beamless, engine="h5netcdf")
    for source in (text, cut, beamless, tmp_path / "missing", tmp_path):
        err = refused("export", source, "--out", tmp_path / "new" / "beam.pvd")
        assert ("has no variable 'shear'" if source == beamless else str(source)) in err
    assert not (tmp_path / "new").exists()


@pytest.mark.parametrize("format", FORMATS)
def test_places_that_cannot_be_written_are_one_line(folder, tmp_path, refused, format):
    (tmp_path / "file").write_text("in the way")
    (tmp_path / f"dir.{format}").mkdir()
    for target in (tmp_path / "file" / "beam", tmp_path / "dir", ".", "/"):
        assert "--out" in refused("export", folder, "--format", format, "--out", target)
    if os.geteuid() != 0:
        tmp_path.chmod(stat.S_IREAD | stat.S_IEXEC)
        refused("export", folder, "--format", format, "--out", tmp_path / "new")


EXPORTS = """
import resource, sys
from oblique_impact.command_line.application import main
for target in sys.argv[2:]:
    bound = 20_000 if target.endswith(".pvd") else 1_000_000
    resource.setrlimit(resource.RLIMIT_FSIZE, (bound, resource.RLIM_INFINITY))
    try:
        main(["export", sys.argv[1], "--out", target, "--every", "10"])
    except SystemExit as ended:
        assert ended.code == 2
"""


def test_a_full_disk_is_one_line_and_leaves_nothing(folder, tmp_path):
    """A bound on the size of files stands for the disk; frames of PVD are small files of their own."""
    targets = [tmp_path / f"beam.{format}" for format in FORMATS]
    done = subprocess.run(
        [sys.executable, "-c", EXPORTS, folder, *targets], capture_output=True, text=True, timeout=120
    )
    assert done.returncode == 0, done.stderr
    assert re.fullmatch(r"(\d+ frames(, about [\d.]+ MB)?\n){3}", done.stdout)
    assert re.fullmatch(r"(oblique-impact: .*cannot be written.*\n){3}", done.stderr)
    assert list(tmp_path.iterdir()) == []


def test_a_killed_export_leaves_an_earlier_one_alone(folder, tmp_path, cli):
    target = tmp_path / "beam.pvd"
    assert cli("export", folder, "--out", target, "--every", 5000)[0] == 0
    count = len(read(target))
    process = subprocess.Popen(
        [sys.executable, "-m", "oblique_impact", "export", folder, "--out", target, "--all"],
        stderr=subprocess.PIPE,
    )
    wait_until_under_way(process, tmp_path)
    process.kill()
    assert process.communicate()[1] == b""
    assert len(read(target)) == count


def wait_until_under_way(process, folder):
    while len(list(folder.glob("*.part/*"))) < 40:
        assert process.poll() is None
        time.sleep(0.01)
