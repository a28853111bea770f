"""Histories of a dozen scenarios held to identities that are computed apart from the program.

Each scenario strikes its slope at once.  Together they have every root, frame, order of kinetics, scheme, stop and
friction law, hubs with a radius, point masses and forces, tapered sections, damping, and contacts inside of the
span.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from oblique_impact import Scenario, simulate
from oblique_impact.contact.state import State
from oblique_impact.contact.transitions import EventKind
from oblique_impact.renders.geometry import BeamGeometry
from tests.history.recomputed import ExactBeam, cross, recomputed

TAPER = (
    "beam.area=[[0,3.6e-4],[0.45,3e-4],[1.1,2.2e-4]] beam.second_moment=[[0,9.5e-9],[0.7,7e-9],[1.1,5e-9]] "
    "beam.tip_mass=0.15"
)
INSIDE, SPRING = "contact.point=0.88", "contact.normal=spring contact.stiffness=2e5"
#: without what the modes leave out, which moves the place where it touches away from that of the coordinates
ALONE = f"{SPRING} contact.residual_flexibility=false"
SHAKEN = "base.acceleration=400 base.frequency=90 base.direction=0.8"
MEAN_AXIS, FULL = "discretization.frame=mean-axis", "discretization.kinetics=full"
#: its elements integrate masses that are smooth in each of them, and find forces at two points of each
EXACT = (
    "discretization.method=absolute "
    "discretization.nodes=[0,0.07,0.13,0.21,0.3,0.37,0.45,0.57,0.7,0.79,0.88,0.99,1.1]"
)


#: with nodes at masses and forces
LOADED_EXACT = (
    "discretization.method=absolute "
    "discretization.nodes=[0,0.07,0.14,0.21,0.28,0.35,0.41,0.48,0.55,0.62,0.7,0.78,0.86,0.93,0.98,1.02,1.06,1.1]"
)


def steps(scheme="", length=1e-5):
    """Steps of fixed length, which the samples are to follow."""
    keys = " ".join(f"solver.{key}={length}" for key in ("free_step", "contact_step", "output_interval"))
    return f"{keys} solver.scheme={scheme}" if scheme else keys


def hub(radius, inertia=0.04, torque=-1.5):
    return f"root.kind=hub root.hub_radius={radius} root.inertia={inertia} root.torque={torque}"


def driven(radius):
    return f"root.kind=driven root.hub_radius={radius} root.profile=constant-speed root.spin_rate=-3.4"


def modal(modes=3):
    return f"discretization.modes={modes}"


def fem(modes=3):
    nodes = "discretization.nodes=[0,0.13,0.3,0.52,0.7,0.88,1.1]"
    return f"discretization.method=fem {nodes} discretization.modes={modes}"


#: between nodes of a mesh
MASSES = "masses=[{place=0.41,mass=0.2,inertia=0.004},{place=0.93,mass=0.05,inertia=0.001}] beam.tip_mass=0.03"
#: across and fixed in space; each kind over time
FORCES = (
    "forces=[{place=0.62,force=150,frequency=90,sweep_rate=2000},{force=40,direction=0.4},"
    "{place=0.35,table=[[0,-60],[0.02,90]]}]"
)
LOADED = f"{MASSES} {FORCES}"
SHAPED = "beam.section={shape='rectangle',width=0.02,height=[[0,0.022],[1.1,0.012]]}"
CASES = {
    "hub": f"{hub(0.5)} {modal()}",
    "hub, full, spring inside": f"{hub(0.2, 0.02)} {ALONE} {INSIDE} contact.damping=0.3 {FULL} {modal(4)} "
    "beam.mass_proportional=50 beam.modal_damping_ratio=0.02",
    "hub, zeroth order": f"{hub(0.1, torque=0.8)} {INSIDE} contact.friction=modified-coulomb "
    f"discretization.kinetics=zeroth-order {modal(2)}",
    "driven, full, Routh": f"{driven(0.15)} {TAPER} beam.kelvin_voigt=2e-5 contact.impact=routh "
    f"contact.restitution=0.3 {FULL} {fem()}",
    "driven, spring, without shortening": f"{driven(0.1)} {ALONE} {INSIDE} contact.shortening=false {modal(2)} "
    f"{steps('fixed-step')}",
    "tapered on a hub, fixed steps": f"{hub(0.08)} {TAPER} {INSIDE} {fem()} {steps('fixed-step')}",
    "pin, mean axis, full": f"beam.mass_proportional=3 contact.mu_static=0.5 {MEAN_AXIS} {FULL} {modal(4)}",
    "mean axis on a hub, spring, implicit": f"{hub(0.0, 0.01)} {TAPER} {ALONE} {MEAN_AXIS} {fem()} "
    f"{steps('generalized-alpha')}",
    "shaped hub, massless point, implicit": f"{hub(0.1)} {SHAPED} contact.point_inertia=none {fem(4)} "
    f"{steps('generalized-alpha')}",
    # its contact is closed at the end
    "all nodes, spring inside": f"{TAPER} beam.kelvin_voigt=1e-6 {SPRING} {INSIDE} {fem(0)} {steps()} "
    "end_time=0.006",
    "all nodes on a hub": f"{hub(0.0)} {SPRING} beam.outer_fibre=0.014 contact.friction=frictionless {fem(0)} "
    f"{steps(length=2e-6)} end_time=0.004",
    "exact, driven": f"{driven(0.12)} {TAPER} {SPRING} {INSIDE} {EXACT} {steps()} end_time=0.004",
    "exact, mean axis": f"{SPRING} contact.friction=frictionless {MEAN_AXIS} {EXACT} {steps()} end_time=0.004",
    "loaded hub, full": f"{hub(0.2, 0.02)} {LOADED} {ALONE} {FULL} {modal(4)} beam.mass_proportional=50 "
    "beam.modal_damping_ratio=0.02",
    "loaded, mean axis": f"{LOADED} beam.mass_proportional=3 {MEAN_AXIS} {FULL} {modal(4)}",
    "loaded, zeroth order": f"{LOADED} discretization.kinetics=zeroth-order {modal(2)}",
    "loaded, driven": f"{driven(0.15)} {TAPER} {LOADED} beam.kelvin_voigt=2e-5 {FULL} {fem()}",
    "loaded, all nodes": f"{LOADED} {SPRING} {fem(0)} {steps()} end_time=0.006",
    "loaded, all nodes on a hub": f"{hub(0.1)} {LOADED} {SPRING} {fem(0)} {steps()} end_time=0.006",
    "loaded, exact, driven": f"{driven(0.12)} {LOADED} {SPRING} {LOADED_EXACT} {steps(length=5e-6)} "
    "end_time=0.004",
    "loaded, exact, mean axis": f"{LOADED} {SPRING} {MEAN_AXIS} {LOADED_EXACT} {steps()} end_time=0.004",
    "shaken, spring": f"{SHAKEN} {ALONE} {MEAN_AXIS} {modal()}",
    "shaken, all nodes": f"{SHAKEN} {SPRING} {fem(0)} {steps()} end_time=0.006",
    "shaken, exact": f"{SHAKEN} {TAPER} {SPRING} {INSIDE} {EXACT} {steps()} end_time=0.004",
}


@cache
def scenario_of(name, seed=31):
    """A scenario whose contact point is a little above its slope and falls on it; angles are drawn at random."""
    rng = np.random.default_rng([seed, list(CASES).index(name)])
    keys = ["beam.length=1.1", "end_time=0.012", "solver.output_interval=2e-5", *CASES[name].split()]
    given = Scenario.from_toml("", keys)
    angle, slope = rng.uniform(-0.5, 0.7), rng.uniform(-0.4, 0.4)
    slope = angle - np.sign(slope) * (0.1 + abs(slope))
    # 1 mm above it, and some way along it
    reach = given.root.hub_radius + given.contact.point
    origin = reach * np.exp(1j * angle) - (1e-3j + rng.uniform(-0.2, 0.2)) * np.exp(1j * slope)
    speed = 0.0 if given.root.kind == "driven" else -3.6
    start = {"initial__angle": angle, "initial__angular_velocity": speed}
    return given.replace(**start, slope__origin=[origin.real, origin.imag], slope__angle=slope)


@cache
def beam_of(name):
    return recomputed(simulate(scenario_of(name)))


@pytest.fixture(params=CASES)
def beam(request):
    return beam_of(request.param)


def close(found, expected, part, least=0.0):
    """Largest difference over the largest expected value, which is at least `least`."""
    apart, scale = np.nanmax(np.abs(np.asarray(found) - expected)), max(float(np.nanmax(np.abs(expected))), least)
    assert apart <= part * scale, f"{apart:.3g} of {scale:.3g}: {apart / scale:.3g} > {part:g}"


def along(beam, direction, z):
    """Component of places or velocities in a direction."""
    return np.real(np.conj(direction) * z)


def test_the_cases_have_every_kind_of_event():
    """So that nothing below is checked in vain."""
    assert {event.kind for name in CASES for event in beam_of(name).history.events} == set(EventKind)


def test_places_and_velocities_are_those_of_the_coordinates(beam):
    h, at = beam.history, beam.touch
    found = {
        "theta": beam.theta,
        "theta_dot": beam.spin,
        "tip_x": beam.contact_place.real,
        "tip_y": beam.contact_place.imag,
        "tip_vx": beam.contact_velocity.real,
        "tip_vy": beam.contact_velocity.imag,
        "ux": beam.ux,
        "uy": beam.uy,
        "ux_dot": beam.ux_dot,
        "uy_dot": beam.uy_dot,
        "shortening": beam.ux[:, at],
        "deflection": beam.uy[:, at],
    }
    origin = complex(*beam.scenario.slope.origin)
    for direction, name in ((beam.normal, "gap"), (beam.tangent, "slip")):
        found[name] = along(beam, direction, beam.seen_by_contact - origin)
        found[f"{name}_rate"] = along(beam, direction, beam.rate_seen_by_contact)
    # a point without inertia slips by what the coordinates leave out as well
    some = (h["state"].values == State.FREE) | (beam.scenario.contact.point_inertia == "kept")
    for name, expected in found.items():
        part = some if name.startswith("slip") else slice(None)
        close(h[name].values[part], expected[part], 1e-10, 1e-3)
    assert beam.x[at] == pytest.approx(beam.scenario.contact.point, abs=1e-12)


def from_mean_axis(name):
    """Whether a case has deflections in modes or elements from the mean axis."""
    discretization = scenario_of(name).discretization
    return discretization.method != "absolute" and discretization.frame == "mean-axis"


@pytest.mark.parametrize("name", list(filter(from_mean_axis, CASES)))
def test_deflections_from_the_mean_axis_do_not_turn_beam_and_hub(name):
    """sum m (r + x) u_y + J_h u_y'(0) = 0, and so its rate: one rigid rotation belongs to theta alone."""
    beam = beam_of(name)
    for B in (beam.B, beam.Bd):
        assert np.abs(beam.turned(B)).max() < 1e-10 * (np.abs(B @ beam.values.T) @ (beam.mass * beam.arms)).max()


