"""What a history tells when it is asked: at a time, as tables, in words."""

import copy
import pickle

import numpy as np
import pytest

from oblique_impact import InputError, Scenario, simulate
from oblique_impact.history.at_a_time import dataset_at, value_at
from oblique_impact.history.sample_times import ascending


@pytest.fixture(scope="module")
def history(run):
    return run("paper", "end_time=0.35", "solver.output_interval=1e-3")


@pytest.fixture(scope="module")
def fine(run):
    return run("paper", "end_time=0.35", "solver.output_interval=1e-4")


def test_between_samples(history, fine):
    """Cubics through samples 1 ms apart meet those of a finer run in flight."""
    for time in (0.0505, 0.2004):
        now, then = history.at(time), fine.at(time)
        assert float(now["theta"]) == pytest.approx(float(then["theta"]), abs=5e-7)  # a line: 2e-6
        assert float(now["gap"]) == pytest.approx(float(then["gap"]), abs=5e-7)
        np.testing.assert_allclose(now["uy"], then["uy"], atol=1e-6)
    assert float(history.at(0.05)["theta"]) == float(history["theta"].sel(time=0.05))


def test_a_cubic_does_not_reach_across_a_jump():
    """Lines of slope 1, 10 higher after the jump at 1 s: half a second beside it they are still lines."""
    times = ascending(np.array([0.0, 1.0, 1.0, 2.0, 3.0]))
    values = times + 10.0 * (np.arange(5) > 1)
    assert float(value_at(times, values, None, 1.5)) == pytest.approx(11.5, rel=1e-12)
    assert float(value_at(times, values, None, 0.5)) == pytest.approx(0.5, rel=1e-12)


def test_the_same_question_has_the_same_answer_to_the_last_bit():
    """SciPy shuffles the points of an interpolation unless it is told not to."""
    times, random = np.array([0.1, 0.2, 0.35, 0.5]) / 3.0, np.random.default_rng(0)
    for values in random.normal(size=(30, 4)):
        assert len({float(value_at(times, values, None, 0.09)) for _ in range(20)}) == 1


def test_the_sides_of_a_jump(history):
    """An impact ends the approach: before it the gap closes, after it it does not."""
    impact = history.events[0]
    before, after = (history.at(impact.time, side) for side in ("left", "right"))
    assert float(before["gap_rate"]) == pytest.approx(impact.normal_velocity, rel=1e-12)
    assert abs(float(after["gap_rate"])) < 1e-9
    assert float(after["slip_rate"]) == pytest.approx(impact.tangential_velocity, rel=1e-12)
    assert int(before["state"]) == 0
    assert int(after["state"]) == int(impact.state)
    just_after = history.at(np.nextafter(impact.time, 1.0))
    assert float(just_after["gap_rate"]) == float(after["gap_rate"])


def test_a_state_is_that_of_the_sample_before(history):
    """A scheme of fixed steps may change it from one sample to the next, without a jump."""
    data = history.data.isel(time=slice(0, 3))
    data = data.assign(state=("time", np.array([0, 1, 2], dtype=np.int8), data["state"].attrs))
    times = data["time"].values
    assert int(dataset_at(data, 0.5 * (times[0] + times[1]), "right")["state"]) == 0
    assert int(dataset_at(data, times[1], "left")["state"]) == 1


@pytest.mark.parametrize("time", [-1e-9, 0.36, float("nan")])
def test_a_time_outside_is_refused(history, time):
    with pytest.raises(InputError, match="should be from 0 to"):
        history.at(time)


def test_the_deformed_axis(history):
    """The last point is the contact point, the first the pin; the axis keeps its length."""
    points, now = history.beam_at(0.32), history.at(0.32)
    assert points.shape == (history.data.sizes["station"], 2)
    np.testing.assert_allclose(points[-1], [now["tip_x"], now["tip_y"]], atol=1e-6)
    np.testing.assert_allclose(now["deflection"], now["uy"][-1], rtol=1e-9)
    np.testing.assert_allclose(now["shortening"], now["ux"][-1], rtol=1e-6)
    np.testing.assert_allclose(points[0], 0.0, atol=1e-15)
    assert np.linalg.norm(np.diff(points, axis=0), axis=1).sum() == pytest.approx(1.0, abs=1e-4)


def test_the_axis_of_a_beam_on_a_hub_begins_at_its_radius():
    """At rest along the x axis: from 0.25 m to 1.25 m."""
    still = ["root.hub_radius=0.25", "initial.angle=0", "end_time=0.001", "contact.enabled=false"]
    history = simulate(Scenario.builtin("paper", ["root.kind=hub", "root.inertia=1", *still]))
    points = history.beam_at(0.0)
    np.testing.assert_allclose(points[[0, -1]], [[0.25, 0.0], [1.25, 0.0]], atol=1e-15)


def test_the_velocity_of_the_contact_point_is_that_of_gap_and_slip(history):
    """Across the slope and along it, which rises by 18 degrees."""
    vx, vy = (history[name].values for name in ("tip_vx", "tip_vy"))
    s, c = np.sin(np.pi / 10), np.cos(np.pi / 10)
    np.testing.assert_allclose(vy * c - vx * s, history["gap_rate"], rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(vx * c + vy * s, history["slip_rate"], rtol=0.0, atol=1e-12)


def test_tables(history):
    table = history.event_table
    assert list(table["time"]) == [event.time for event in history.events]
    assert list(table["kind"]) == [event.kind.value for event in history.events]
    assert table["time"][3] == history.events[2].time  # counted from 1, as `render --event 3` does
    assert history.contact_table["start"][1] == history.contacts[0].start
    assert history.contact_table["normal_impulse"].sum() == pytest.approx(
        sum(m["normal_impulse"] for m in history.macro_collisions), rel=1e-12
    )
    energy = history.total_energy
    assert energy.attrs["units"] == "J"
    assert float(energy[0]) == pytest.approx(history.summary["energy"]["initial"], rel=1e-14)
    assert float(energy[-1]) == pytest.approx(history.summary["energy"]["final"], rel=1e-14)
    for kind in ("kinetic", "elastic", "gravity"):
        assert history.summary["energy"][kind] == float(history[f"energy_{kind}"][-1])


def test_it_behaves(history):
    assert "lambda_n" in history
    assert "nothing" not in history
    assert set(history) == {str(name) for name in history.data.variables}
    assert len(history) == len(list(history))
    assert history.lambda_n.equals(history["lambda_n"])
    with pytest.raises(AttributeError, match="nothing"):
        _ = history.nothing
    assert "lambda_n" in dir(history)
    assert pickle.loads(pickle.dumps(history)).theta.equals(history.theta)
    assert copy.copy(history).summary == history.summary


def test_it_says_what_happened(history):
    lines = repr(history).splitlines()
    assert 4 <= len(lines) <= 10
    assert "completed at 0.35 s" in lines[0]
    energy = history.summary["energy"]
    assert f"  energy      {energy['initial']:.6g} - " in repr(history)
    assert f" lost = {energy['final']:.6g} J, unaccounted " in repr(history)
    assert f"  lost (J)    impact {energy['lost_impact']:.4g}, friction {energy['lost_friction']:.4g}" in repr(
        history
    )
    first = history.macro_collisions[0]
    span = f"{first['start']:.6f} to {first['end']:.6f} s"
    assert f"{span}, {first['contacts']} contacts, {first['normal_impulse']:.6g} N s" in repr(history)
    html = history._repr_html_()
    assert "normal_impulse" in html
    assert f"{first['normal_impulse']:.6g}" in html


def test_it_draws_itself(history):
    assert len(history.plot().axes) == 6
