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


#: stops alone, without what the modes leave out of the beam
ALONE = "contact.residual_flexibility=false"


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
    whole = {"discretization.method=absolute", "discretization.modes=0"}
    modes = () if whole & {*keys} else ("discretization.modes=3", ALONE)
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


@pytest.mark.parametrize("scheme", ["generalized-alpha", "fixed-step", "time-stepping"])
def test_other_schemes_find_the_same_forces_and_account_for_the_energy(scheme):
    """All nodes of a mesh by generalized-alpha are all of its modes where events are located."""
    keys, alike = ("contact.grid=16", "end_time=0.052", "solver.free_step=1e-5", "solver.contact_step=4e-6"), ()
    if scheme == "generalized-alpha":
        mesh = "contact.grid=8", "discretization.method=fem", "discretization.elements=8"
        keys, alike = (*mesh, *keys[1:], "discretization.modes=0"), (*mesh, keys[1], "discretization.modes=16")
    if scheme == "time-stepping":
        mesh = "discretization.method=absolute", "discretization.frame=tangent", "discretization.elements=8"
        keys = keys[1], "contact.grid=8", *mesh, "solver.free_step=2e-4", "solver.contact_step=2e-5"
    found = slide(*keys, f"solver.scheme={scheme}")
    force = found["contact_lambda_n"].values
    np.testing.assert_allclose(force, by_law(found), rtol=1e-6, atol=1e-6)
    assert force.max() > 50.0
    assert abs(found.balance["unaccounted"]) < (1e-12 if scheme == "time-stepping" else 1e-7)
    if scheme != "time-stepping":
        located = slide(*(alike or keys[:2]))
        impulses = [sum(c.normal_impulse for c in history.contacts) for history in (found, located)]
        assert impulses[0] == pytest.approx(impulses[1], rel=1e-5)


MODES = "discretization.modes=3", "contact.grid=8"
ELEMENTS = "discretization.method=fem", "discretization.modes=4", "discretization.elements=8", "contact.grid=8"
NODES = "discretization.method=fem", "discretization.modes=0", "discretization.elements=8", "contact.grid=8"
EXACT = (
    *("discretization.method=absolute", "discretization.elements=8"),
    *("discretization.frame=tangent", "solver.free_step=2e-4", "solver.contact_step=2e-5", "contact.grid=8"),
)
FIXED = "solver.free_step=1e-5", "solver.contact_step=4e-6"


def between_both_ends(*keys: str) -> History:
    """Press a slender beam with a hub onto a bed that has both of its ends under it, and slide it along.

    The tip is drawn towards the root as it bends, and comes back.
    """
    hub = "root.kind=hub", "root.inertia=0.01", "root.torque=-10", "beam.youngs_modulus=7e9", "end_time=0.06"
    return on_bed(*hub, "solver.output_interval=1e-4", *keys, bedding=1e6, origin=(0.2, -0.05), extent=(0.0, 0.79))


@pytest.mark.parametrize(
    ("keys", "closure"),
    [
        (MODES, 1e-8),
        (ELEMENTS, 1e-8),
        (EXACT, 1e-9),
        ((*MODES, *FIXED, ALONE, "solver.scheme=fixed-step"), 2e-5),
        ((*MODES, *FIXED, "solver.scheme=time-stepping"), 1e-8),
        ((*NODES, *FIXED, "solver.scheme=time-stepping"), 1e-8),
        ((*NODES, *FIXED, "solver.scheme=generalized-alpha"), 2e-5),
    ],
    ids=["modes", "elements", "exact beam", "fixed steps", "steps of modes", "steps of nodes", "nodes"],
)
@pytest.mark.parametrize("friction", ["frictionless", "hybrid"])
def test_a_bed_with_both_ends_under_the_beam_gives_no_energy(keys, friction, closure):
    """Nothing is damped, so that what the torque gives is in the beam and the bed, or friction has it.

    Without the push along the slide at its ends it gives 6e-4 of the energy.
    """
    found = between_both_ends(*keys, f"contact.friction={friction}")
    energy = found.balance
    slid = found["contact_slip"].values[found["contact_lambda_n"].values.max(axis=1) > 1.0]
    assert np.ptp(slid, axis=0).max() > 1e-4
    assert energy["lost_damping"] == pytest.approx(0.0, abs=1e-9 * energy["supplied"])
    assert abs(energy["unaccounted"]) < closure * energy["supplied"]
    stepped = found.scenario.solver.scheme == "time-stepping"  # which takes some as places close and open
    taken = 5e-5 if stepped else 1e-12 if closure < 1e-6 else 5.0 * closure
    assert abs(energy["lost_scheme"]) < taken * energy["supplied"]
    assert energy["lost_friction"] >= 0.0
    held = found.total_energy.values
    wanted = energy["supplied"] - energy["lost_scheme"]
    assert held[-1] + energy["lost_friction"] == pytest.approx(wanted, rel=10.0 * closure)


def test_a_damped_bed_takes_energy_and_gives_none():
    found = between_both_ends(*MODES, "contact.damping=0.5", "contact.friction=frictionless")
    assert found.balance["lost_damping"] > 1e-3
    assert abs(found.balance["unaccounted"]) < 1e-8 * found.balance["supplied"]


def test_the_force_of_a_bed_is_what_its_energy_falls_by():
    """The force on the beam does the work by which the energy of the springs under its cells falls, at any time.

    Forces and velocities of the points of the beam are those in the history, the energy is by the depths there.
    """
    often = "solver.output_interval=2e-6", "end_time=0.05", ALONE
    found = between_both_ends(*MODES, "contact.friction=frictionless", *often)
    grid, slip, time = found.scenario.contact.grid, found["contact_slip"].values, found["time"].values
    after = np.append(np.full(grid - 1, 0.5 / grid), 0.0)
    over = np.maximum(np.minimum(slip + after, 0.79) - np.maximum(slip - 0.5 / grid, 0.0), 0.0)
    closed = found["contact_state"].values > 0
    depth = np.where(closed, np.maximum(-found["contact_gap"].values, 0.0), 0.0)
    energy = (0.5e6 * over * depth**2).sum(axis=1)
    np.testing.assert_allclose(energy, found["energy_contact"].values, rtol=1e-10, atol=1e-14)
    fx, fy, x, y = (found[f"contact_{name}"].values for name in ("fx", "fy", "x", "y"))
    power = sum(0.5 * (f[1:] + f[:-1]) * np.diff(place, axis=0) for f, place in ((fx, x), (fy, y))).sum(axis=1)
    # at jumps of states two samples have one time
    lasting = np.diff(time) > 1e-9
    work = np.cumsum(power[lasting])
    assert energy.max() > 0.05
    assert np.abs(work + np.cumsum(np.diff(energy)[lasting])).max() < 1e-5 * energy.max()


def test_friction_acts_at_each_place_with_its_share_of_the_force():
    found = on_bed(
        ALONE,
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
    with pytest.raises(InputError, match=r"obstacles\.1\.bedding = .*only with contact\.normal = \"spring\""):
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
