"""The exponential integrator of free flights: motions and events against those of Runge-Kutta steps."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from oblique_impact import Scenario, simulate
from oblique_impact.beam_problem import beam_of, beam_problem
from oblique_impact.marching.event import EventScheme
from oblique_impact.marching.loop import Run

CASES = {
    "mean-axis": [],
    "damped": ["beam.kelvin_voigt=1e-5", "beam.mass_proportional=0.5"],
    "tangent": ["discretization.frame=tangent", "discretization.modes=8"],
    "full": ["discretization.modes=6", "discretization.kinetics=full"],
    "elements": ["discretization.method=fem", "discretization.elements=24"],
    "samples far apart": ["solver.output_interval=3e-3"],
    "samples close": ["solver.output_interval=7e-6"],
}


class Exponential(EventScheme):
    """The event scheme with the exponential integrator also in runs so short that its tables do not pay."""

    def buffers(self, task):
        return super().buffers(task._replace(end_time=1e9))


class RungeKutta(EventScheme):
    """The event scheme without the exponential integrator."""

    def buffers(self, task):
        return super().buffers(task._replace(modes=None))


class ShortCalls(EventScheme):
    """The event scheme that returns to the loop after a few steps."""

    def steps_per_call(self, size):
        return 7


def march(scenario, scheme):
    """Return what a run with another scheme leaves: its record, and times and states of all samples."""
    record = Run(replace(beam_problem(beam_of(scenario)), scheme=scheme)).execute()
    times, states = (
        np.concatenate(parts) for parts in zip(*((s.times, s.states) for s in record.segments), strict=True)
    )
    return record, times, states


# exact kinetic energy has steps of its own without the integrator's tables, which quick checks march
@pytest.mark.parametrize(
    "case", [pytest.param(case, marks=pytest.mark.slow) if case == "full" else case for case in CASES]
)
def test_motions_are_those_of_small_steps(case):
    """Up to the second contact, with the vibrations of the first one: states and quadratures at the samples."""
    scenario = Scenario.builtin("many-modes", ["end_time=0.3178", *CASES[case]])
    long, times, states = march(scenario, Exponential(scenario.solver.tolerance))
    # at the limit of their stability the short steps leave noise in damped modes, as large as the tolerance
    short, expected_times, expected = march(scenario, RungeKutta(1e-12))
    assert long.steps < 0.5 * short.steps
    assert [e.kind for e in long.events] == [e.kind for e in short.events]
    np.testing.assert_allclose([e.time for e in long.events], [e.time for e in short.events], rtol=0, atol=2e-11)
    assert times.size == expected_times.size
    np.testing.assert_allclose(times, expected_times, rtol=0, atol=2e-11)
    between, size = slice(0, times.size - 4), scenario.discretization.modes + 1
    np.testing.assert_allclose(states[between, :size], expected[between, :size], rtol=0, atol=5e-10)
    np.testing.assert_allclose(states[between, size:], expected[between, size:], rtol=0, atol=1e-6)


def test_a_driven_beam_is_supplied_with_its_energy():
    """The power of the drive depends on the motion itself; 9 J m/s of a spin-up, to rounding of the ledger."""
    history = simulate(Scenario.builtin("spin-up"))
    energy = history.summary["energy"]
    assert history.summary["steps"] < 5_000  # Runge-Kutta steps are thirty times as many
    assert history.balance["supplied"] > 1e3
    assert abs(energy["unaccounted"]) < 1e-8


def test_no_contact_is_stepped_over():
    """Sixteen modes on the rigid stop touch it 48 times within 0.4 s, some for a microsecond."""
    scenario = Scenario.builtin("many-modes", ["end_time=0.4"])
    long, short = (march(scenario, scheme(scenario.solver.tolerance))[0] for scheme in (EventScheme, RungeKutta))
    assert len(long.events) == len(short.events) > 40
    np.testing.assert_allclose([e.time for e in long.events], [e.time for e in short.events], rtol=0, atol=1e-8)
    assert min(segment.observation.column("gap").min() for segment in long.segments) > -1e-11
    assert long.steps < 0.2 * short.steps


@pytest.mark.parametrize("case", ["many-modes", "paper"])
def test_where_calls_end_changes_nothing(case):
    """A run is the same to the last bit."""
    scenario = Scenario.builtin(case, ["end_time=0.35"])
    whole, times, states = march(scenario, EventScheme())
    parts, *others = march(scenario, ShortCalls())
    assert parts.steps == whole.steps
    assert [e.time for e in parts.events] == [e.time for e in whole.events]
    np.testing.assert_array_equal(others[0], times)
    np.testing.assert_array_equal(others[1], states)
