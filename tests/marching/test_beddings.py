"""Beddings: a stiffness over the length of a side; each place bears on it with its own part of the beam."""

from __future__ import annotations

import numpy as np
import pytest

from oblique_impact import InputError, Scenario, simulate
from oblique_impact.beam.cross_sections import Sections
from oblique_impact.history.history import History

COMMON = (
    "contact.where=anywhere",
    "contact.normal=spring",
    "contact.friction=frictionless",
    "slope.enabled=false",
    "initial.angle=0",
    "discretization.frame=mean-axis",
)


def on_bed(*keys: str, bedding: float, origin: tuple[float, float], extent: tuple[float, ...] = ()) -> History:
    """Run the paper's beam, first horizontal, above a bed."""
    side = f"{{kind='side', origin={list(origin)}, extent={list(extent)}, bedding={bedding}}}"
    return simulate(Scenario.builtin("paper", [*COMMON, f"obstacles=[{side}]", *keys]))


# --- a stiff beam on a soft bed is a bar on springs


@pytest.mark.parametrize("extent", [(), (0.25, 0.75), (0.203, 0.7101)], ids=["endless", "ends at places", "ends"])
def test_a_bar_rebounds_from_a_bed_with_the_integrals_of_its_depth(extent):
    """Impulse 2 J omega int x dx/int x^2 dx in half a period, in the second order of the grid.

    How much of the cells at the ends of the bed is over it decides how large the error is.
    """
    bedding, speed, grids = 20.0, 2e-3, np.array([8, 16, 32])
    first, last = extent or (0.0, 1.0)
    arm, square = (last**2 - first**2) / 2.0, (last**3 - first**3) / 3.0
    errors, keys = [], ("gravity=0", f"initial.angular_velocity={-speed}", "end_time=3", "discretization.modes=1")
    for grid in grids:
        more = f"contact.grid={grid}", "solver.output_interval=0.1"
        found = on_bed(*keys, *more, bedding=bedding, origin=(0.0, 0.0), extent=extent)
        inertia = Sections.from_scenario(found.scenario).inertia
        half = np.pi * np.sqrt(inertia / (bedding * square))
        impulse = sum(c.normal_impulse for c in found.contacts)
        lasts = max(c.end for c in found.contacts) - min(c.start for c in found.contacts)
        errors.append([impulse / (2.0 * inertia * speed * arm / square) - 1.0, lasts / half - 1.0])
    # the beam is not quite stiff
    assert (np.abs(errors) < (0.8 / grids**2 + 3e-5)[:, None]).all()
    if extent != (0.203, 0.7101):
        orders = np.log2(np.array(errors)[:-1] / np.array(errors)[1:])
        assert orders == pytest.approx(np.full((2, 2), 2.0), abs=0.15)


# --- ends


def slide(*keys: str) -> History:
    """Let a hub press a slender beam onto a bed over whose end its tip is drawn and comes back."""
    hub = "root.kind=hub", "root.inertia=0.01", "root.torque=-10", "beam.youngs_modulus=7e9"
    common = *hub, "end_time=0.12", "solver.output_interval=1e-5", "contact.grid=64"
    modes = () if "discretization.method=absolute" in keys else ("discretization.modes=3",)
    return on_bed(*common, *modes, *keys, bedding=1e6, origin=(-1.0, -0.05), extent=(0.0, 1.9907))


def by_law(found: History) -> np.ndarray:
    """Forces (N) of the bed of `slide` at the depths of closed contacts, by how much of each cell is over it."""
    grid, slip = found.scenario.contact.grid, found["contact_slip"].values
    after = np.append(np.full(grid - 1, 0.5 / grid), 0.0)
    over = np.minimum(slip + after, 1.9907) - np.maximum(slip - 0.5 / grid, 0.0)
    depth = np.where(found["contact_state"].values > 0, -found["contact_gap"].values, 0.0)
    return 1e6 * np.maximum(over, 0.0) * depth


