"""Refinement: order, limit and verdict on sequences made for them; quantities; the real code at order 4."""

from __future__ import annotations

import html
import json
import math
import re
import sys
from dataclasses import replace
from io import BytesIO

import numpy as np
import pytest
from matplotlib.figure import Figure

from oblique_impact import InputError, Scenario, simulate
from oblique_impact.errors import Interrupted
from oblique_impact.history.sample_times import last_sample
from oblique_impact.validation import refine
from oblique_impact.validation.measuring import failed
from oblique_impact.validation.quantities import (
    _NAMED,
    FIELDS,
    VARIABLES,
    GapError,
    default_quantities,
    natural_scale,
    quantity,
)
from oblique_impact.validation.refinement.command import lines
from oblique_impact.validation.refinement.convergence import (
    CONVERGED,
    CONVERGING,
    NO_VERDICT,
    NOT_CONFIRMED,
    NOT_CONVERGING,
    NOT_DETERMINED,
    SAFETY,
    analyse,
    grid_convergence_index,
    observed_order,
    richardson_limit,
)
from oblique_impact.validation.refinement.figures import (
    _decades,
    _differences,
    _level_axis,
    _reference_slope,
    _relative_values,
    relative_errors,
)
from oblique_impact.validation.refinement.ladders import (
    AXES,
    Ladder,
    Study,
    check_levels,
    declared_orders,
    parse_levels,
    sizes,
)
from oblique_impact.validation.refinement.report import CSV_COLUMNS, csv_rows, study_data, study_document
from oblique_impact.validation.refinement.shipped import STUDIES, shipped_study
from oblique_impact.validation.refinement.study import ROWS, judge, plan_ladder
from oblique_impact.validation.report.document import render_html

UNIFORM = np.array([0.4, 0.2, 0.1, 0.05, 0.025])
UNEVEN = np.array([0.4, 0.31, 0.14, 0.1, 0.03])
STEEP = np.array([0.8, 0.1, 0.08, 0.07])  # ln r32 > 2 ln r21: the plain fixed-point iteration runs away


def power(h, order, limit=2.0, factor=0.7):
    return limit + factor * h**order


# --- the formulas


@pytest.mark.parametrize("h", [UNIFORM, UNEVEN, STEEP], ids=["uniform", "uneven", "steep"])
@pytest.mark.parametrize("order", [0.5, 1.0, 2.0, 4.0, 7.5])
def test_power_laws_give_their_order_and_limit(h, order):
    f = power(h, order)
    found = observed_order(f[1] - f[0], f[2] - f[1], h[0] / h[1], h[1] / h[2])
    assert found == pytest.approx(order, rel=1e-9)
    assert richardson_limit(f[2], f[2] - f[1], h[1] / h[2], found) == pytest.approx(2.0, abs=1e-10)


def test_the_order_solves_the_standards_equation_where_its_iteration_settles():
    """p = |ln(d32/d21) + q(p)| / ln r21, q = ln((r21^p - 1)/(r32^p - 1)) (Celik et al. 2008, eq. 3)."""
    d32, d21, r32, r21 = 0.021, 0.008, 1.5, 1.333
    p = 1.0
    for _ in range(200):
        p = abs(math.log(d32 / d21) + math.log((r21**p - 1.0) / (r32**p - 1.0))) / math.log(r21)
    assert observed_order(d32, d21, r32, r21) == pytest.approx(p, rel=1e-10)


def test_published_example_of_the_grid_convergence_index():
    """Celik et al. 2008, table 1: phi = 6.063, 5.972, 5.863; r21 = 1.5, r32 = 1.333; p = 1.53, GCI 2.2 %.

    N = 18000, 8000, 4500 cells in two dimensions; extrapolated 6.1685.
    """
    fine, middle, coarse, r21, r32 = 6.063, 5.972, 5.863, 1.5, 1.333
    p = observed_order(middle - coarse, fine - middle, r32, r21)
    assert p == pytest.approx(1.53, abs=0.01)
    assert richardson_limit(fine, fine - middle, r21, p) == pytest.approx(6.1685, abs=2e-3)
    assert grid_convergence_index(fine - middle, r21, p) / fine == pytest.approx(0.022, abs=5e-4)


def test_differences_that_grow_have_a_negative_order():
    assert observed_order(1.0, 4.0, 2.0, 2.0) == pytest.approx(-2.0)
    h = UNEVEN
    f = h**-0.5
    assert observed_order(f[1] - f[0], f[2] - f[1], h[0] / h[1], h[1] / h[2]) == pytest.approx(-0.5)


@pytest.mark.parametrize(("coarse", "fine"), [(1.0, -0.5), (1.0, 0.0), (0.0, 1.0), (math.nan, 1.0)])
def test_without_a_ratio_there_is_no_order(coarse, fine):
    assert math.isnan(observed_order(coarse, fine, 2.0, 2.0))


def test_logarithms_have_order_zero():
    f = np.log(UNIFORM)
    assert observed_order(f[1] - f[0], f[2] - f[1], 2.0, 2.0) == pytest.approx(0.0, abs=1e-9)


# --- the verdicts