RATES = {
    "q": "qd",
    "theta": "theta_dot",
    "tip_x": "tip_vx",
    "tip_y": "tip_vy",
    "gap": "gap_rate",
    "slip": "slip_rate",
    "ux": "ux_dot",
    "uy": "uy_dot",
}


def test_velocities_are_the_derivatives_of_places(beam):
    h, pieces = beam.history, [piece for piece in beam.pieces if piece.size > 20]
    assert pieces
    for name, rate in RATES.items():
        y, yd = h[name].values, h[rate].values
        for piece in pieces:
            close(y[piece] - y[piece[0]], beam.over(piece, yd), rough(beam), 1e-6)


def test_energies_are_integrals_along_the_beam(beam):
    h, found = beam.history, beam.history.summary["energy"]
    size = float(np.ptp(beam.gravity_energy)) + beam.kinetic[0]
    for part, values in (("kinetic", beam.kinetic), ("elastic", beam.elastic), ("gravity", beam.gravity_energy)):
        close(h[f"energy_{part}"].values, values, 1e-10, size)
        assert found[part] == pytest.approx(values[-1], abs=1e-10 * size)
    assert found["initial"] == pytest.approx(beam.total[0], abs=1e-10 * size)


def integral(beam, f, start=-np.inf, end=np.inf):
    """Integral over time of f (samples, ...), of the pieces from `start` to `end` (s)."""
    inside = [p for p in beam.pieces if beam.time[p[0]] >= start and beam.time[p[-1]] <= end]
    return sum((beam.over(piece, f)[-1] for piece in inside), 0.0)


