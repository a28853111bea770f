"""Contacts that overlap, begin at one instant or last: course of the film, page, close view, charts, tables."""

from __future__ import annotations

import numpy as np
import pytest

from oblique_impact import History, InputError, Scenario, simulate
from oblique_impact.contact.state import State
from oblique_impact.renders.panels import Curve
from oblique_impact.renders.player.content import content_of
from oblique_impact.renders.story import story_of
from oblique_impact.renders.timeline import make_timeline, time_map
from tests.renders.test_charts import charted

ELASTIC = (
    "contact.normal=spring",
    "contact.damping=0.5",
    "discretization.modes=2",
    "beam.kelvin_voigt=1e-3",
    "solver.tolerance=1e-7",
)
#: the beam comes to rest on two pegs; the same before; it meets two pegs at one instant and a third one
CASES = ("rest", "bounces", "three")


@pytest.fixture(scope="module")
def case(run):
    """A run by its name in `CASES`."""

    def of(name):
        if name == "three":
            return three_pegs()
        return run("two-pegs", *ELASTIC, f"end_time={1.5 if name == 'rest' else 0.6}")

    return of


_THREE = list[History]()


def three_pegs():
    """The beam, straight without gravity, meets two pegs at -0.05 rad, at one instant, and a third one later."""
    if not _THREE:
        keys = "gravity=0", "initial.angle=0.25", "initial.angular_velocity=-3", "end_time=0.2"
        given = Scenario.builtin("two-pegs", [*ELASTIC, *keys]).model_dump(mode="json", exclude_unset=True)
        ray, down = np.exp(-0.05j), -1j * np.exp(-0.05j)
        places = (0.3 * ray + 0.005 * down, 0.6 * ray + 0.005 * down, 0.85 * ray + 0.0055 * down)
        pegs = [{"kind": "point", "origin": [p.real, p.imag], "radius": 0.005} for p in places]
        _THREE.append(simulate(Scenario.from_dict(given | {"obstacles": pegs})))
    return _THREE[0]


def touching(history, times):
    """Whether a contact is closed at times, by its span."""
    return np.any([(c.start <= times) & (times <= c.end) for c in history.contacts], axis=0)


def test_the_three_contacts_are_what_they_are_taken_for(case):
    starts = [contact.start for contact in case("three").contacts]
    assert starts == sorted(starts)
    assert starts[0] == pytest.approx(starts[1], abs=1e-11)
    assert touching(case("three"), np.array(starts[2])) & (starts[2] > starts[1])
    assert sorted(contact.end for contact in case("rest").contacts)[-2:] == [1.5, 1.5]
    states = case("rest")["contact_state"].values
    both = np.all(states != State.FREE, axis=1)
    assert np.any(states[both, 0] != states[both, 1])  # one sticks while the other one slips


@pytest.mark.parametrize("name", CASES)
def test_the_course_is_that_of_all_contacts_together(case, name):
    """Against the time that a fine grid counts as closed."""
    history = case(name)
    course, last = time_map(history), float(history["time"][-1])
    grid = np.linspace(0.0, last, 400_001)
    closed, rates = touching(history, grid), course.rate_at(grid)
    slow, fast = rates.min(), rates.max()
    np.testing.assert_allclose(rates[closed], slow, rtol=1e-9)
    np.testing.assert_allclose(rates[grid < history.contacts[0].start - 0.05], fast, rtol=1e-12)
    assert 10.0 < course.duration < 60.0
    assert np.all(np.diff(course.film) > 0.0)
    # the film lasts as long as its rates say
    assert course.duration == pytest.approx(np.mean(1.0 / rates) * last, rel=1e-3)
    # brief contacts take a share of the film that can be seen; else the rate is the same everywhere
    share = np.mean(closed / rates) * last / course.duration
    assert (share > 0.15 and slow < 0.1 * fast) if closed.mean() < 0.5 else slow == fast


@pytest.mark.parametrize("name", CASES)
def test_frames_of_a_film_stand_in_the_contacts(case, name):
    """As many as the share of the contacts in the film."""
    history = case(name)
    timeline = make_timeline(time_map(history), frames=500)
    closed = touching(history, timeline.times)
    grid = np.linspace(0.0, float(history["time"][-1]), 400_001)
    weights = 1.0 / timeline.course.rate_at(grid)
    assert closed.mean() == pytest.approx(weights[touching(history, grid)].sum() / weights.sum(), abs=0.02)
    assert closed.sum() > 50