@pytest.mark.parametrize("h", [UNIFORM, UNEVEN], ids=["uniform", "uneven"])
@pytest.mark.parametrize("order", [1.0, 2.0, 4.0])
def test_a_power_law_converges_at_its_order(h, order):
    found = analyse(h, power(h, order), tolerance=1e-12)
    assert found.verdict == CONVERGING
    assert found.words == f"converging at order {order:.2f}"
    assert found.order == pytest.approx(order, rel=1e-6)
    assert found.limit == pytest.approx(2.0, abs=1e-9)
    # the index bounds the true error by its safety factor
    assert found.uncertainty == pytest.approx(SAFETY * 0.7 * h[-1] ** order, rel=1e-6)


def test_within_the_tolerance_it_has_converged_and_keeps_its_order():
    found = analyse(UNIFORM, power(UNIFORM, 2.0), tolerance=1e-3)
    assert found.verdict == CONVERGED
    assert found.words == "converged at order 2.00"


@pytest.mark.parametrize(("earlier", "verdict"), [(1.65, CONVERGING), (1.55, NOT_CONFIRMED), (2.6, NOT_CONFIRMED)])
def test_orders_agree_within_a_fifth_of_the_larger(earlier, verdict):
    """Differences 1, 2^-p, 2^-(p + 2) on halved sizes: the orders p and 2."""
    steps = np.cumsum([0.0, 1.0, 2.0**-earlier, 2.0 ** -(earlier + 2.0)])
    assert analyse(UNIFORM[:4], 5.0 + steps, tolerance=1e-9).verdict == verdict


def test_two_terms_reach_the_asymptotic_range_only_on_fine_levels():
    def values(h):
        return 1.0 + h**2 - 3.0 * h**4

    coarse = np.array([0.8, 0.4, 0.2])
    assert analyse(coarse, values(coarse), tolerance=1e-9).verdict == NOT_CONFIRMED
    fine = coarse / 32.0
    found = analyse(np.append(fine, fine[-1] / 2.0), values(np.append(fine, fine[-1] / 2.0)), tolerance=1e-9)
    assert found.verdict == CONVERGING
    assert found.order == pytest.approx(2.0, abs=0.01)


def test_three_levels_need_a_declared_order():
    h = UNIFORM[:3]
    f = power(h, 2.0)
    alone = analyse(h, f, tolerance=1e-6)
    assert alone.verdict == NOT_CONFIRMED
    assert "2.00" in alone.reason
    assert math.isnan(alone.limit)
    assert analyse(h, f, tolerance=1e-6, declared=2.0).words == "converging at order 2.00"
    assert analyse(h, f, tolerance=1e-6, declared=4.0).verdict == NOT_CONFIRMED


def test_a_declared_order_bounds_the_index():
    f = power(UNIFORM, 2.3)
    bounded, free = (analyse(UNIFORM, f, tolerance=1e-9, declared=declared) for declared in (2.0, None))
    assert bounded.uncertainty > free.uncertainty
    assert bounded.order == free.order


def test_shrinking_oscillation_is_judged_by_its_swing():
    f = 1.0 + 0.1 * (-0.5) ** np.arange(5)
    found = analyse(UNIFORM, f, tolerance=1e-3)
    assert found.verdict == NOT_CONFIRMED
    assert "alternate" in found.reason
    assert analyse(UNIFORM, [0.0, 1.0, 0.0, 1.0, 0.0]).verdict == NOT_CONVERGING
    assert found.uncertainty == pytest.approx(SAFETY * abs(f[-2] - f[-3]))
    assert abs(f[-1] - 1.0) < found.uncertainty
    assert analyse(UNIFORM, f, tolerance=0.1).words == "converged"


@pytest.mark.parametrize(
    "values",
    [
        [1.0, 2.0, 4.0, 8.0, 16.0],
        UNIFORM**-0.5,
        np.log(UNIFORM),
        [1.0, 2.0, 3.0, 4.0, 5.0],
        [1.0, 1.1, 0.9, 1.2, 0.8],
        [0.0, 1.0, 0.0, 1.0, 0.0],
        [1.0, 1.0, 1.0, 1.0, 2.0],
    ],
    ids=["doubling", "root", "logarithm", "linear", "growing swing", "steady swing", "late jump"],
)
def test_what_does_not_converge_is_called_that(values):
    found = analyse(UNIFORM, values)
    assert found.verdict == NOT_CONVERGING
    assert found.words == "not converging"
    assert math.isnan(found.limit)


def test_growth_is_not_hidden_by_the_tolerance():
    """All within 2e-4 of one value, but each difference is twice the one before."""
    assert analyse(UNIFORM, 1.0 + 2e-5 * 2.0 ** np.arange(5), tolerance=1e-3).verdict == NOT_CONVERGING


def test_stagnation_at_rounding_keeps_the_order_of_the_levels_above_it():
    rng = np.random.default_rng(1)
    h = 0.1 / 2.0 ** np.arange(9)
    f = 1.0 + h**6 + 2e-14 * rng.standard_normal(9)
    found = analyse(h, f, tolerance=1e-9)
    assert found.verdict == CONVERGED
    assert found.order == pytest.approx(6.0, abs=0.1)
    assert "until the noise is reached" in found.reason
    assert found.uncertainty >= found.noise


def test_differences_within_the_noise_tell_no_order():
    """A power law whose differences are all below what a tighter tolerance changes."""
    found = analyse(UNIFORM, power(UNIFORM, 2.0, factor=1e-6), tolerance=1e-3, noise=1e-5)
    assert found.words == "converged"
    assert math.isnan(found.order)
    assert found.uncertainty == 1e-5
    assert analyse(UNIFORM, power(UNIFORM, 2.0, factor=1e-6), tolerance=1e-6, noise=1e-5).verdict == NOT_CONFIRMED


