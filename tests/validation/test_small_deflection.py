"""The study of small deflections: its problems, its errors, report and command."""

from __future__ import annotations

import csv
import json

import pytest
from matplotlib.figure import Figure

from oblique_impact import InputError, Progress
from oblique_impact.validation.small_deflection.command import lines, small_deflection
from oblique_impact.validation.small_deflection.errors import MODELS, case_of, points_of
from oblique_impact.validation.small_deflection.report import COLOURS, draw_map


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    told: list[Progress] = []
    folder = tmp_path_factory.mktemp("map")
    result = small_deflection(
        deflections=(0.03, 0.1), spins=(0.0,), out=folder, workers=1, command="repeat", on_progress=told.append
    )
    return result, folder, told


def test_kinetics_and_frames_err_as_they_should(study):
    result, *_ = study
    error = {(p.problem, p.model, p.nominal): p.error for p in result.points}
    assert error["hub", "tangent, first order", 0.1] < 0.005
    assert error["hub", "tangent, zeroth order", 0.1] > 0.3
    assert error["pendulum", "mean axis, first order", 0.03] == pytest.approx(0.019, rel=0.2)
    # a square law: three times the deflection, nine times the error
    full = "hub", "tangent, full"
    assert error[*full, 0.1] / error[*full, 0.03] == pytest.approx((0.1 / 0.03) ** 2, rel=0.25)
    # the geometric stiffening that linear bending leaves out, whether a torque or the weight bends the beam
    assert error["held", "tangent, full", 0.1] == pytest.approx(2.4 * 0.1**2, rel=0.4)
    assert error["held", "tangent, first order", 0.1] < error["held", "tangent, full", 0.1]
    # a light hub turns with the beam
    assert error["light hub", "tangent, first order", 0.1] > 3.0 * error["hub", "tangent, first order", 0.1]
    assert error["stop", "tangent, first order", 0.1] < 0.03
    stopped = {p.outcome for p in result.of("pendulum", "tangent, first order")}
    assert stopped == {"mass-matrix-indefinite"}


def test_report_has_every_point_and_the_picture(study):
    result, folder, told = study
    rows = json.loads((folder / "results.json").read_text())["points"]
    assert len(rows) == len(result.points) == 2 * sum(map(len, MODELS.values()))
    with (folder / "results.csv").open() as file:
        assert next(iter(csv.DictReader(file)))["model"] == rows[0]["model"]
    page = (folder / "report.html").read_text()
    assert page.count("<svg") == 1
    assert all(model in page for models in MODELS.values() for model in models)
    assert [progress.done for progress in told] == list(range(2 * len(MODELS) + 1))
    assert any("tangent, first order" in line and "(w/L)^2" in line for line in lines(result))


def test_picture_has_a_curve_of_its_own_colour_for_each_model(study):
    result, *_ = study
    figure = Figure()
    draw_map(figure, result.points)
    for axes, (problem, models) in zip(figure.axes, MODELS.items(), strict=True):
        drawn = {
            line.get_color() for line in axes.lines if len(line.get_xdata()) == 2 and line.get_marker() == "o"
        }
        assert drawn == {COLOURS[model] for model in models}, problem
        assert len(drawn) == len(models)
        assert axes.get_xlabel() == "largest deflection / length"
        labels = [text.get_text() for text in axes.get_legend().get_texts()]
        assert labels == [*models, "spin 0"]
    hub = figure.axes[list(MODELS).index("hub")]
    curve = next(line for line in hub.lines if line.get_color() == COLOURS["tangent, first order"])
    points = result.of("hub", "tangent, first order")
    assert list(curve.get_ydata()) == [point.error for point in points]
    assert list(curve.get_xdata()) == [point.deflection for point in points]


def test_runs_say_what_the_study_measures(study):
    """Estimates are the runs' own; where errors are clear of the steps they are within a factor of three."""
    result, *_ = study
    clear = [p for p in result.points if p.outcome == "completed" and "zeroth" not in p.model and p.error > 0.015]
    assert len(clear) > 3
    assert all(1.0 / 3.0 < p.estimate / p.error < 3.0 for p in clear), clear


def test_problems_are_what_they_are_called():
    hub = case_of("hub", 0.1, 2.0).scenario
    assert (hub.root.kind, hub.initial.angular_velocity, hub.gravity) == ("hub", 2.0, 0.0)
    assert hub.root.inertia == pytest.approx(30.0 / 3.0)
    assert case_of("pendulum", 0.1, 2.0).scenario.root.kind == "pin"
    held = case_of("held", 0.1, 2.0).scenario
    assert (held.root.kind, held.root.spin_rate, held.contact.enabled) == ("driven", 2.0, False)
    assert case_of("stop", 0.1, 0.0).scenario.contact.normal == "spring"
    with pytest.raises(KeyError):
        points_of(("nothing", 0.1, 0.0))


@pytest.mark.parametrize("numbers", [{"deflections": (0.0,)}, {"spins": (21.0,)}, {"deflections": ()}])
def test_numbers_out_of_range_are_refused(numbers):
    with pytest.raises(InputError, match="should be from 0 to"):
        small_deflection(**numbers)


@pytest.mark.parametrize(
    "option", [("--modes", "1,2,3"), ("--set", "gravity=9"), ("--within", "1e-2"), ("--predictability",)]
)
def test_command_refuses_what_does_not_apply(refused, option, tmp_path):
    line = refused("refine", "--study", "small-deflection", *option, "--out", tmp_path / "map")
    assert f"{option[0]} together with --study small-deflection: does not apply" in line