@pytest.mark.parametrize("friction", ["frictionless", "hybrid"])
def test_places_that_slide_over_the_end_of_a_bed_lose_their_force_without_a_jump(friction):
    found = slide(f"contact.friction={friction}")
    assert "slides off" in [passage["how"] for passage in found.summary["slope_ends"]]
    force = found["contact_lambda_n"].values
    assert np.max(np.abs(np.diff(force.sum(axis=1)))) < 0.01 * force.sum(axis=1).max()
    np.testing.assert_allclose(force, by_law(found), rtol=1e-9, atol=1e-9)
    assert force[:, -1].max() > 0.1
    assert abs(found.balance["unaccounted"]) < 1e-9


@pytest.mark.parametrize("scheme", ["generalized-alpha", "fixed-step", "energy-consistent"])
def test_other_schemes_find_the_same_forces_and_account_for_the_energy(scheme):
    keys = "contact.grid=16", "end_time=0.052", "solver.free_step=1e-5", "solver.contact_step=4e-6"
    if scheme == "energy-consistent":
        mesh = "discretization.method=absolute", "discretization.frame=tangent", "discretization.elements=8"
        keys = keys[1], "contact.grid=8", *mesh, "solver.free_step=2e-4", "solver.contact_step=2e-5"
    found = slide(*keys, f"solver.scheme={scheme}")
    force = found["contact_lambda_n"].values
    np.testing.assert_allclose(force, by_law(found), rtol=1e-6, atol=1e-6)
    assert force.max() > 50.0
    assert abs(found.balance["unaccounted"]) < (1e-12 if scheme == "energy-consistent" else 1e-7)
    if scheme != "energy-consistent":
        located = slide(*keys[:2])
        impulses = [sum(c.normal_impulse for c in history.contacts) for history in (found, located)]
        assert impulses[0] == pytest.approx(impulses[1], rel=1e-5)


def test_friction_acts_at_each_place_with_its_share_of_the_force():
    found = on_bed(
        *("contact.friction=hybrid", "contact.grid=16", "initial.angular_velocity=-0.4", "end_time=0.03"),
        bedding=1e5,
        origin=(0.0, -0.002),
    )
    normal, along = found["contact_lambda_n"].values, found["contact_lambda_tau"].values
    slides = (found["contact_state"].values == 1) & (np.abs(found["contact_slip_rate"].values) > 1e-6)
    assert (slides.sum(axis=0) > 10).sum() > 5
    against = -np.sign(found["contact_slip_rate"].values[slides])
    np.testing.assert_allclose(along[slides], 0.3 * normal[slides] * against, rtol=1e-9)
    gap = found["contact_gap"].values
    cells = np.append(np.full(15, 1.0 / 16), 0.5 / 16)
    np.testing.assert_allclose(normal, 1e5 * cells * np.maximum(-gap, 0.0), rtol=1e-9, atol=1e-12)


def test_a_file_keeps_a_bedding_and_takes_no_stiffness_beside_it():
    given = Scenario.builtin(
        "paper", [*COMMON, "obstacles=[{kind='side', origin=[0.0, -0.1], bedding='0.2 N/mm^2'}]"]
    )
    assert given.obstacles[0].bedding == pytest.approx(2e5)
    assert Scenario.from_toml(given.to_toml()) == given
    with pytest.raises(
        InputError, match=r"obstacles\.1\.stiffness = 2\.0: has no effect: bedding stands in its place"
    ):
        given.replace(obstacles__1__stiffness=2.0)
    with pytest.raises(InputError, match=r"obstacles\.1\.bedding = .*: only with contact\.normal = \"spring\""):
        given.replace(contact__normal="rigid")
    with pytest.raises(InputError, match=r"obstacles\.1\.bedding = .*: only with kind = \"side\""):
        given.replace(obstacles__1__kind="point")


def test_an_end_of_a_bed_is_no_corner_and_no_place_starts_below_it():
    side = "{kind='side', origin=[0.5, %s], extent=[0.0, 0.3], bedding=1e5}"
    keys = [*COMMON, "contact.grid=8"]
    assert Scenario.builtin("paper", [*keys, f"obstacles=[{side % -0.1}]"]).obstacle_points == []
    with pytest.raises(InputError, match=r"starts 0\.1 m below obstacle 1"):
        # half of the cell of the place at 0.875 m is over the bed
        Scenario.builtin("paper", [*keys, f"obstacles=[{side.replace('[0.5', '[0.52') % 0.1}]"])