def test_noise_without_bound_is_no_convergence():
    found = analyse(UNIFORM, power(UNIFORM, 2.0), noise=math.inf)
    assert found.verdict == NOT_CONFIRMED
    assert "tolerance" in found.reason


def test_equal_counts_have_converged():
    assert analyse(UNIFORM, [7.0, 5.0, 5.0, 5.0, 5.0]).words == "converged"
    assert analyse(UNIFORM, [7.0, 5.0, 5.0, 5.0, 6.0]).verdict == NOT_CONVERGING


def test_gaps_are_named_and_do_not_stop_the_rest():
    nan = math.nan
    h = np.append(UNIFORM, 0.0125)
    f = power(h, 2.0)
    f[1] = nan
    found = analyse(h, f, tolerance=1e-9)
    assert found.order == pytest.approx(2.0)
    assert math.isnan(found.differences[1])
    assert math.isnan(found.differences[2])
    f[-1] = nan
    assert (analyse(h, f).verdict, analyse(h, f).reason) == (NO_VERDICT, "the finest level does not have it")
    f = power(h, 2.0)
    f[-3] = nan
    found = analyse(h, f)
    assert found.verdict == NO_VERDICT
    assert "three successive levels" in found.reason
    assert found.pair_index == pytest.approx(3.0 * abs(f[-1] - f[-2]))  # r = 2, order 1 assumed
    assert analyse(h, np.full(6, nan)).verdict == NO_VERDICT


def test_small_values_are_measured_by_their_scale():
    f = power(UNIFORM, 2.0, limit=0.0, factor=1e-6)
    assert analyse(UNIFORM, f, tolerance=1e-3).verdict == CONVERGING
    assert analyse(UNIFORM, f, tolerance=1e-3, scale=1.0).verdict == CONVERGED


def test_the_tolerance_is_relative_to_the_finest_value():
    """From 161 to 1.625: the uncertainty 1.25 (1.875/3) is half of the finest value, 5e-3 of the first."""
    found = analyse(UNIFORM, power(UNIFORM, 2.0, limit=1.0, factor=1000.0), tolerance=0.1)
    assert found.uncertainty == pytest.approx(0.78125)
    assert found.verdict == CONVERGING


@pytest.mark.parametrize(("order", "verdict"), [(0.29, NOT_CONVERGING), (0.31, CONVERGING)])
def test_orders_from_three_tenths_on_are_convergence(order, verdict):
    assert analyse(UNIFORM, power(UNIFORM, order), tolerance=1e-6).verdict == verdict


@pytest.mark.parametrize(("times", "verdict"), [(4.9, NOT_CONFIRMED), (5.1, CONVERGING)])
def test_differences_tell_an_order_from_five_times_the_noise_on(times, verdict):
    """Of three levels with a declared order, the last difference is so many times the noise."""
    f = power(UNIFORM[:3], 2.0)
    noise = abs(f[-1] - f[-2]) / times
    assert analyse(UNIFORM[:3], f, tolerance=1e-6, noise=noise, declared=2.0).verdict == verdict


def test_chance_is_rarely_called_convergence():
    """Independent random values have no limit: the rule may be fooled only now and then."""
    rng = np.random.default_rng(2016)
    words = [analyse(UNIFORM, rng.uniform(0.5, 1.5, 5), tolerance=1e-3).verdict for _ in range(2000)]
    assert words.count(NOT_CONVERGING) + words.count(NOT_CONFIRMED) > 0.97 * 2000
    assert words.count(NOT_CONVERGING) > 0.6 * 2000


def test_sizes_must_fall():
    with pytest.raises(ValueError, match="should fall"):
        analyse([0.1, 0.2, 0.3], [1.0, 2.0, 3.0])
    with pytest.raises(ValueError, match="should fall"):
        analyse([0.3, 0.2, 0.1], [1.0, 2.0])


# --- ladders


@pytest.mark.parametrize(
    ("axis", "text", "part"),
    [
        ("elements", "4,8", "3 to 16 levels"),
        ("elements", "4,16,8", "increase"),
        ("elements", "4,8,8", "increase"),
        ("elements", "4,8,x", "whole numbers"),
        ("elements", "4,8,16.5", "whole numbers"),
        ("modes", "0,1,2", "from 1"),
        ("modes", "-2,1,2", "whole numbers"),
        ("steps", "1e-5,2e-5,4e-5", "decrease"),
        ("steps", "1e-4,nan,1e-6", "above 0"),
        ("steps", "1e-4,1e-5,0", "above 0"),
        ("tolerances", "", "above 0"),
    ],
)
def test_levels_that_cannot_be_are_one_line(axis, text, part):
    with pytest.raises(InputError, match=part) as caught:
        check_levels(axis, parse_levels(axis, text))
    assert f"--{axis}" in str(caught.value)


