"""Histories of consecutive spans joined to one: the whole again, and one line for what does not fit."""

from __future__ import annotations

import dataclasses
import json

import numpy as np
import pytest
import xarray as xr

from oblique_impact import History, InputError, Outcome, Scenario, concatenate, simulate, simulate_system
from oblique_impact.contact.impacts import NewtonImpact
from oblique_impact.history.sample_times import last_sample
from oblique_impact.history.summary import macro_collisions
from oblique_impact.renders import export, render
from oblique_impact.validation import compare
from tests.systems import Block

LOSSES = ("lost_impact", "lost_friction", "lost_damping", "lost_scheme", "supplied")


@pytest.fixture(scope="module")
def paper(run):
    """Its contacts have a compliance, as those of an elastic stop would."""
    history = run("paper", "end_time=0.4")
    contacts = [contact._replace(compliance=1e-8 * (n + 1)) for n, contact in enumerate(history.contacts)]
    return dataclasses.replace(history, contacts=contacts)


def part_of(contact, at, first):
    """What lies before or after `at` of a contact; a quarter of its impulses and losses lies before."""
    if contact.end <= at or contact.start > at:
        return contact if first == (contact.end <= at) else None
    share = 0.25 if first else 0.75
    return contact._replace(
        **({"end": at} if first else {"start": at, "peak_force": 1.0, "peak_energy": 0.0}),
        normal_impulse=share * contact.normal_impulse,
        tangential_impulse=share * contact.tangential_impulse,
        energy_loss=share * contact.energy_loss,
    )


def cut(history, k, first):
    """One part of a history that is cut at the sample `k`, which both parts have; the ledger is cut in half."""
    time = history["time"].values
    data = history.data.isel(time=slice(None, k + 1) if first else slice(k, None))
    at = time[k]
    events = [e for e in history.events if (e.time <= at if first else e.time > at)]
    contacts = [c for c in (part_of(c, at, first) for c in history.contacts) if c]
    energy = {key: 0.5 * value for key, value in history.summary["energy"].items()}
    total = [sum(float(history[f"energy_{n}"][i]) for n in ("kinetic", "elastic", "gravity")) for i in (0, k, -1)]
    energy |= {"initial": total[0 if first else 1], "final": total[1 if first else 2]}
    if not first:
        whole = history.summary["energy"]
        energy |= {key: whole[key] for key in ("kinetic", "elastic", "gravity", "contact", "final")}
    collisions = [dataclasses.asdict(m) for m in macro_collisions(contacts, history.macro_gap)]
    summary = {**history.summary, "events": len(events), "macro_collisions": collisions, "energy": energy}
    summary |= {"steps": 10, "rejected_steps": 1, "wall_time": 0.5, "end_time": float(data["time"][-1])}
    return dataclasses.replace(history, data=data, events=events, summary=summary, contacts=contacts)


def sample(history, time):
    return int(last_sample(history["time"].values, time))


@pytest.mark.parametrize("time", [0.1, 0.318, 0.3205, 0.325, 0.39], ids=lambda t: f"{t:g}s")
def test_parts_become_the_whole_again(paper, time):
    """Cut in flight, in a contact, between two contacts of one macro-collision."""
    k = sample(paper, time)
    whole = concatenate(cut(paper, k, True), cut(paper, k, False))
    xr.testing.assert_identical(whole.data, paper.data)
    assert whole.events == paper.events
    for ours, theirs in zip(whole.summary["macro_collisions"], paper.summary["macro_collisions"], strict=True):
        assert ours == pytest.approx(theirs, rel=1e-14)
    for ours, theirs in zip(whole.contacts, paper.contacts, strict=True):
        assert tuple(ours) == pytest.approx(tuple(theirs), rel=1e-13)
    energy = paper.summary["energy"]
    for key in ("initial", "final", *LOSSES):
        assert whole.summary["energy"][key] == pytest.approx(energy[key], abs=1e-14)
    assert whole.summary["energy"]["unaccounted"] == pytest.approx(energy["unaccounted"], abs=1e-13)
    assert (whole.summary["events"], whole.summary["steps"]) == (len(paper.events), 20)
    assert (whole.summary["rejected_steps"], whole.summary["wall_time"]) == (2, 1.0)
    assert whole.summary["joints"] == [paper["time"].values[k]]
    assert whole.summary["warnings"] == paper.summary["warnings"]
    assert Scenario.from_toml(whole.scenario_toml) == Scenario.from_toml(paper.scenario_toml)


