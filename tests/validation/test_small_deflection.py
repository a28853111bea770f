"""The study of small deflections: its problems, its errors, report and command."""

from __future__ import annotations

import pytest

from oblique_impact import InputError
from oblique_impact.validation.studies.small_deflection import small_deflection


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    folder = tmp_path_factory.mktemp("map")
    result = small_deflection(deflections=(0.1,), spins=(0.0,), out=folder, workers=1)
    return result, folder


def test_kinetics_and_frames_err_as_they_should(study):
    result, _ = study
    error = {(p.problem, p.model): p.error for p in result.points.itertuples()}
    assert error["hub", "tangent, first order"] < 0.005
    assert error["hub", "tangent, zeroth order"] > 0.3
    # the geometric stiffening that linear bending leaves out, whether a torque or the weight bends the beam
    assert error["held", "tangent, full"] == pytest.approx(2.4 * 0.1**2, rel=0.4)
    assert error["held", "tangent, first order"] < error["held", "tangent, full"]
    # a light hub turns with the beam
    assert error["light hub", "tangent, first order"] > 3.0 * error["hub", "tangent, first order"]
    assert error["stop", "tangent, first order"] < 0.03
    outcomes = result.points.set_index(["problem", "model"])["outcome"]
    assert outcomes["pendulum", "tangent, first order"] == "mass-matrix-indefinite"


@pytest.mark.slow
def test_errors_grow_with_the_square_of_the_deflection(study):
    """Three times the deflection, nine times the error."""
    smaller = small_deflection(deflections=(0.03,), spins=(0.0,))
    small, large = (
        {(p.problem, p.model): p.error for p in found.points.itertuples()} for found in (smaller, study[0])
    )
    full = "hub", "tangent, full"
    assert small["pendulum", "mean axis, first order"] == pytest.approx(0.019, rel=0.2)
    assert large[full] / small[full] == pytest.approx((0.1 / 0.03) ** 2, rel=0.25)


def test_runs_say_what_the_study_measures(study):
    """Estimates are the runs' own; where errors are clear of the steps they are within a factor of three."""
    result, _ = study
    clear = result.points.query("outcome == 'completed' and error > 0.015")
    clear = clear[~clear["model"].str.contains("zeroth")]
    assert len(clear) > 3
    assert (clear["estimate"] / clear["error"]).between(1.0 / 3.0, 3.0).all(), clear


@pytest.mark.parametrize("numbers", [{"deflections": (0.0,)}, {"spins": (21.0,)}, {"deflections": ()}])
def test_numbers_out_of_range_are_refused(numbers):
    with pytest.raises(InputError, match="should be from 0 to"):
        small_deflection(**numbers)