def test_levels_change_what_they_are_about():
    paper = Scenario.builtin("paper")
    finer = AXES["elements"].apply(paper, 8.0)
    assert (finer.discretization.method, finer.discretization.elements, finer.discretization.modes) == (
        "fem",
        8,
        2,
    )
    assert AXES["modes"].apply(paper, 3.0).discretization.modes == 3
    stepped = AXES["steps"].apply(paper.replace(solver__scheme="fixed-step"), 2e-5).solver
    assert (stepped.free_step, stepped.contact_step) == (2e-5, pytest.approx(2e-7))
    with pytest.raises(InputError, match="--tolerances"):
        AXES["steps"].apply(paper, 1e-5)
    with pytest.raises(InputError, match="--steps"):
        AXES["tolerances"].apply(paper.replace(solver__scheme="fixed-step"), 1e-5)


@pytest.mark.parametrize(("tolerance", "tighter"), [(1e-8, 1e-9), (5e-13, 1e-13)])
def test_noise_is_measured_at_a_tenth_of_the_tolerance(tolerance, tighter):
    """... of the finest level, and no lower than a scenario allows."""
    ladder = Ladder("a", "paper", (f"solver.tolerance={tolerance}",), "modes", (1.0, 2.0, 3.0))
    noisy = plan_ladder(ladder).noisy
    assert noisy.solver.tolerance == pytest.approx(tighter, rel=1e-12)
    assert noisy.discretization.modes == 3


def test_levels_and_sizes_have_si_units():
    """A size is a step, or one over a level."""
    assert {axis.name: (axis.heading, axis.size_label) for axis in AXES.values()} == {
        "elements": ("elements", "1/elements"),
        "modes": ("modes", "1/modes"),
        "steps": ("free step (s)", "free step (s)"),
        "stiffness": ("stiffness (N/m)", "1/stiffness (m/N)"),
        "tolerances": ("tolerance", "mean step (s)"),
    }


def test_the_size_of_a_tolerance_is_the_mean_step():
    assert sizes("tolerances", (1e-4, 1e-6, 1e-8), (0.3, 0.2, 0.1)) == ([0.3, 0.2, 0.1], "")
    replaced, remark = sizes("tolerances", (1e-4, 1e-6, 1e-8), (0.2, 0.2, 0.1))
    assert replaced == pytest.approx([1e-4**0.125, 1e-6**0.125, 0.1])
    assert "mean steps" in remark
    assert sizes("elements", (4.0, 8.0), (0.0, 0.0))[0] == [0.25, 0.125]


def test_orders_are_declared_only_where_they_hold():
    paper = Scenario.builtin("paper")
    names = ("impulse", "peak_force", "max:moment", "contacts")
    assert declared_orders("elements", paper, names) == {"impulse": 4.0}
    assert declared_orders("modes", paper, names) == {}
    implicit = paper.replace(solver__scheme="generalized-alpha")
    assert declared_orders("steps", implicit, names) == {}
    assert declared_orders("steps", implicit.replace(contact__normal="spring"), names) == {"impulse": 2.0}


# --- quantities

#: with three mean-axis modes the second impact lands in a Painleve configuration (theory Sec. 5)
ROUGH = ("discretization.frame=mean-axis", "contact.mu_static=20.0", "contact.mu_kinetic=20.0", "end_time=0.4")


def test_variables_are_those_of_a_history(run):
    data = run("paper").data
    for name, (unit, _) in VARIABLES.items():
        if name != "energy":
            assert data[name].dims == ("time",)
            assert data[name].attrs["units"] == unit
    for name, (unit, _) in FIELDS.items():
        assert data[name].dims == ("time", "station")
        assert data[name].attrs["units"] == unit


def test_quantities_of_the_papers_case(run):
    history = run("paper")
    first, second = history.summary["macro_collisions"][:2]
    expected = {
        "first_impact": first["start"],
        "collision_end": first["end"],
        "collision_duration": first["end"] - first["start"],
        "impulse": first["normal_impulse"],
        "tangential_impulse": first["tangential_impulse"],
        "peak_force": first["peak_force"],
        "contacts": first["contacts"],
        "second_impact": second["start"],
        "second_impulse": second["normal_impulse"],
        "energy_final": history.summary["energy"]["final"],
        "lost_friction": history.summary["energy"]["lost_friction"],
        "events": history.summary["events"],
        "theta@end": float(history["theta"][-1]),
        "max:tip_y": float(history["tip_y"].max()),
        "min:moment": float(history["moment"].min()),
    }
    for name, value in expected.items():
        assert quantity(name).measure(history) == value, name
    lost = history.summary["energy"]["initial"] - quantity("energy_after_collision").measure(history)
    assert 0.0 < lost < sum(history.summary["energy"][f"lost_{k}"] for k in ("impact", "friction", "scheme"))


def test_extremes_have_signs_and_events_are_counted_from_one(run):
    """A beam that falls from rest turns ever faster the other way: its rate is at most the 0 of the start."""
    fall = run("paper", "end_time=0.3")
    assert quantity("max:theta_dot").measure(fall) == 0.0
    assert quantity("min:theta_dot").measure(fall) == float(fall["theta_dot"][-1]) < -1.0
    history = run("paper")
    found = [quantity(f"event:{number}").measure(history) for number in (1, 2, len(history.events))]
    assert found == [history.events[k].time for k in (0, 1, -1)]


def test_the_energy_after_a_collision_is_that_of_the_flight_that_follows(run):
    history = run("paper")
    first, second = history.macro_collisions[:2]
    energy = history.total_energy.sel(time=0.5 * (first["end"] + second["start"]), method="nearest")
    assert quantity("energy_after_collision").measure(history) == pytest.approx(float(energy), rel=1e-7)


