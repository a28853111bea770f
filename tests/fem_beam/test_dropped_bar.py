"""A bar that is dropped: a rigid one's rebound from a soft floor, a slender one's micro-impacts on a stiff one."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from oblique_impact import Scenario, simulate
from oblique_impact.fem_beam.exact import ElasticSections
from oblique_impact.fem_beam.exact import simulate as simulate_absolute
from oblique_impact.fem_beam.exact.exact_system import beam_of

TILT = 0.6  # rad, of the bar to the floor; its last section is the lower end
ARM = 0.5 * np.exp(-1j * TILT)  # m, of this end from the middle of a bar of 1 m
#: travel of the end over the floor and into it (m): so small that the geometry stays as it is
TRAVEL = 2e-8


def routh(mass: float, velocity: complex, spin: float, mu: float) -> tuple[complex, float]:
    """Return velocity and spin of a slender rigid bar after it has struck with its end, e = 1, sliding throughout.

    The impulse P (i - mu sign(v_t)) at the arm r turns the bar by Im(r* p)/J, J = m L^2/12, and P takes the normal
    velocity of the end from v_n to -v_n.
    """
    end = velocity + 1j * spin * ARM
    direction = 1j - mu * np.sign(end.real)
    lever = (ARM.conjugate() * direction).imag
    impulse = -2.0 * end.imag / (1.0 / mass + ARM.real * lever * 12.0 / mass)
    return velocity + impulse * direction / mass, spin + impulse * lever * 12.0 / mass


def on_a_spring(mass: float, velocity: complex, spin: float, mu: float) -> tuple[complex, float]:
    """Return the same of a rigid bar on a spring, by integrating its motion in its first configuration."""
    sense = np.sign((velocity + 1j * spin * ARM).real)

    def rate(_: float, y: np.ndarray) -> list[float]:
        force = -min(y[0], 0.0) * (1j - mu * sense)
        end = complex(y[1], y[2]) + 1j * y[3] * ARM
        return [end.imag, force.real / mass, force.imag / mass, 12.0 / mass * (ARM.conjugate() * force).imag]

    def opens(_: float, y: np.ndarray) -> float:
        return float(y[0])

    opens.terminal, opens.direction = True, 1.0  # type: ignore[attr-defined]
    start = [-1e-12, velocity.real, velocity.imag, spin]
    end = solve_ivp(rate, (0.0, 10.0), start, events=opens, rtol=1e-10, atol=1e-13).y[:, -1]
    return complex(end[1], end[2]), float(end[3])


@pytest.mark.parametrize(("mu", "along"), [(0.0, 0.3), (0.3, 3.0), (0.3, -3.0)])
def test_rouths_rebound_is_that_of_a_rigid_bar_on_a_spring(mu, along):
    found, expected = (rebound(0.8, along - 1j, 0.2, mu) for rebound in (routh, on_a_spring))
    assert found == pytest.approx(expected, abs=1e-7)
    if mu == 0.0:
        energies = [0.4 * abs(v) ** 2 + 0.4 / 12.0 * w**2 for v, w in (found, (along - 1j, 0.2))]
        assert energies[0] == pytest.approx(energies[1], rel=1e-14)


@pytest.mark.parametrize(("mu", "along"), [(0.0, 0.3), (0.3, 3.0)])
def test_on_a_soft_floor_a_bar_rebounds_as_a_rigid_one(mu, along):
    """Of k L^3/(E I) = 10, 3 and 1, where k L/(E A) is at most 2.5e-4: what vibrates on is left out."""
    friction = [f"contact.mu_static={mu}", f"contact.mu_kinetic={mu}"] if mu else ["contact.friction=frictionless"]
    beam, off = Scenario.builtin("paper").beam, []
    mass, stiffness = beam.density * beam.area, beam.youngs_modulus * beam.second_moment
    for ratio in (10.0, 3.0, 1.0):
        lasts = float(np.pi * np.sqrt(mass / (1.0 + 3.0 * np.cos(TILT) ** 2) / (ratio * stiffness)))  # s, about
        speed, step = TRAVEL / lasts, lasts / 300.0
        velocity, spin = speed * (along - 1j), 0.2 * speed
        words = [
            "root.kind=free discretization.method=absolute discretization.elements=8 contact.where=anywhere",
            "contact.grid=1 contact.normal=spring slope.angle=0 slope.origin=[0,0] gravity=0",
            "solver.tolerance=1e-2",
            *friction,
            f"contact.stiffness={ratio * stiffness} initial.angle={-TILT} initial.angular_velocity={spin}",
            f"initial.position=[0,{0.5 * float(np.sin(TILT)) + 0.1 * TRAVEL}] end_time={1.6 * lasts}",
            f"initial.velocity=[{velocity.real},{velocity.imag}] solver.output_interval={lasts / 10.0}",
            f"solver.free_step={step} solver.contact_step={step}",
        ]
        scenario = Scenario.builtin("paper", " ".join(words).split())
        sections = ElasticSections.bernoulli_euler(scenario)
        run = simulate_absolute(scenario, sections=sections)
        assert [event.kind.value for event in run.events] == ["impact", "release"]
        v = run["qd"].values[-1]
        masses = np.asarray(beam_of(scenario, sections).M[::3, ::3].sum(axis=0)).ravel()
        moved, turns = (v[::3] + 1j * v[1::3]) @ masses / mass, float(run["theta_dot"][-1])
        after, spun = routh(mass, velocity, spin, mu)
        off.append(max(abs(moved - after), abs(turns - spun)) / abs(velocity))
    assert off[0] < 0.01
    assert off[1] < off[0] / 3.5
    assert off[2] < min(off[1] / 3.5, 3e-5), off


def strikes(**changes: object) -> tuple[int, float]:
    """How often the lower end of the case strikes, and the velocity after that a rigid bar's end would have."""
    run = simulate(Scenario.builtin("dropped-bar").replace(**changes))
    assert abs(run.balance["unaccounted"]) < 1e-11 * run.balance["initial"]
    last = run.at(max(contact.end for contact in run.contacts))
    length = run.scenario.beam.length
    assert {contact.first_place for contact in run.contacts} == {length}
    end = length * np.exp(1j * float(last["theta"]))
    return len(run.contacts), float(last["origin_vy"]) + (1j * float(last["theta_dot"]) * end).imag


def test_a_slender_bar_strikes_a_stiff_floor_several_times():
    """Its restitution falls with the angle, far more than that of a stout one, which strikes once; converged."""
    steep = {"initial__angle": -np.pi / 3.0, "initial__position": (0.0, 0.1 * np.sin(np.pi / 3.0) + 1e-5)}
    count, restitution = strikes()
    assert count == 4
    finer = strikes(discretization__elements=64, solver__tolerance=1e-10)
    assert finer == (4, pytest.approx(restitution, abs=1e-3))
    count, of_steep = strikes(**steep)
    assert count == 4
    assert of_steep < restitution - 0.1
    stout = {"beam__section__diameter": 0.02, "discretization__elements": 16}
    found = [strikes(**stout), strikes(**stout, **steep)]
    assert [count for count, _ in found] == [1, 1]
    assert min(value for _, value in found) > restitution + 0.1
