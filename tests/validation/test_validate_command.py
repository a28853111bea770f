"""`oblique-impact validate`: files, exit codes, the same report twice."""

from __future__ import annotations

import html
import json
import re
import shlex
import shutil

import pandas as pd
import pytest

from oblique_impact.validation.suite import select

KEYS = {
    *("id", "group", "problem", "quantity", "computed", "reference", "unit", "error", "tolerance", "verdict"),
    "source",
}


def test_files_console_and_page_hold_the_same_rows(tmp_path, cli):
    only = ("--only", "frequencies", "--only", "small-systems.belt")
    code, out, err = cli("validate", "--out", tmp_path, *only, "--workers", "1")
    assert (code, err) == (0, "")
    checks = json.loads((tmp_path / "results.json").read_text(encoding="utf-8"))["checks"]
    assert all(set(check) == KEYS for check in checks)
    assert {check["group"] for check in checks} == {"frequencies", "small-systems"}
    assert out.startswith(f"checks: {len(checks)} pass (")
    assert {check["verdict"] for check in checks} == {"pass"}
    table = pd.read_csv(tmp_path / "results.csv")
    assert table["id"].to_list() == [check["id"] for check in checks]
    assert table["computed"].to_list() == pytest.approx([check["computed"] for check in checks], rel=1e-14)
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert all(check["id"] in page for check in checks)
    assert f"<dd>checks: {len(checks)} pass</dd>" in page
    assert page.count('<p class="note">Reference: ') == len(select(("frequencies", "small-systems.belt")))
    assert 'class="count">6 measurements<' in page


def test_the_command_of_a_report_can_be_typed_again(tmp_path, cli, monkeypatch):
    monkeypatch.chdir(tmp_path)
    words = ["--out", "a folder", "--only", "small-systems.belt", "--only", "frequencies.clamped-free"]
    cli("validate", *words, "--workers", "1")
    page = (tmp_path / "a folder" / "report.html").read_text(encoding="utf-8")
    (shown,) = re.findall(r"<dt>command</dt><dd[^>]*><code>(.*?)</code>", page)
    typed = shlex.split(html.unescape(shown))
    assert typed == ["oblique-impact", "validate", *words, "--workers", "1"]
    first = contents(tmp_path / "a folder")
    shutil.rmtree("a folder")
    cli("validate", *typed[2:])
    assert contents(tmp_path / "a folder") == first


def contents(folder):
    """Everything but the times."""
    texts = {path.name: path.read_text(encoding="utf-8") for path in folder.iterdir()}
    return {name: re.sub(r'<dd class="time">.*?</dd>', "", text) for name, text in texts.items()}


def test_bad_names_are_one_line(tmp_path, refused):
    words = "--only nothing: should be a group ("
    assert words in refused("validate", "--out", tmp_path / "new", "--only", "nothing")
    assert not (tmp_path / "new").exists()


def test_a_check_that_fails_ends_with_exit_code_1(tmp_path, cli, monkeypatch):
    from oblique_impact.validation.checks import spectra

    monkeypatch.setitem(spectra.VALUES, "1.1", [1.9] * 10)
    code, out, err = cli("validate", "--out", tmp_path, "--only", "frequencies.clamped-free", "--workers", "1")
    assert code == 1
    assert out.startswith("checks: 4 fail (")
    assert "frequencies.clamped-free.root-1" in out
    assert err == ""
    assert "fail" in (tmp_path / "report.html").read_text(encoding="utf-8")
