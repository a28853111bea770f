"""Killed at random moments, what is on disk is whole or absent."""

from __future__ import annotations

import json
import os
import random
import signal
import time
import tomllib

import pytest

from oblique_impact import History
from tests.processes import started, wait_for

FOUR = {"events.csv", "history.nc", "scenario.toml", "summary.json"}


@pytest.mark.slow
def test_a_killed_run_leaves_whole_files_or_none(run, tmp_path):
    run("paper")  # the kernels are compiled
    moments = random.Random(2016)
    seen = set()
    for _ in range(25):
        with started("run", "paper", "--set", "end_time=0.8", "--out", tmp_path) as process:
            # around the instant at which the files are written
            wait_for(lambda: any(".part" in p.name for p in tmp_path.iterdir()) or process.poll() is not None)
            time.sleep(moments.uniform(0.0, 0.05))
            if process.poll() is None:
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()
        names = {path.name for path in tmp_path.iterdir() if not path.name.startswith(".")}
        assert names <= FOUR
        seen.add(len(names))
        if "history.nc" in names:
            assert History.load(tmp_path).summary["outcome"] == "completed"
        if "summary.json" in names:
            assert json.loads((tmp_path / "summary.json").read_text())["outcome"] == "completed"
        if "scenario.toml" in names:
            assert tomllib.loads((tmp_path / "scenario.toml").read_text())["end_time"] == 0.8
        for path in tmp_path.iterdir():
            path.unlink()
    assert 0 in seen  # some were killed while they wrote