@pytest.mark.parametrize("peaks", [(1.0, 7.0), (7.0, 1.0)])
def test_a_contact_that_is_cut_has_the_larger_peak_of_its_parts(paper, peaks):
    k = sample(paper, 0.318)
    parts = [cut(paper, k, first) for first in (True, False)]
    for part, place, peak in zip(parts, (-1, 0), peaks, strict=True):
        part.contacts[place] = part.contacts[place]._replace(peak_force=peak, peak_energy=peak / 2.0)
    count = len(parts[0].contacts)
    assert len(concatenate(*parts).contacts) == len(paper.contacts)
    whole = concatenate(*parts).contacts[count - 1]
    assert (whole.peak_force, whole.peak_energy) == (7.0, 3.5)


def test_the_gap_of_the_first_history_holds_for_all(swings):
    a, b = (
        dataclasses.replace(history, summary=history.summary | {"macro_gap": gap})
        for history, gap in zip(swings, (0.25, 0.5), strict=True)
    )
    assert concatenate(a, b, shift=True).macro_gap == 0.25


def test_a_joint_at_a_jump_keeps_both_sides(paper):
    """The left part ends before an impact, the right one begins after it."""
    k = sample(paper, paper.events[0].time)
    left, right = cut(paper, k - 1, True), cut(paper, k, False)
    assert right["time"].values[0] == np.nextafter(left["time"].values[-1], 1.0)
    whole = concatenate(left, right)
    xr.testing.assert_identical(whole.data, paper.data)
    assert any("the motion jumps at 0.317147 s" in warning for warning in whole.summary["warnings"])


def ball(q0, qd0, end_time):
    system = Block(lambda t, q, qd: (0.0, -9.8))
    return simulate_system(
        system, np.array(q0), np.array(qd0), end_time, impact=NewtonImpact(0.8), output_interval=1e-2
    )


def test_a_run_that_is_taken_up_where_it_ended_is_the_whole_run():
    """A bouncing ball, in a system that has no variables of a beam: 1 s and 1 s against 2 s."""
    first = ball([0.0, 1.0], [0.5, 0.0], 1.0)
    second = ball(first["q"].values[-1], first["qd"].values[-1], 1.0)
    joined, whole = concatenate(first, second, shift=True), ball([0.0, 1.0], [0.5, 0.0], 2.0)
    assert [e.kind for e in joined.events] == [e.kind for e in whole.events]
    for name in ("start", "end"):
        spans = [[getattr(contact, name) for contact in history.contacts] for history in (joined, whole)]
        assert spans[0] == pytest.approx(spans[1], abs=1e-9)
    found = compare(joined, whole)
    assert len(whole.events) >= 3
    assert found.largest_shift < 1e-9
    assert max(abs(v.aligned.largest) for v in found.variables.values()) < 1e-8
    assert max(v.hausdorff or 0.0 for v in found.variables.values()) < 1e-8
    assert joined["time"].size == whole["time"].size
    assert joined.scenario_toml == ""
    for key in LOSSES:
        assert joined.summary["energy"][key] == pytest.approx(whole.summary["energy"][key], abs=1e-9)


@pytest.fixture(scope="module")
def swings():
    """Two flights of a tenth of a second, from different angles."""
    base = Scenario.builtin("paper").replace(end_time=0.1)
    return simulate(base), simulate(base.replace(initial__angle=0.8))


def test_shifted_histories_follow_each_other(swings):
    a, b = swings
    joined = concatenate(a, b, a, shift=True)
    time = joined["time"].values
    assert joined.summary["joints"] == pytest.approx([0.1, 0.2], abs=1e-15)
    assert time[-1] == joined.summary["end_time"] == pytest.approx(0.3, abs=1e-15)
    assert np.all(np.diff(time) > 0.0)
    # the motion jumps: both sides stay, next to each other
    (k,) = np.flatnonzero(time == joined.summary["joints"][0])
    assert time[k + 1] == np.nextafter(time[k], 1.0)
    assert joined["theta"].values[k] == a["theta"].values[-1]
    assert joined["theta"].values[k + 1] == b["theta"].values[0] == 0.8
    assert Scenario.from_toml(joined.scenario_toml).end_time == time[-1]
    assert joined["time"].attrs == a["time"].attrs