def test_every_quantity_has_the_unit_of_what_it_measures(run):
    units = {
        "s": "first_impact collision_end collision_duration second_impact",
        "N s": "impulse tangential_impulse second_impulse",
        "N": "peak_force",
        "1": "contacts events restitution",
        "J": "energy_after_collision energy_final lost_impact lost_friction lost_damping lost_scheme unaccounted "
        "energy_lost",
    }
    assert {q.name: q.unit for q in _NAMED.values()} == {
        n: unit for unit, names in units.items() for n in names.split()
    }
    history = run("paper", "end_time=0.4")
    keys = ("final", "lost_impact", "lost_friction", "lost_damping", "lost_scheme", "unaccounted")
    energy = history.summary["energy"] | dict(zip(keys, (1.0, 2.0, 4.0, 8.0, 16.0, 32.0), strict=True))
    known = replace(history, summary=history.summary | {"energy": energy})
    assert quantity("energy_final").measure(known) == 1.0
    assert [quantity(key).measure(known) for key in keys[1:]] == [2.0, 4.0, 8.0, 16.0, 32.0]
    assert quantity("energy_lost").measure(known) == 30.0
    jump = history.data["gap_rate"].values
    assert (quantity("max:gap_rate").measure(history), quantity("min:gap_rate").measure(history)) == (
        jump.max(),
        jump.min(),
    )


@pytest.mark.parametrize("name", ["tip_y", "theta", "deflection", "energy_elastic"])
def test_values_between_samples(run, name):
    """A run with four times the samples knows what lies between."""
    coarse, fine = (run("paper", "end_time=0.31", f"solver.output_interval={step}") for step in (2e-4, 5e-5))
    values = fine[name].values
    for moment in (0.10005, 0.25015, 0.2999):
        place = int(np.argmin(np.abs(fine["time"].values - moment)))
        found = quantity(f"{name}@{moment}").measure(coarse)
        assert found == pytest.approx(values[place], abs=1e-4 * np.abs(values).max())
        assert quantity(f"{name}@{moment}").measure(fine) == values[place]


def test_a_jump_has_the_value_after_it(run):
    history = run("paper")
    impact = history.events[0].time
    place = int(last_sample(history["time"].values, impact))
    assert history["time"].values[place] > impact
    assert quantity(f"gap_rate@{impact!r}").measure(history) == float(history["gap_rate"][place])


def test_what_a_run_does_not_have_is_a_named_gap(run):
    early, cut, flight = run("paper", "end_time=0.2"), run("paper", "end_time=0.318"), run("paper", "end_time=0.4")
    stopped = run("paper", *ROUGH, "discretization.modes=3")
    for name, history, words in (
        ("first_impact", early, "no contact before end_time"),
        ("impulse", early, "no contact before end_time"),
        ("second_impact", early, "no contact before end_time"),
        ("collision_end", cut, "still in contact"),
        ("second_impact", flight, "no second impact before end_time"),
        ("second_impulse", flight, "no second impact before end_time"),
        ("impulse", stopped, "painleve"),
        ("second_impact", stopped, "painleve"),
        ("energy_final", stopped, "painleve"),
        ("tip_y@end", stopped, "painleve"),
        ("tip_y@0.39", stopped, "ended at"),
    ):
        with pytest.raises(GapError, match=words):
            quantity(name).measure(history)
    assert quantity("first_impact").measure(stopped) == pytest.approx(0.317, abs=1e-3)


@pytest.mark.parametrize("name", ["peak", "tip_y@", "moment@0.5", "tip_z@0.5", "max:", "mean:tip_y", "tip_y@-1"])
def test_unknown_quantities_are_one_line(name):
    with pytest.raises(InputError, match=r"--quantity") as caught:
        quantity(name, 1.0)
    assert "\n" not in str(caught.value)


def test_times_after_the_end_are_refused():
    with pytest.raises(InputError, match="end_time 1 "):
        quantity("tip_y@1.5", 1.0)


def test_usual_quantities_fit_the_scenario():
    assert "second_impact" in default_quantities(Scenario.builtin("paper"))
    assert "tip_x@end" in default_quantities(Scenario.builtin("spin-up"))
    assert natural_scale("m", Scenario.builtin("spin-up"), 3.0) == 10.0
    assert natural_scale("J", Scenario.builtin("paper"), 3.0) == 3.0
    assert natural_scale("s", Scenario.builtin("paper"), 3.0) == 0.0


# --- the studies


def test_every_shipped_study_can_be_planned():
    for name in STUDIES:
        study = shipped_study(name)
        assert study.name == name
        for ladder in study.ladders:
            scenario = Scenario.load(ladder.scenario, list(ladder.changes))
            assert len(ladder.levels) >= 3
            for level in ladder.levels:
                AXES[ladder.axis].apply(scenario, level)
            for q in ladder.quantities:
                quantity(q, scenario.end_time)
            assert set(ladder.declared) <= set(ladder.quantities)


def test_an_unknown_study_lists_those_there_are():
    with pytest.raises(InputError, match=r"elements .*steps .*remedies .*grading"):
        shipped_study("nonsense")