def has_impacts(name):
    """Whether the stop of a case is rigid, and its contact point has inertia."""
    contact = scenario_of(name).contact
    return contact.normal == "rigid" and contact.point_inertia == "kept"


def sides(beam, event):
    """Numbers of the samples just before and just after an event."""
    (left,) = np.flatnonzero(beam.time == event.time)
    return left, left + 1


@pytest.mark.parametrize("name", [name for name in CASES if has_impacts(name)])
def test_an_impulse_is_the_jump_of_momentum(name):
    """M (q'+ - q'-) = D_n P_n + D_t P_t with a mass matrix by quadrature; a driven root takes what it takes."""
    beam = beam_of(name)
    first = 1 if beam.scenario.root.kind == "driven" else 0
    impacts = [event for event in beam.history.events if event.kind.impulsive]
    assert max(event.normal_impulse for event in impacts) > 0.0
    for event in impacts:
        left, right = sides(beam, event)
        gained = beam.mass_matrix(left) @ (beam.qd[right] - beam.qd[left])
        turn, (_, row) = np.exp(-1j * beam.theta[left]), beam.gradients(left)
        given = event.normal_impulse * along(beam, turn * beam.normal, row)
        given = given + event.tangential_impulse * along(beam, turn * beam.tangent, row)
        part = 1e-7 if beam.scenario.solver.scheme == "event" else 1e-5  # of its iterations
        close(gained[first:], given[first:], part, 1e-6)


