"""Many runs in one frame: kept, resumed, a row whatever happens; one function over many items."""

from __future__ import annotations

import math

import numpy as np
import pandas as pd
import pytest

from oblique_impact import InputError, Progress, Scenario
from oblique_impact.errors import Interrupted
from oblique_impact.validation.studies import study
from oblique_impact.validation.studies.parallel import Crash, compute_each, map_parallel
from oblique_impact.validation.studies.study import TABLE, StudyRun, reasons, run_study
from tests.processes import deadly, interrupt, started, wait_for

FALL = Scenario.builtin("paper", ["end_time=0.02", "contact.enabled=false"])


def runs(angles=(0.1, 0.2, 0.3), quantities=("theta@end", "tip_y@0.01")):
    return [StudyRun({"angle": angle}, FALL.replace(initial__angle=angle), quantities) for angle in angles]


def test_a_frame_has_a_row_for_each_run_with_units(tmp_path):
    told = []
    frame = run_study(runs(), tmp_path, workers=1, units={"angle": "rad"}, on_progress=told.append)
    assert frame["angle"].tolist() == [0.1, 0.2, 0.3]
    assert set(frame["outcome"]) == {"completed"}
    np.testing.assert_allclose(frame["tip_y@0.01"], np.sin(frame["angle"]), atol=1e-3)
    assert [p.done for p in told] == [0, 1, 2, 3]
    kept = pd.read_parquet(tmp_path / TABLE)
    pd.testing.assert_frame_equal(kept, frame)
    units = {"angle": "rad", "tip_y@0.01": "m", "stopped_at": "s"}
    assert units.items() <= kept.attrs["units"].items()
    assert kept.attrs["meanings"]["theta@end"] == "angle of the floating frame at the end"


def test_rows_are_taken_from_the_folder_if_scenario_and_quantities_are_the_same(tmp_path):
    """A mark put into a row on disk comes out, until something that decides about the row differs."""
    run_study(runs(), tmp_path, workers=1)
    frame = pd.read_parquet(tmp_path / TABLE)
    frame.loc[1, "steps"] = 777
    frame.to_parquet(tmp_path / TABLE)
    assert (run_study(runs((0.2, 0.25)), tmp_path, workers=1)["steps"] == 777).tolist() == [True, False]
    assert run_study(runs((0.2,), ("theta@end",)), tmp_path, workers=1)["steps"].tolist() != [777]


def test_a_folder_of_another_study_or_with_a_damaged_table_is_refused(tmp_path):
    run_study(runs(), tmp_path, workers=1)
    with pytest.raises(InputError, match="holds runs of another study"):
        run_study(runs((0.1, 0.2)), tmp_path, workers=1, exclusive=True)
    (tmp_path / TABLE).write_bytes(b"PAR1 and nothing")
    with pytest.raises(InputError, match="not a readable table"):
        run_study(runs(), tmp_path, workers=1)


def test_an_interrupt_keeps_the_finished_rows(tmp_path, monkeypatch):
    simulate, count = study.simulate, iter(range(9))

    def twice(*arguments, **options):
        if next(count) == 2:
            raise Interrupted(None)
        return simulate(*arguments, **options)

    with monkeypatch.context() as patch:
        patch.setattr(study, "simulate", twice)
        with pytest.raises(KeyboardInterrupt, match="2 of 3 runs are kept"):
            run_study(runs(), tmp_path, workers=1)
    told: list[Progress] = []
    run_study(runs(), tmp_path, workers=1, on_progress=told.append)
    assert [p.done for p in told] == [2, 3]


def test_failures_are_rows_with_their_reason(monkeypatch):
    """A timeout, values that do not fit together, a run that the physics stops; an error of the program."""
    steep = {"contact__mu_static": 20.0, "contact__mu_kinetic": 20.0, "discretization__frame": "mean-axis"}
    rough = Scenario.builtin("paper").replace(end_time=0.4, discretization__modes=3, **steep)
    every = [
        StudyRun({"n": 1}, Scenario.builtin("paper").replace(end_time=50.0), ("impulse",)),
        StudyRun({"n": 2}, None, ("impulse",), "do not fit"),
        StudyRun({"n": 3}, rough, ("impulse", "first_impact")),
    ]
    frame = run_study(every, workers=1, timeout=0.3)
    assert frame["outcome"].tolist() == ["timeout", "invalid", "painleve"]
    assert frame["message"][0].startswith("took longer than 0.3 s, until t = ")
    assert frame["message"][1] == "do not fit"
    assert reasons(frame["gaps"][2])["impulse"].endswith("painleve")
    assert frame["first_impact"][2] == pytest.approx(0.31715, abs=1e-4)
    assert math.isnan(frame["impulse"][2])

    def broken(*_, **options):
        raise FloatingPointError("over\nflow")

    monkeypatch.setattr(study, "simulate", broken)
    row = run_study(runs((0.1,)), workers=1).iloc[0]
    assert (row["outcome"], row["message"]) == ("error", "FloatingPointError: over flow")


@pytest.mark.parametrize("workers", [1, 2])
def test_results_keep_the_order_of_the_items(workers):
    told = []
    assert map_parallel(math.sqrt, [9.0, 4.0, 1.0], workers, told.append) == [3.0, 2.0, 1.0]
    assert [p.done for p in told] == [0, 1, 2, 3]
    with pytest.raises(ValueError, match=r"negative|domain"):
        map_parallel(math.sqrt, [1.0, -1.0], workers)


def test_an_item_that_takes_its_process_down_costs_itself_alone():
    found = dict(compute_each(deadly, ["a", "b", "die", "c", "d", "e"], 2))
    assert found.pop(2) == Crash("its process ended: SIGKILL(-9)")
    assert found == {0: ("a", "1"), 1: ("b", "1"), 3: ("c", "1"), 4: ("d", "1"), 5: ("e", "1")}


LONG = """
quantities = ["impulse"]
changes.end_time = 0.4
[[axes]]
keys = ["contact.mu_static", "contact.mu_kinetic"]
range = [0.0, 1.0]
count = 400
"""


def test_ctrl_c_in_a_terminal_keeps_what_is_done(tmp_path):
    """Two processes, which hear of it too."""
    (tmp_path / "long.toml").write_text(LONG)
    with started("sweep", tmp_path / "long.toml", "--out", tmp_path / "a", "--workers", 2) as process:
        wait_for(lambda: (tmp_path / "a" / TABLE).exists())
        err = interrupt(process, group=True)
    assert process.returncode == 130
    assert "Traceback" not in err
    assert "of 400 runs are kept" in err
    assert len(pd.read_parquet(tmp_path / "a" / TABLE)) > 0