def test_rates_that_are_given_hold_or_are_refused(case):
    for history in (case("rest"), case("bounces")):
        rates = time_map(history, 0.5, 0.001).rates
        assert (rates.min(), rates.max()) == (0.001, 0.5)
        assert time_map(history, contact_speed=3.0).rates.tolist() == [3.0] * time_map(history).rates.size
        with pytest.raises(InputError, match="--contact-speed 2: should be at most --speed, 1"):
            time_map(history, 1.0, 2.0)
    with pytest.raises(InputError, match=r"a film of \d{14} frames: should have at most 100000"):
        make_timeline(time_map(case("rest"), 1e-12))


@pytest.mark.parametrize("name", CASES)
def test_the_page_lists_each_contact_with_its_own_states(case, name):
    """A peg is one contact of the history, by its number; between events its state is that of the samples."""
    history = case(name)
    times, states = history["time"].values, history["contact_state"].values
    rows = content_of(story_of([history])).contacts
    assert len(rows) == len(history.contacts)
    for contact, row in zip(history.contacts, rows, strict=True):
        start, end, named, *_ = row["cells"]
        assert float(start) == pytest.approx(contact.start, abs=1e-6)
        assert end == "open" if contact.end == times[-1] else float(end) == pytest.approx(contact.end, abs=1e-6)
        inside = (times > contact.start) & (times < contact.end)
        own = states[inside, contact.obstacle - 1]
        assert set(named.split(", ")) == {State(state).name.lower() for state in own} - {"free"}


@pytest.mark.parametrize("name", CASES)
def test_the_close_view_says_gap_and_slip_of_the_peg_that_it_shows(case, name):
    """The distance of the peg's centre from the axis of the beam, through its stations, less its radius."""
    history = case(name)
    story = story_of([history])
    geometry, content = story.geometries[0], content_of(story)
    samples = np.searchsorted(geometry.times, content.arrays["time"])
    pegs = np.array([obstacle.origin for obstacle in history.scenario.obstacles])
    differ = 0
    for frame, k in list(enumerate(samples.tolist()))[::37]:
        axis = geometry.stations_at(k)
        fine = np.stack([np.interp(np.linspace(0.0, 1.0, 20_001), geometry.stations, v) for v in axis.T], axis=1)
        away = np.hypot(*(fine[:, None] - pegs).transpose(2, 0, 1)).min(axis=0) - 0.005
        peg = int(history["contact_obstacle"].values[geometry.close_contact(k)]) - 1
        said = float(content.texts["gap"][frame].removesuffix(" mm").replace("−", "-"))
        assert abs(said) == pytest.approx(abs(1e3 * away[peg]), abs=0.06 if abs(said) > 90.0 else 0.02)
        assert geometry.close_gap(k)[0] == pytest.approx(1e-3 * said, abs=6e-5)
        differ += abs(away[peg] - away.min()) > 1e-3
    assert differ > 3 or name == "rest"  # where another contact is nearer


@pytest.mark.parametrize("name", CASES)
def test_charts_shade_when_something_touches_once(case, name):
    history = case(name)
    axes = next(axes for axes in history.plot().axes if "(contact shaded)" in axes.get_title(loc="left"))
    grid = np.linspace(0.0, float(history["time"][-1]), 200_001)
    count = sum((patch.get_x() <= grid) & (grid <= patch.get_x() + patch.get_width()) for patch in axes.patches)
    np.testing.assert_array_equal(count, touching(history, grid))
    story = story_of([history])
    axes, course = charted(story, [Curve(grid, grid, "#000000", "time")]), story.time_map
    left, right = axes.get_xlim()
    at = left + course.film_at(grid) * (right - left) / course.duration
    count = sum((patch.get_x() <= at) & (at <= patch.get_x() + patch.get_width()) for patch in axes.patches)
    assert np.mean(count != touching(history, grid)) < 1e-4  # rounding at the ends