def test_a_jump_of_the_energy_is_unaccounted_for(swings):
    a, b = swings
    joined = concatenate(a, b, shift=True)
    jump = b.summary["energy"]["initial"] - a.summary["energy"]["final"]
    assert abs(jump) > 1e-3
    assert joined.summary["energy"]["unaccounted"] == pytest.approx(-jump, abs=1e-11)
    assert [w for w in joined.summary["warnings"] if "jumps at 0.1 s" in w]


def test_what_made_the_spans_is_told_in_their_order(swings):
    a, b = (
        dataclasses.replace(
            one, summary=one.summary | {"provenance": {"version": version, "parts": {version: "digest"}}}
        )
        for one, version in zip(swings, ("0.9", "0.8"), strict=True)
    )
    joined = concatenate(a, b, a, shift=True).summary["provenance"]
    assert joined == {"version": "0.9, 0.8", "parts": {"0.9": "digest", "0.8": "digest"}}


def test_joining_in_steps_is_joining_at_once(swings):
    a, b = swings
    steps = concatenate(concatenate(a, b, shift=True), concatenate(b, a, shift=True), shift=True)
    at_once = concatenate(a, b, b, a, shift=True)
    xr.testing.assert_allclose(steps.data, at_once.data, rtol=0.0, atol=1e-15)
    assert steps.summary["joints"] == pytest.approx(at_once.summary["joints"], abs=1e-15)
    assert steps.summary["energy"] == pytest.approx(at_once.summary["energy"], abs=1e-14)


def test_spans_may_be_computed_differently(swings, run):
    coarse = run("paper", "end_time=0.1", "solver.output_interval=1e-3", "solver.tolerance=1e-8")
    joined = concatenate(swings[0], coarse, shift=True)
    assert joined["time"].size == swings[0]["time"].size + coarse["time"].size
    assert Scenario.from_toml(joined.scenario_toml).solver.output_interval == 1e-4


def test_one_history_is_itself(swings):
    xr.testing.assert_identical(concatenate(swings[0]).data, swings[0].data)


def test_a_joined_history_is_saved_drawn_and_exported(swings, tmp_path):
    joined = concatenate(*swings, shift=True)
    again = History.load(joined.save(tmp_path / "run"))
    np.testing.assert_array_equal(again["theta"].values, joined["theta"].values)
    assert again.summary == json.loads(json.dumps(joined.summary))
    assert again.outcome is Outcome.COMPLETED
    assert render(again, tmp_path / "page.html").file.stat().st_size > 100_000
    assert export(again, tmp_path / "beam", format="pvd", every=200).span[1] == pytest.approx(0.2)


def changed(history, **changes):
    return dataclasses.replace(history, **changes)


def refusals(a, run):
    other = run("paper", "end_time=0.1", "contact.mu_static=0.4")
    stopped = changed(a, summary={**a.summary, "outcome": Outcome.PAINLEVE.label})
    return {
        "no histories given": [],
        "history 2: begins at 0 s, but history 1 ends at 0.1 s; shift=True moves it there": [a, a],
        "history 2: contact.mu_static = 0.4, in history 1 it is 0.3": [a, other],
        "history 2: 4 along 'coordinate', in history 1 there are 3": [
            a,
            run("paper", "end_time=0.1", "discretization.modes=3"),
        ],
        "history 3: variable 'shear' is only in history 1": [a, a, changed(a, data=a.data.drop_vars("shear"))],
        "history 1: variable 'shear' is only in history 2": [changed(a, data=a.data.drop_vars("shear")), a],
        "history 1: ended by painleve; nothing can follow it": [stopped, a],
        "history 2: other values of 'station' than history 1": [
            a,
            changed(a, data=a.data.assign_coords(station=a.data["station"] * 1.1)),
        ],
    }


@pytest.mark.parametrize("number", range(8))
def test_what_does_not_fit_is_one_line(swings, run, number):
    line, histories = list(refusals(swings[0], run).items())[number]
    with pytest.raises(InputError) as refused:
        concatenate(*histories, shift=not line.startswith("history 2: begins"))
    assert line in str(refused.value)
    assert "\n" not in str(refused.value)
