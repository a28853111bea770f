"""Warnings about places of the beam that pass through obstacles, because they do not touch them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from oblique_impact.beam.operators import Array
from oblique_impact.contact.state import State
from oblique_impact.scenario.scenario import Scenario

#: depth below the contact point, over the length, that gives a warning: less than pictures show, more than the
#: kinematics of second order leave out (an eighth of the fourth power of the bending slope: 1e-5 at 0.1 rad)
DEEPER = 1e-4


def passing_warnings(
    scenario: Scenario, variables: Mapping[str, Array], passages: Sequence[Mapping[str, Any]]
) -> list[str]:
    """Return warnings if the beam passes below a side or through a peg, or its one contact point leaves the slope.

    The depth of the contact point itself, in an elastic stop or after a fixed step, does not count, unless it is
    below the line of the slope beyond an end.  `passages` are those of the summary's `slope_ends`.
    """
    if "clearance" not in variables:
        return []
    if scenario.contact.where == "anywhere":
        return _passes_between(scenario, variables) + _passes_through_pegs(scenario, variables)
    slope, point, tolerance = scenario.slope, scenario.contact.point, DEEPER * scenario.beam.length
    warnings = []
    height = scenario.slope_side.slip_and_gap(variables["tip_x"] + 1j * variables["tip_y"]).imag
    past = np.full(height.shape, bool(slope.extent) and bool(height[0] < -tolerance))
    for passage in passages:
        past[variables["time"] > passage["time"]] = passage["how"] != "comes back"
    deeper = np.where(past, 0.0, np.minimum(height, 0.0)) - variables["clearance"]
    k = int(np.argmax(np.nan_to_num(deeper, nan=0.0, posinf=0.0)))
    if deeper[k] > tolerance:
        why = f"x = {point:g} m has passed an end of it" if past[k] else f"only x = {point:g} m is in contact"
        warnings.append(f"{_passage(variables, k, 'the slope')}; {why}")
    left = [passage for passage in passages if passage["how"] != "comes back"]
    if left:
        passage, (first, last) = left[0], slope.extent
        more = f" (the first of {len(left)} in slope_ends)" if len(left) > 1 else ""
        warnings.append(
            f"x = {point:g} m {passage['how']} slope.extent = [{first:g}, {last:g}] at "
            f"t = {passage['time']:.6g} s, {passage['place']:.6g} m along the slope{more}: "
            "contact with the end itself is left out"
        )
    return warnings


def _passes_between(scenario: Scenario, variables: Mapping[str, Array]) -> list[str]:
    """Return a warning if the beam passes below a side between the places that can touch it."""
    distance, obstacle = variables["clearance"], variables["clearance_obstacle"]
    pressed = (variables["contact_state"] != State.FREE) & (variables["contact_obstacle"] == obstacle[:, None])
    depth = np.where(pressed, np.minimum(variables["contact_gap"], 0.0), 0.0).min(axis=1)
    # below the end of a side an axis at up to 60 degrees to it is up to twice as deep as the corner presses in
    deeper = np.where(np.isin(obstacle, [side.obstacle for side in scenario.sides]), 2.0 * depth - distance, 0.0)
    k = int(np.argmax(np.nan_to_num(deeper, nan=0.0, posinf=0.0)))
    if not deeper[k] > DEEPER * scenario.beam.length:
        return []
    name, grid = f"obstacle {obstacle[k]}" if obstacle[k] else "the slope", scenario.contact.grid
    return [f"{_passage(variables, k, name)}; sides touch it at the ends of contact.grid = {grid} parts alone"]


def _passes_through_pegs(scenario: Scenario, variables: Mapping[str, Array]) -> list[str]:
    """Return a warning for each peg that the beam comes to from behind: round its own end, without contact."""
    warnings, least = list[str](), DEEPER * scenario.beam.length
    for point in scenario.obstacle_points:
        if point.corner:  # which belongs to its side
            continue
        i = int(np.argmax(variables["contact_obstacle"] == point.obstacle))
        place, reach = variables["contact_place"][:, i], point.radius + scenario.half_depth
        across = variables["contact_gap"][:, i] + reach  # of the axis from the centre, negative behind it
        # where a contact opens or closes within a step, its last sample of flight may be inside of the peg
        closed = np.pad(variables["contact_state"][:, i] != State.FREE, 1)
        flies = ~(closed[:-2] | closed[1:-1] | closed[2:]) & (place >= 0.0) & (place <= scenario.beam.length)
        passes = flies & (across < -least) & (across > least - reach)
        far = np.flatnonzero(np.abs(across) > least)  # nearer to a peg without a radius it may only touch it
        flies_on = flies[far[:-1]] & (np.diff(np.cumsum(~flies)[far]) == 0)
        passes[far[1:]] |= flies_on & (across[far[:-1]] < 0.0) & (across[far[1:]] > 0.0)
        if passes.any():
            warnings.append(
                f"passes through obstacle {point.obstacle} at t = {variables['time'][np.argmax(passes)]:.6g} s: "
                "a peg touches only that side of the beam which faces it at the start"
            )
    return warnings


def _passage(variables: Mapping[str, Array], sample: int, obstacle: str) -> str:
    """Return how deep and where the beam is below an obstacle, as text."""
    depth, x = -1e3 * variables["clearance"][sample], variables["clearance_at"][sample]
    digits = np.format_float_positional(depth, 2, unique=False, fractional=False, trim="-")
    return f"passes {digits} mm below {obstacle} at x = {x:.3g} m"
