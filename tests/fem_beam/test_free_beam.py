"""A beam that nothing holds: free flight, its frame, contacts by both of its ends."""

from __future__ import annotations

import numpy as np
import pytest

from oblique_impact import History, InputError, Scenario, simulate
from oblique_impact.beam.frequencies import lowest_elastic_frequency
from oblique_impact.fem_beam.exact import ElasticSections, ExactBeam, Stage, advance
from oblique_impact.fem_beam.exact.exact_system import beam_of
from oblique_impact.renders import export
from oblique_impact.renders.player.content import content_of
from oblique_impact.renders.scenery import pin
from oblique_impact.renders.story import story_of
from oblique_impact.scenario.model import PointMass
from oblique_impact.validation.studies.predictability import closing_turn

FREE = "discretization.method=absolute discretization.elements=6 root.kind=free"
FLIGHT = f"{FREE} contact.enabled=false initial.angle=0.3 initial.angular_velocity=5 initial.position=[1,2]"
FLIGHT += " initial.velocity=[0.5,3] end_time=0.4 solver.free_step=1e-3 solver.output_interval=0.1"
#: onto a level floor
FLOOR = f"{FREE} contact.where=anywhere contact.grid=2 contact.normal=spring contact.stiffness=1e4 slope.angle=0"
FLOOR += " slope.origin=[0,0] initial.velocity=[0.3,-2] initial.position=[0,0.26] beam.kelvin_voigt=1e-4"
FLOOR += " end_time=0.15 solver.contact_step=1e-5 solver.output_interval=1e-3"


def run(*keys: str) -> History:
    return simulate(Scenario.builtin("paper", " ".join(keys).split()))


@pytest.mark.parametrize("length", [4e-3, 0.04])
def test_a_vibrating_beam_in_free_flight_keeps_both_momenta_and_the_energy(length):
    """To rounding, in steps that turn it by a hundredth of a radian or by a tenth of one."""
    b = ExactBeam(
        np.linspace(0.0, 1.0, 5), ElasticSections.uniform(1e3, 1e3, 5.0, 1.0, 1e-3), masses=[PointMass(1.0, 0.2)]
    )
    start = b.straight(0.4)
    speeds = b.turning(start, 3.0) + np.random.default_rng(2).normal(size=b.size) * b.scale * 0.3
    upwards = np.tile([0.0, 1.0, 0.0], b.x.size)
    stage = Stage(start, speeds)
    for _ in range(round(0.8 / length)):
        stage = advance(b, stage, length, np.zeros(b.size), held=np.zeros(0), tolerance=1e-12).stage
        turning = b.angular_momentum(stage.q, stage.v)
        assert turning == pytest.approx(b.angular_momentum(start, speeds), rel=1e-12)
    for axis in (upwards, np.roll(upwards, -1)):
        assert axis @ b.M @ stage.v == pytest.approx(axis @ b.M @ speeds, rel=1e-12)
    energy = b.kinetic_energy(stage.v) + b.elastic_energy(stage.q)
    assert energy == pytest.approx(float(b.kinetic_energy(speeds)), rel=1e-11)
    assert b.elastic_energy(stage.q) > 1e-3 * energy


@pytest.mark.parametrize("frame", ["mean-axis", "tangent"])
def test_its_middle_flies_along_a_parabola_and_it_turns_evenly(frame):
    found = run(FLIGHT, f"discretization.frame={frame}")
    time, middle = found["time"].values, found["station"].size // 2
    places = np.array([found.beam_at(t)[middle] for t in time])
    assert places[:, 0] == pytest.approx(1.0 + 0.5 * time, abs=1e-9)
    assert places[:, 1] == pytest.approx(2.0 + 3.0 * time - 4.9 * time**2, abs=1e-9)
    assert found["theta"].values == pytest.approx(0.3 + 5.0 * time, abs=1e-5)
    assert found["theta_dot"].values == pytest.approx(5.0, abs=1e-4)
    assert abs(found.balance["unaccounted"]) < 1e-11 * found.balance["initial"]
    # velocities are the rates of places
    h = 1e-3
    after, now = found.at(0.2 + h), found.at(0.2)
    moved = found.beam_at(0.2 + h) - found.beam_at(0.2)
    tip = np.array([now["tip_vx"] + after["tip_vx"], now["tip_vy"] + after["tip_vy"]], dtype=float)
    assert moved[-1] / h == pytest.approx(0.5 * tip, rel=1e-3)


def test_the_frame_of_the_mean_axis_holds_momentum_and_the_first_moment():
    """Of the displacements of a beam with a tip mass that has struck: both vanish, about its centre of mass."""
    found = run(FLOOR, "initial.angle=-0.5 beam.tip_mass=0.1 end_time=0.03")
    beam = beam_of(found.scenario)
    mass = beam.M[::3, ::3]
    q, theta = found["q"].values, found["theta"].values
    origin = found["origin_x"].values + 1j * found["origin_y"].values
    r = (q[:, ::3] + 1j * q[:, 1::3] - origin[:, None]) * np.exp(-1j * theta)[:, None]
    u = r - beam.x
    assert np.abs(u).max() > 1e-4
    assert np.abs(u @ (mass @ np.ones(beam.x.size))).max() < 1e-12
    centre = float(beam.x @ mass @ np.ones(beam.x.size) / mass.sum())
    assert np.abs((u @ (mass @ (beam.x - centre))).imag).max() < 1e-12
    tips = found["tip_x"].values + 1j * found["tip_y"].values
    assert np.abs(tips - (q[:, -3] + 1j * q[:, -2])).max() < 1e-12


