"""The command `compare`: a page or numbers, one line for what is wrong."""

from __future__ import annotations

import html
import json

import pytest

from oblique_impact.validation import compare


def test_two_runs_become_a_page_or_numbers(run, tmp_path, cli):
    histories = run("paper", "end_time=0.33"), run("paper", "end_time=0.33", "discretization.method=fem")
    folders = [history.save(tmp_path / name) for name, history in zip("ab", histories, strict=True)]
    for suffix in ("html", "json"):
        code, out, err = cli("compare", *folders, "--out", tmp_path / "new" / f"c.{suffix}")
        assert (code, err) == (0, "")
        assert out.startswith(f"{folders[0]} and {folders[1]}, 0 to 0.33 s\noutcome: completed\nevents: ")
        assert out.endswith(f"report: {tmp_path}/new/c.{suffix}\n")
    found = compare(*histories)
    data = json.loads((tmp_path / "new" / "c.json").read_text())
    assert data["largest_shift"] == found.largest_shift
    assert {v["name"]: v["aligned"]["rms"] for v in data["variables"]} == {
        name: v.aligned.rms for name, v in found.variables.items()
    }
    assert f"oblique-impact compare {folders[0]} {folders[1]}" in (tmp_path / "new" / "c.html").read_text()


def test_differing_keys_and_warnings_are_told(run, tmp_path, cli):
    """Of an undamped beam on a rigid stop, which is warned of, and one with a damping that its modes resolve."""
    alike = ("paper", "end_time=0.33", "discretization.modes=4")
    histories = run(*alike), run(*alike, "beam.kelvin_voigt=2e-4")
    folders = [history.save(tmp_path / name) for name, history in zip("ab", histories, strict=True)]
    found = compare(*histories)
    assert found.changed_keys == {"beam.kelvin_voigt": (0.0, 2e-4)}
    assert compare(histories[0], histories[0]).changed_keys == {}
    (warning,) = histories[0].summary["warnings"]
    assert histories[1].summary["warnings"] == []
    assert (str(folders[0]), warning) in compare(*histories, names=tuple(map(str, folders))).warnings
    for suffix in ("html", "json"):
        _, out, _ = cli("compare", *folders, "--out", tmp_path / f"c.{suffix}")
        assert "beam.kelvin_voigt: 0.0 in" in out
        assert warning in out
    page = html.unescape((tmp_path / "c.html").read_text())
    assert "beam.kelvin_voigt" in page
    assert warning in page
    data = json.loads((tmp_path / "c.json").read_text())
    assert data["changed_keys"] == {"beam.kelvin_voigt": [0.0, 2e-4]}
    assert [entry["warning"] for entry in data["warnings"]] == [warning]


BAD = {
    "not a run": ("nowhere", "nowhere", "c.html", "nowhere"),
    "another kind of file": ("nowhere", "nowhere", "c.pdf", "should end in .html or .json"),
    "one run": ("nowhere", None, "c.html", "RIGHT"),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_input_is_one_line_and_exit_2(tmp_path, refused, case):
    left, right, out, part = BAD[case]
    assert part in refused("compare", *filter(None, (left, right)), "--out", tmp_path / "never" / out)
    assert not (tmp_path / "never").exists()