def test_finite_elements_show_order_four_on_the_real_code():
    """The shipped study (a), one ladder, at a modest size."""
    study = shipped_study("elements")
    ladder = study.ladders[1]
    small = Ladder(
        ladder.name,
        ladder.scenario,
        # the flexibility left out is a small difference: the rounding of K of 192 elements shows in it
        (*ladder.changes, "end_time=0.36", "contact.residual_flexibility=false"),
        "elements",
        (24.0, 48.0, 96.0, 192.0),
        ("first_impact", "impulse", "peak_force", "energy_final"),
        ladder.declared,
    )
    result = refine(study=Study("small", "small", "", (small,), tolerance=1e-6), workers=1)
    for item in result.ladders[0].results[:3]:
        orders = [t.order for t in item.analysis.triplets if t]
        assert orders == pytest.approx([4.0, 4.0], abs=0.2), item.quantity.name
        assert item.analysis.order == pytest.approx(4.0, abs=0.05)
        assert item.analysis.verdict == CONVERGED
    # nothing takes energy: all levels agree, and a constant has no order
    energy = result.ladders[0].results[3].analysis
    assert (energy.verdict, math.isnan(energy.order)) == (CONVERGED, True)


def test_schemes_show_their_declared_orders_in_free_flight():
    study = shipped_study("steps")
    flights = tuple(ladder for ladder in study.ladders if ladder.name.startswith("flight"))
    assert len(flights) == 3
    result = refine(study=Study("flights", "flights", "", flights, tolerance=1e-6), workers=1)
    limits = []
    for ladder in result.ladders:
        for item in ladder.results:
            assert item.analysis.order == pytest.approx(item.declared, rel=0.03), ladder.ladder.name
            assert item.analysis.verdict == CONVERGED
        limits.append(ladder.results[0].analysis.limit)
    # one motion, three schemes: their limits are the same
    assert limits == pytest.approx([limits[0]] * 3, abs=1e-8)


@pytest.fixture(scope="module")
def stopped():
    """The finest of three runs is stopped by the physics."""
    ladder = Ladder("modes", "paper", ROUGH, "modes", (1.0, 2.0, 3.0), ("first_impact", "theta@0.35"))
    return refine(study=Study("modes", "modes", "", (ladder,)), workers=1)


def test_a_run_the_physics_stops_is_a_row_and_not_the_end(stopped):
    ladder = stopped.ladders[0]
    assert [run["outcome"] for run in ladder.runs] == ["completed", "completed", "painleve"]
    first, later = ladder.results
    assert first.analysis.verdict == CONVERGED
    assert later.analysis.verdict == NO_VERDICT
    assert "painleve" in later.gaps[-1]
    assert all(math.isfinite(value) for value in later.values[:-1])
    assert f"  modes 3: painleve at t = {ladder.runs[2]['stopped_at']:.6g} s" in lines(stopped)


def test_an_interrupt_ends_the_study_and_not_one_run(monkeypatch):
    def interrupted(scenario, *_):
        raise Interrupted(None)

    monkeypatch.setattr(sys.modules["oblique_impact.simulation"], "simulate", interrupted)
    ladder = Ladder("modes", "paper", (), "modes", (1.0, 2.0, 3.0))
    with pytest.raises(KeyboardInterrupt):
        refine(study=Study("modes", "modes", "", (ladder,)), workers=1)


@pytest.fixture
def quick():
    return Study("modes", "modes", "", (Ladder("modes", "paper", ("end_time=0.05",), "modes", (1.0, 2.0, 3.0)),))


def test_an_interrupted_study_goes_on_with_the_others(monkeypatch, tmp_path, quick):
    """Its rows are taken as they are: a mark put into one comes out; another study in the folder starts anew."""
    simulation = sys.modules["oblique_impact.simulation"]
    count = iter(range(9))

    def twice(scenario, *rest):
        if next(count) == 2:
            raise Interrupted(None)
        return simulate(scenario, *rest)

    monkeypatch.setattr(simulation, "simulate", twice)
    with pytest.raises(KeyboardInterrupt, match="2 of 4 runs are kept"):
        refine(study=quick, workers=1, out=tmp_path)
    monkeypatch.undo()
    text = (tmp_path / ROWS).read_text()
    assert text.count('"run"') == 2
    (tmp_path / ROWS).write_text(re.sub(r'"events": 0', '"events": 77', text))
    told = []
    result = refine(study=quick, workers=1, out=tmp_path, on_progress=told.append)
    assert [progress.done for progress in told] == [2, 3, 4]
    assert [run["events"] for run in result.ladders[0].runs] == [0, 0, 77]
    assert sorted(path.name for path in tmp_path.iterdir()) == ["report.html", "results.csv", "results.json"]


@pytest.mark.parametrize("other", [{"changes": {"gravity": 9.0}}, {"quantities": ["theta@end"]}])
def test_rows_of_another_study_are_not_taken(monkeypatch, tmp_path, quick, other):
    """Of another scenario, or of the same one with other quantities: it begins with none."""
    simulation = sys.modules["oblique_impact.simulation"]
    count = iter(range(9))

    def once(scenario, *rest):
        if next(count) == 1:
            raise Interrupted(None)
        return simulate(scenario, *rest)

    with monkeypatch.context() as patch:
        patch.setattr(simulation, "simulate", once)
        with pytest.raises(KeyboardInterrupt, match="1 of 4 runs are kept"):
            refine(study=quick, workers=1, out=tmp_path)
    told = []
    refine(study=quick, workers=1, out=tmp_path, on_progress=told.append, **other)
    assert [progress.done for progress in told] == [0, 1, 2, 3, 4]