def test_either_end_touches_as_the_other():
    """The mirrored beam, whose first section is the lower one, has the same contacts."""
    tip, first = run(FLOOR, "initial.angle=-0.5"), run(FLOOR, "initial.angle=0.5 initial.velocity=[-0.3,-2]")
    assert len(tip.contacts) == len(first.contacts) > 0
    assert tip.contacts[0].first_place == 1.0
    for one, other in zip(tip.contacts, first.contacts, strict=True):
        assert one.start == pytest.approx(other.start, abs=1e-9)
        assert one.first_place == pytest.approx(1.0 - other.last_place, abs=1e-12)
        assert one.normal_impulse == pytest.approx(other.normal_impulse, rel=1e-6)
        assert one.tangential_impulse == pytest.approx(-other.tangential_impulse, rel=1e-5, abs=1e-7)
    assert abs(first.balance["unaccounted"]) < 1e-11 * first.balance["initial"]


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_an_end_that_slides_off_a_table_hands_over_to_its_corner(sense):
    """Without a touch from below: the beam, flat on the table, moves over one of its ends."""
    words = "contact.grid=1 contact.friction=frictionless slope.enabled=false initial.angle=0 gravity=20"
    words += f" obstacles=[{{extent=[-0.52,0.52],origin=[0,0]}}] initial.velocity=[{2.0 * sense},-0.1]"
    level = FLOOR.replace("slope.angle=0 slope.origin=[0,0]", "")
    found = run(level, words, "initial.position=[0,0.0001] end_time=0.12")
    pushed = found["contact_lambda_n"].values[:, 2:] > 0.0  # of the two corners
    assert pushed.any(axis=0).tolist() == [sense < 0.0, sense > 0.0]
    assert float(found["clearance"].min()) > -0.02
    assert abs(found.balance["unaccounted"]) < 1e-10 * found.balance["initial"]


def test_its_lowest_frequency_is_that_of_the_free_beam():
    scenario = Scenario.builtin("paper", FLIGHT.split())
    beam = scenario.beam
    unit = np.sqrt(beam.youngs_modulus * beam.second_moment / (beam.density * beam.area)) / beam.length**2
    assert lowest_elastic_frequency(scenario) == pytest.approx(4.730040745**2 * unit, rel=1e-8)


def test_a_file_of_its_history_is_whole(tmp_path):
    """With the origin of its frame, in netCDF and in exports, which have no pin."""
    found = run(FLIGHT)
    found.save(tmp_path / "run")
    read = History.load(tmp_path / "run")
    assert read.beam_at(0.25) == pytest.approx(found.beam_at(0.25), abs=1e-14)
    assert {"origin_x", "origin_vy"} <= set(read.to_dataframe().columns)
    export(read, tmp_path / "flight.pvd")
    assert "pin" not in (tmp_path / "flight.pvd").read_text()


def test_pictures_and_pages_show_it_where_it_flies_and_no_root():
    found = run(FLIGHT)
    story = story_of([found])
    geometry = story.geometries[0]
    assert pin(geometry) is None
    assert geometry.stations_at(2.0) == pytest.approx(found.beam_at(float(found["time"][2])), abs=1e-12)
    content = content_of(story)
    assert content.facts["free"]
    left, right, low, high = content.facts["factors"]["1"]["bounds"]
    tips = found["tip_y"].values
    assert low < tips.min() < tips.max() < high
    assert left < 1.0 < right


def test_no_settings_are_recommended_for_it(refused, tmp_path):
    words = "init", tmp_path / "a.toml", "--from", "dropped-bar", "--recommended"
    assert "modes are recommended" in refused(*words)
    assert "modes are recommended" in refused(*words, "--set", "discretization.method=absolute")


def test_a_small_turn_about_its_middle_closes_its_gap():
    gap, tilt = 1e-3, 0.4
    height = 0.1 * np.sin(tilt) + gap
    bar = Scenario.builtin("dropped-bar").replace(initial__position=(0.0, height), initial__angle=-tilt)
    assert closing_turn(bar) == pytest.approx(gap / 0.1, rel=1e-9)


def test_nothing_to_hold_it_is_refused_where_a_model_needs_a_root():
    for words, key in (
        ("root.kind=free", "root.kind"),
        (f"{FREE} contact.normal=spring initial.state=equilibrium", "initial.state"),
        (f"{FREE} contact.normal=spring root.hub_radius=0.1", "root.hub_radius"),
        (f"{FREE} contact.normal=spring root.stiffness=3", "root.stiffness"),
        ("initial.position=[1,0]", "initial.position"),
        (
            f"{FREE} contact.normal=spring slope.angle=0 initial.angle=-0.5 initial.position=[0.3,0.1]",
            "initial.angle",
        ),
    ):
        with pytest.raises(InputError, match=f"^{key.replace('.', '[.]')}") as refused:
            Scenario.builtin("paper", words.split())
        assert "\n" not in str(refused.value)