def work_of_impulses(beam, event):
    left, right = sides(beam, event)
    rates = (beam.history[name].values for name in ("gap_rate", "slip_rate"))
    (gap, slip) = (0.5 * (rate[left] + rate[right]) for rate in rates)
    return event.normal_impulse * gap + event.tangential_impulse * slip


def test_impacts_lose_the_work_of_their_impulses(beam):
    for event in beam.history.events:
        left, right = sides(beam, event)
        rates = (beam.history["gap_rate"].values[left], beam.history["slip_rate"].values[right])
        assert (event.normal_velocity, event.tangential_velocity) == pytest.approx(rates, abs=1e-9)
        if event.kind.impulsive:
            loss = -work_of_impulses(beam, event)
            assert event.energy_loss == pytest.approx(loss, rel=1e-6, abs=1e-9)
            if beam.scenario.root.kind != "driven":
                assert loss == pytest.approx(beam.total[left] - beam.total[right], rel=1e-5, abs=1e-8)


def rough(beam):
    """Relative error of integrals over the samples."""
    scheme, stop = beam.scenario.solver.scheme, beam.scenario.contact.normal
    if scheme == "event":
        return 1e-6
    if scheme == "fixed-step":
        return 3e-4  # its contacts begin and end a part of a step late
    # implicit steps are of the second order; the force of a rigid stop on a whole mesh changes from step to step
    return 5e-2 if stop == "rigid" else 5e-3


def test_impulses_are_the_integrals_of_the_forces_and_the_impacts(beam):
    h = beam.history
    normal, tangential = (np.nan_to_num(h[name].values) for name in ("lambda_n", "lambda_tau"))
    power = -tangential * h["slip_rate"].values
    if beam.scenario.contact.normal == "spring":
        power = power - normal * h["gap_rate"].values  # all that an elastic stop does not give back
    rows = {event.time: event for event in h.events if event.kind.value == "release"}
    assert h.contacts
    for contact in h.contacts:
        span = contact.start, contact.end
        finite = [integral(beam, f, *span) for f in (normal, tangential, power)]
        hits = [e for e in h.events if e.kind.impulsive and span[0] <= e.time <= span[1]]
        whole = [
            finite[0] + sum(e.normal_impulse for e in hits),
            finite[1] + sum(e.tangential_impulse for e in hits),
        ]
        part = rough(beam)
        scale = max(whole[0], 1e-3)
        assert contact.normal_impulse == pytest.approx(whole[0], abs=part * scale)
        assert contact.tangential_impulse == pytest.approx(whole[1], abs=part * scale)
        row = rows.get(contact.end)
        if row is None:
            assert contact.end == beam.time[-1] or contact.start == contact.end
            continue
        lost = finite[2] + sum(e.energy_loss for e in hits)
        assert row.normal_impulse == pytest.approx(finite[0], abs=part * scale)
        assert row.tangential_impulse == pytest.approx(finite[1], abs=part * scale)
        assert contact.energy_loss == pytest.approx(lost, abs=part * max(abs(lost), 0.02))
        assert row.energy_loss == pytest.approx(finite[2], abs=part * max(abs(lost), 0.02))
        inside = (beam.time >= span[0]) & (beam.time <= span[1])
        assert contact.peak_force == pytest.approx(normal[inside].max(), rel=2e-2)
        gap = h["gap"].values
        deepest = np.flatnonzero(inside)[np.argmin(gap[inside])]
        stored = 0.5 * normal[deepest] * -gap[deepest] if beam.scenario.contact.normal == "spring" else 0.0
        if beam.scenario.contact.point_inertia == "kept":
            assert contact.peak_energy == row.peak_energy == pytest.approx(stored, rel=1e-2, abs=1e-9)