def test_a_run_that_takes_too_long_is_a_gap(quick):
    result = refine(study=quick, changes={"end_time": 30.0}, workers=1, timeout=0.1)
    assert {run["outcome"] for run in result.ladders[0].runs} == {"timeout"}
    assert all(gap.startswith("took longer than 0.1 s") for gap in result.quantity("impulse").gaps)
    assert result.quantity("impulse").analysis.verdict == NO_VERDICT


def test_reports_tell_changes_and_uneven_events():
    study = Study("a", "a", "", (Ladder("a", "paper", ("end_time=0.4",), "modes", (1.0, 2.0, 3.0)),))
    result = refine(study=study, changes={"beam.length": 0.9}, quantities=["impulse"], workers=1)
    page = render_html(study_document(result, "command"))
    assert "Scenario paper; end_time = 0.4, beam.length = 0.9" in page
    counts = [run["events"] for run in result.ladders[0].runs]
    assert len(set(counts)) > 1
    words = f"differs from level to level ({', '.join(map(str, counts))})"
    assert page.count(words) == 2
    assert sum(words in line for line in lines(result)) == 1


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("paper", "Scenario paper; end_time = 0.01, contact.enabled = False. Refined"),
        ("mine", "Scenario mine; end_time = 0.01, contact.enabled = False (against the defaults). Refined"),
    ],
)
def test_a_report_tells_what_differs_from_the_scenario_of_that_name_or_from_the_defaults(name, said):
    base = Scenario.builtin("paper", ["end_time=0.01", "contact.enabled=false"])
    result = refine(base, modes=[1, 2, 3], workers=1, name=name)
    assert said in render_html(study_document(result, "command"))


def test_data_for_machines_is_complete(stopped):
    data = json.loads(json.dumps(study_data(stopped, "command"), allow_nan=True))
    entry = data["ladders"][0]["quantities"][1]
    assert entry["values"][0] == stopped.ladders[0].results[1].values[0]
    assert entry["words"] == "no verdict"
    assert data["ladders"][0]["runs"][-1]["outcome"] == "painleve"
    rows = list(csv_rows(stopped))
    assert len(rows) == 2 * 3
    assert not any(isinstance(cell, float) and math.isnan(cell) for row in rows for cell in row)
    assert rows[-1][CSV_COLUMNS.index("gap")] == stopped.ladders[0].results[1].gaps[-1]


@pytest.mark.parametrize(
    ("values", "scale"), [([np.nan, np.nan], "linear"), ([0.0, np.nan], "linear"), ([0.0, 1e-3], "log")]
)
def test_a_picture_without_differences_has_no_decades(values, scale):
    """Levels that agree to the last digit, before the first contact for instance, cannot be drawn by decades."""
    figure = Figure()
    axes = figure.subplots()
    axes.plot([1.0, 2.0], values)
    _decades(axes)
    figure.savefig(BytesIO())
    assert axes.get_yscale() == scale


def test_an_elastic_stop_is_refined_in_its_stiffness(tmp_path):
    stiff = Scenario.builtin(
        "paper", ["contact.normal=spring", "end_time=0.319", "discretization.frame=mean-axis"]
    )
    result = refine(stiff, stiffness=[1e5, 1e6, 1e7], quantities=["first_impact"], workers=1)
    assert result.ladders[0].sizes == (1e-5, 1e-6, 1e-7)
    assert [s.contact.stiffness for s in result.ladders[0].scenarios] == [1e5, 1e6, 1e7]
    assert result.ladders[0].axis.heading == "stiffness (N/m)"
    with pytest.raises(InputError, match=r"--stiffness: contact\.normal"):
        refine(Scenario.builtin("paper"), stiffness=[1e5, 1e6, 1e7], workers=1)


RIGID = Scenario.builtin("paper", ["end_time=0.335", "discretization.frame=mean-axis"])
DAMPED = RIGID.replace(beam__kelvin_voigt=1e-3)
LOST = {"impulse", "collision_end", "tip_y@end", "peak_force"}


def test_the_peak_force_of_a_rigid_stop_is_no_usual_quantity():
    assert "peak_force" not in default_quantities(RIGID)
    assert "peak_force" in default_quantities(RIGID.replace(contact__normal="spring"))


@pytest.mark.parametrize(
    ("scenario", "levels", "lost"),
    [
        (RIGID, {"modes": [1, 2, 3]}, LOST),
        (DAMPED, {"modes": [2, 3, 4]}, {"peak_force"}),
        # a damping that three modes do not resolve
        (RIGID.replace(beam__kelvin_voigt=1e-6), {"modes": [1, 2, 3]}, LOST),
    ],
    ids=["undamped", "damped", "not resolved"],
)
def test_what_a_run_calls_not_determined_is_not_called_converged(scenario, levels, lost):
    names = ["first_impact", "tip_y@0.3", "max:gap", *LOST]
    result = refine(scenario, **levels, quantities=names, within=0.5, workers=1)
    found = {item.quantity.name: item.analysis for item in result.ladders[0].results}
    assert {name for name in names if found[name].verdict == NOT_DETERMINED} == lost
    assert all(math.isnan(found[name].limit) for name in lost)
    # the tip falls: its largest gap is that of the start
    assert found["max:gap"].verdict == found["first_impact"].verdict == CONVERGED


