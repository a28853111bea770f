"""What the pictures of a run share: one scale of colours, one magnification, one time map."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from oblique_impact.renders.geometry import BeamGeometry
from oblique_impact.renders.story import ColourScale, colour_scale, peaks_of, round_up, story_of
from oblique_impact.renders.timeline import SECONDS

QUANTITIES = ("bending_stress", "axial_stress", "bending_moment", "shear_force", "axial_force", "section_rotation")
TAPERED = ("tapered", "end_time=0.34")


@pytest.fixture(params=[("paper",), TAPERED, ("mid-span",)], ids=lambda names: names[0])
def history(run, request):
    return run(*request.param)


@pytest.mark.parametrize("quantity", QUANTITIES)
def test_the_peaks_are_those_of_the_drawn_surface(history, quantity):
    """At any sample no point of the surface carries more, and one carries as much."""
    geometry = BeamGeometry(history)
    peaks = peaks_of(geometry, quantity)
    for k in np.linspace(0, peaks.size - 1, 25).astype(int):
        drawn = np.nanmax(np.abs(geometry.surface(k).arrays[quantity]))
        assert peaks[k] == pytest.approx(drawn, rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("quantity", QUANTITIES)
def test_the_scale_covers_all_samples(history, quantity):
    geometry = BeamGeometry(history)
    scale = colour_scale([geometry], quantity)
    largest = peaks_of(geometry, quantity).max()
    assert largest <= scale.limit <= 1.35 * largest
    assert not scale.exceeded


def test_the_stress_of_the_scale_is_that_of_the_bending_moment(history):
    """M e / I with the section at each station: a circle of the local area where no outer fibre is given."""
    beam = BeamGeometry(history).scenario.beam
    x = history["station"].values

    def at(table):
        return np.interp(x, *np.array(table).T) if isinstance(table, list | tuple) else np.full(x.shape, table)

    fibre = beam.outer_fibre or np.sqrt(at(beam.area) / np.pi)
    stress = np.abs(history["moment"].values) * fibre / at(beam.second_moment)
    np.testing.assert_allclose(np.abs(history["bending_stress"].values), stress, rtol=1e-9, atol=1e-3)
    limit = story_of([history]).colours.limit
    assert 0.7 * limit < stress.max() <= limit


def test_a_film_of_the_usual_length_runs_as_the_page_stretched_evenly(run):
    page, film = (story_of([run("paper")], seconds=seconds).time_map for seconds in (None, SECONDS))
    assert film.duration == pytest.approx(SECONDS)
    times = np.linspace(0.0, 1.0, 501)
    np.testing.assert_allclose(film.film_at(times) / SECONDS, page.film_at(times) / page.duration, atol=1e-9)


def test_a_run_that_blew_up_is_exceeded_and_says_so(run):
    history = run("paper")
    data = history.data.copy(deep=True)
    data["moment"].values[-1] = 1e300
    data["moment"].values[-2] = 1e25
    blown = BeamGeometry(replace(history, data=data, summary=history.summary | {"outcome": "diverged"}))
    scale = colour_scale([blown], "bending_stress")
    sound = colour_scale([BeamGeometry(history)], "bending_stress")
    assert 0.5 * sound.limit < scale.limit <= sound.limit
    assert scale.exceeded
    assert [text[0] for _, text in scale.ticks] == ["≤", "−", "0", *scale.ticks[3][1][0], "≥"]


@pytest.mark.parametrize(
    ("limit", "title", "labels"),
    [
        (1e8, "bending stress (MPa), tension positive", ["−100", "−50", "0", "50", "100"]),
        (2.5e6, "bending stress (MPa), tension positive", ["−2.50", "−1.25", "0", "1.25", "2.50"]),
        (1.5e10, "bending stress (GPa), tension positive", ["−15.0", "−7.5", "0", "7.5", "15.0"]),
        (5e3, "bending stress (kPa), tension positive", ["−5.0", "−2.5", "0", "2.5", "5.0"]),
        (4.0, "bending stress (Pa), tension positive", ["−4", "−2", "0", "2", "4"]),
    ],
)
def test_labels_of_the_scale_are_their_numbers(limit, title, labels):
    scale = ColourScale("bending_stress", limit, False)
    assert (scale.title, [text for _, text in scale.ticks]) == (title, labels)
    assert ColourScale("shear_force", 1.2, False).title == "shear force (N)"


def test_the_ends_of_a_scale_are_round_and_not_below():
    for value in np.geomspace(1e-7, 1e9, 400):
        assert value * (1.0 - 1e-9) <= round_up(value) <= 1.34 * value
    assert [round_up(v) for v in (0.0, 1.0, 86.0, 100.0, 100.1)] == [1.0, 1.0, 100.0, 100.0, 120.0]