def test_the_ledger_is_that_of_the_integrals(beam):
    h, s, energy = beam.history, beam.scenario, beam.history.summary["energy"]
    normal, tangential = (np.nan_to_num(h[name].values) for name in ("lambda_n", "lambda_tau"))
    size = beam.kinetic[0]
    part = rough(beam) * size
    friction = integral(beam, -tangential * h["slip_rate"].values)
    assert energy["lost_friction"] == pytest.approx(friction, abs=part)
    impact = -sum(work_of_impulses(beam, e) for e in h.events if e.kind.impulsive)
    assert energy["lost_impact"] == pytest.approx(impact, abs=part)
    damping, stored = integral(beam, beam.damping_power), 0.0
    if s.contact.normal == "spring":
        if h["state"].values[-1] != State.FREE:
            assert s.contact.damping == 0.0
            stored = -0.5 * normal[-1] * h["gap"].values[-1]
        damping = damping + integral(beam, -normal * h["gap_rate"].values) - stored
    assert energy["contact"] == pytest.approx(stored, abs=part)
    assert energy["lost_damping"] == pytest.approx(damping, abs=part)
    supplied = energy["supplied"]
    if s.root.kind != "driven":
        of_base = along(beam, beam.felt + 1j * s.gravity, beam.v_points) @ beam.mass
        given = s.root.torque * beam.hub_spin + of_base + of_forces(beam)
        assert supplied == pytest.approx(integral(beam, given), abs=part)
    elif s.discretization.kinetics == "full" or isinstance(beam, ExactBeam):
        # at constant speed: that times what the driver adds to the angular momentum
        z, v, g = beam.z_points, beam.v_points, beam.felt
        momentum = cross(z, v) @ beam.mass + beam.turning.sum(axis=1)
        load = cross(z, g) @ beam.mass + cross(beam.contact_place, beam.contact_force)
        load = load + sum(cross(at, force) for _, at, _, force in beam.forces)
        driver = momentum[-1] - momentum[0] - integral(beam, load)
        for event in h.events:
            if event.kind.impulsive:
                push = event.normal_impulse * beam.normal + event.tangential_impulse * beam.tangent
                driver -= cross(beam.contact_place[sides(beam, event)[0]], push)
        assert supplied == pytest.approx(s.root.spin_rate * driver + integral(beam, of_forces(beam)), abs=part)
    lost = sum(energy[f"lost_{name}"] for name in ("impact", "friction", "damping", "scheme"))
    final = beam.total[-1] + stored
    assert energy["final"] == pytest.approx(final, abs=part)
    assert beam.total[0] + supplied - lost - final == pytest.approx(0.0, abs=part)


def of_forces(beam):
    """Power (W) of the forces on the beam, (samples,)."""
    return sum((along(beam, force, v) for _, _, v, force in beam.forces), np.zeros(beam.time.size))


def section_forces(beam):
    """Forces, inertial, and moments that a section passes on to what lies inside of it, (samples, stations)."""
    h, turn = beam.history.section_forces(), np.exp(1j * beam.theta)[:, None]
    axial = h["axial_force"].values
    across = (beam.axis_tangent.imag * axial - h["shear"].values) / beam.axis_tangent.real
    return turn * (axial + 1j * across), h["moment"].values