def test_a_refined_step_converges_for_its_number_of_modes_alone():
    names = ["first_impact", "impulse"]
    result = refine(RIGID, tolerances=[1e-6, 1e-8, 1e-10], quantities=names, workers=1)
    impulse = result.quantity("impulse").analysis
    assert impulse.verdict == CONVERGED
    assert "tolerance" in impulse.words
    (remark,) = [remark for remark in result.ladders[0].remarks if remark.startswith("impulse")]
    assert "first_impact" not in remark
    assert any(remark in line for line in lines(result))
    assert html.escape(remark[1:], quote=True) in render_html(study_document(result, "command"))


def test_warnings_of_the_levels_are_in_lines_report_and_data():
    result = refine(RIGID, modes=[1, 2, 3], quantities=["first_impact"], workers=1)
    warning = simulate(RIGID.replace(discretization__modes=3)).summary["warnings"][-1]
    (line,) = [line for line in lines(result) if warning in line]
    assert "modes 1, 2, 3" in line
    assert warning in html.unescape(render_html(study_document(result, "command")))
    assert warning in study_data(result, "command")["ladders"][0]["runs"][-1]["warnings"]


@pytest.mark.parametrize(
    ("values", "verdict"),
    [
        # observed orders 4.2 and 4.8 agree; with the first three alone nothing confirms the one
        ([362.4, 332.6, 330.94, 330.88], CONVERGING),
        ([362.4, 332.6, 330.94], NOT_CONFIRMED),
        ([302.0, 352.0, 634.0, 1590.0], NOT_CONVERGING),
        ([1.847, 1.835, 1.864, 1.890], NOT_CONVERGING),
        # scatter whose last difference happens to be smaller than the one before it
        ([1.861, 1.864, 1.854, 1.886, 1.890, 1.869], NOT_CONVERGING),
    ],
)
def test_not_converging_is_said_of_what_does_not_fall(values, verdict):
    sizes = 1.0 / 2.0 ** np.arange(1, len(values) + 1)
    assert analyse(sizes, values, tolerance=1e-6).verdict == verdict


@pytest.mark.parametrize(
    ("value", "uncertainty", "text"),
    [
        (1.84709854, 0.036, "1.847"),
        (1.84709854, 4.2e-7, "1.84709854"),
        (15904.0, 1200.0, "15900"),
        (-0.31234, 0.02, "\N{MINUS SIGN}0.312"),
        (2.0, math.nan, "2"),
    ],
)
def test_digits_follow_the_uncertainty(value, uncertainty, text):
    analysis = replace(analyse(UNIFORM, power(UNIFORM, 2.0)), uncertainty=uncertainty)
    assert analysis.shown(value) == text


def test_the_picture_shows_relative_differences_over_levels():
    """Values 2 + 64/elements²; those of the second quantity are noise in the last difference."""
    levels = (8.0, 16.0, 32.0)
    ladder = Ladder("a", "paper", (), "elements", levels, ("impulse", "first_impact"), {"impulse": 2.0})
    plan = plan_ladder(ladder)
    rows = [
        failed(n, "completed", "")
        | {"values": {"impulse": v, "first_impact": 4.0 + n}, "stopped_at": 1.0, "energy": 1.0}
        for n, v in enumerate((3.0, 2.25, 2.0625, 2.0625))
    ]
    result = judge(plan, rows, 1e-3)
    impulse, first = result.results
    axes = Figure().subplots()
    for item in result.results:
        _differences(axes, result, item, {"color": "red"})
    _reference_slope(axes, result)
    curve, within, other, hollow, slope = axes.lines
    np.testing.assert_allclose(curve.get_xdata(), levels[1:])
    np.testing.assert_allclose(curve.get_ydata(), np.array([0.75, 0.1875]) / 2.0625)
    np.testing.assert_allclose(other.get_ydata(), np.array([1.0, 1.0]) / 6.0)
    assert within.get_xdata().size == 0
    np.testing.assert_allclose(hollow.get_xdata(), levels[1:])  # the tighter tolerance changes it by one
    assert first.analysis.noise == 1.0
    assert slope.get_ydata()[1] / slope.get_ydata()[0] == pytest.approx(2.0**-2)
    assert relative_errors(first, impulse)[-1] == pytest.approx(6.0 / 2.0625 - 1.0)
    axes = Figure().subplots()
    _relative_values(axes, result, impulse, {"color": "red"})
    np.testing.assert_allclose(axes.lines[0].get_ydata(), np.array([3.0, 2.25, 2.0625]) / 2.0625)


@pytest.mark.parametrize(
    ("axis", "levels", "inverted"), [("steps", (4e-5, 2e-5, 1e-5), True), ("modes", (1.0, 2.0, 3.0), False)]
)
def test_finer_levels_are_to_the_right(axis, levels, inverted):
    plan = plan_ladder(Ladder("a", "paper", ("solver.scheme=fixed-step",), axis, levels, ("impulse",)))
    rows = [failed(n, "completed", "") | {"values": {"impulse": 1.0 + n}, "energy": 1.0} for n in range(3)]
    axes = Figure().subplots()
    _level_axis(axes, judge(plan, rows, 1e-3))
    assert axes.xaxis_inverted() == inverted