def test_section_forces_carry_the_outer_part(beam):
    """Momentum and angular momentum of what lies outside of a section change by its loads less these forces."""
    h, x = beam.history.section_forces(), beam.x
    force, moment = section_forces(beam)
    z, p = beam.z_points, beam.v_points * beam.mass
    load = beam.drag + beam.felt * beam.mass
    turning = cross(z, p) + beam.turning
    part = 2e-2 if isinstance(beam, ExactBeam) else rough(beam)
    for k in (0, x.size // 3, beam.touch, x.size - 1):
        outer = beam.outside(x[k])
        touched = beam.contact_force * (k <= beam.touch)
        given = load[:, outer].sum(axis=1) + touched - force[:, k]
        arm = (cross(z, load) + beam.turning_drag)[:, outer].sum(axis=1) + cross(beam.contact_place, touched)
        for place, at, _, pull in beam.forces:
            given = given + pull * (place >= x[k] - 1e-12)
            arm = arm + cross(at, pull) * (place >= x[k] - 1e-12)
        arm = arm - moment[:, k] - cross(beam.z[:, k], force[:, k])
        for piece in beam.pieces:
            if piece.size < 20:
                continue
            span = beam.time[piece[-1]] - beam.time[piece[0]]
            for momentum, rate, scale in (
                (p[:, outer].sum(axis=1), given, np.abs(force).max()),
                (turning[:, outer].sum(axis=1), arm, np.abs(moment).max()),
            ):
                change = momentum[piece] - momentum[piece[0]] - beam.over(piece, rate)
                apart = float(np.abs(change).max() / span / scale)
                assert apart < part, (k, apart)
    modulus = beam.fibre(x) / beam.second_moment(x)
    close(h["bending_stress"].values, modulus * moment, 1e-12)


def is_free_and_full(name):
    """Whether the root of a case is free to turn, and nothing of the kinetic energy is dropped."""
    scenario = scenario_of(name)
    return scenario.root.kind != "driven" and scenario.discretization.kinetics == "full"


@pytest.mark.parametrize("name", list(filter(is_free_and_full, CASES)))
def test_the_root_turns_the_hub_and_a_pin_carries_no_moment(name):
    """J_h (theta' + phi'(0)')' = torque + the forces of the root's section + the share of damping."""
    beam = beam_of(name)
    assert np.abs(beam.drag).max() > 0.0
    force, moment = section_forces(beam)
    turning = moment[:, 0] + cross(beam.z[:, 0], force[:, 0])
    if beam.hub_inertia == 0.0:
        assert np.abs(turning).max() < 1e-11 * np.abs(moment).max()
        return
    given, spin = beam.scenario.root.torque + turning + beam.hub_drag, beam.hub_inertia * beam.hub_spin
    assert np.abs(beam.hub_drag).max() > 1e-3 * np.abs(turning).max()
    for piece in (piece for piece in beam.pieces if piece.size >= 20):
        apart = spin[piece] - spin[piece[0]] - beam.over(piece, given)
        span = beam.time[piece[-1]] - beam.time[piece[0]]
        assert np.abs(apart).max() < rough(beam) * span * np.abs(turning).max()


def test_the_clearance_is_the_smallest_distance_of_the_axis(beam):
    h = beam.history
    at = np.concatenate([[0.0], beam.points, beam.places_of_masses])
    order = np.argsort(at, kind="stable")
    at, z = at[order], np.column_stack([beam.z[:, 0], beam.z_points])[:, order]
    height = along(beam, beam.normal, z - complex(*beam.scenario.slope.origin))
    every = slice(None, None, 7)
    found, place, height = h["clearance"].values[every], h["clearance_at"].values[every], height[every]
    # between two points of the quadrature the axis bends by less
    np.testing.assert_allclose(found, height.min(axis=1), rtol=0.0, atol=1e-5)
    there = [np.interp(x, at, row) for x, row in zip(place, height, strict=True)]
    np.testing.assert_allclose(there, found, rtol=0.0, atol=1e-5)


def few(beam):
    """Some samples: the first, that of the largest force, the last."""
    return np.unique([0, int(np.nanargmax(beam.history["lambda_n"].values)), beam.time.size - 1])


def plane(points):
    return points[..., 0] + 1j * points[..., 1]


def test_drawn_points_are_those_of_the_history(beam):
    geometry = BeamGeometry(beam.history, 1.0)
    stations = np.searchsorted(geometry.stations, beam.x - 1e-12)
    for k in few(beam):
        close(plane(geometry.stations_at(k)), beam.z[k], 1e-12)
        close(plane(geometry.centreline(k))[stations], beam.z[k], 1e-12)
        close(plane(geometry.along("velocity", k))[stations], beam.v[k], 1e-10, 1e-2)
        close(plane(geometry.contact_point(k)), beam.contact_place[k], 1e-12)
        close(plane(sum(geometry.contact_forces(k))), beam.contact_force[k], 1e-12, 1.0)
        close(plane(beam.history.beam_at(beam.time[k], "left")), beam.z[k], 1e-12)
