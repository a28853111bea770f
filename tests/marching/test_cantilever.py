"""The full nodal beam with a held or driven root: orders, agreement with modes, the ledger, steady states.

The strip is that of the case `cantilever`: clamped, shaken across, between two elastic pegs.
"""

import numpy as np
import pytest

from oblique_impact import Scenario, simulate
from oblique_impact.validation import PeriodicSection
from oblique_impact.validation.studies.periodic import steady_state

STRIP = Scenario.builtin("cantilever")
FREE = STRIP.adapted(contact__enabled=False, gravity=0.0)
#: shaken so strongly that both pegs are struck five or six times
STRUCK = STRIP.replace(base__acceleration=2.0, end_time=0.3, solver__output_interval=0.01)
LENGTH = STRIP.beam.length
STIFFNESS = STRIP.beam.youngs_modulus * STRIP.beam.second_moment
OMEGA = 2.0 * np.pi * STRIP.base.frequency


def orders(errors):
    """Observed orders of errors, each with half the step or element of the one before."""
    return np.log2(np.abs(errors[:-1]) / np.abs(errors[1:]))


def in_steps(scenario, step):
    """A scenario by generalized-alpha in steps of one length (s)."""
    return scenario.replace(solver__free_step=step, solver__contact_step=step)


def by_events(scenario, left_out=True, **discretization):
    """A scenario in other coordinates, with what they leave out or not, and events located to the last digits."""
    data = scenario.model_dump(mode="json", exclude_unset=True)
    data |= {"discretization": discretization, "solver": {"scheme": "event", "tolerance": 1e-11}}
    data["contact"]["residual_flexibility"] = left_out
    return Scenario.from_dict(data)


def at_a_node(scenario):
    """A scenario with the pegs at three quarters of the length, a node of every mesh with 4 k elements."""
    pegs = [peg.model_dump(mode="json", exclude_unset=True) for peg in scenario.obstacles]
    pegs = [peg | {"origin": [peg["origin"][0], -0.75 * LENGTH]} for peg in pegs]
    return scenario.replace(obstacles=pegs)


def starts(history):
    return np.array([contact.start for contact in history.contacts])


def impulse(history):
    """Impulse (N s) of all contacts."""
    return sum(contact.normal_impulse for contact in history.contacts)


# --- without contact: the closed form


def harmonic(x, derivative=0):
    """U(x) of the deflection Im(U e^{i omega t}), or a derivative: a Kelvin-Voigt beam on a shaken base.

    E I (1 + i omega eta) U'''' - m omega^2 U = -m A with U = U' = 0 at the clamp, U'' = U''' = 0 at the tip.
    """
    beam, loss = STRIP.beam, 1.0 + 1j * OMEGA * STRIP.beam.kelvin_voigt
    k = (beam.density * beam.area * OMEGA**2 / (STIFFNESS * loss)) ** 0.25
    uniform = STRIP.base.acceleration / OMEGA**2
    c, s, ch, sh = np.cos(k * LENGTH), np.sin(k * LENGTH), np.cosh(k * LENGTH), np.sinh(k * LENGTH)
    conditions = [[1, 0, 1, 0], [0, 1, 0, 1], [-c, -s, ch, sh], [s, -c, sh, ch]]
    a, b, d, e = np.linalg.solve(np.array(conditions), [-uniform, 0, 0, 0])
    circular = a * np.cos(k * x + derivative * np.pi / 2) + b * np.sin(k * x + derivative * np.pi / 2)
    # odd derivatives swap cosh and sinh
    hyperbolic = (d, e) if derivative % 2 == 0 else (e, d)
    curve = circular + hyperbolic[0] * np.cosh(k * x) + hyperbolic[1] * np.sinh(k * x)
    return k**derivative * curve + (uniform if derivative == 0 else 0.0)


def after_a_period(elements, steps):
    """Errors of the tip's deflection and the root's moment, as parts, after a period from the steady state on."""
    period = 2.0 * np.pi / OMEGA
    x = np.linspace(0.0, LENGTH, elements + 1)
    nodes = np.column_stack([harmonic(x), harmonic(x, 1)]).ravel()[1:]  # the clamp does not move
    q = np.append(STRIP.initial.angle, nodes.imag)
    qd = np.append(0.0, (1j * OMEGA * nodes).imag)
    run = FREE.replace(
        discretization__elements=elements,
        end_time=period,
        solver__free_step=period / steps,
        solver__output_interval=0.25 * period,
    )
    history = simulate(run, initial_state=(q, qd))
    moment = STIFFNESS * (1.0 + 1j * OMEGA * STRIP.beam.kelvin_voigt) * harmonic(0.0, 2)
    deflection = float(history["deflection"][-1]) / abs(harmonic(LENGTH))
    return np.array(
        [
            deflection - harmonic(LENGTH).imag / abs(harmonic(LENGTH)),
            (float(history.section_forces()["moment"][-1, 0]) - moment.imag) / abs(moment),
        ]
    )


def test_deflection_and_root_moment_come_to_the_closed_form():
    """At second order over the steps, at fourth over the elements, each with the other one fine."""
    over_steps = np.array([after_a_period(16, steps) for steps in (50, 100, 200)])
    assert orders(over_steps) == pytest.approx(2.0, abs=0.02)
    over_elements = np.array([after_a_period(elements, 4000) for elements in (2, 4, 8)])
    assert orders(over_elements) == pytest.approx(4.0, abs=0.2)
    assert np.abs(over_elements[-1]).max() < 3e-5


# --- with contact: events, modes


def test_steps_come_to_the_events_of_all_modes_of_the_mesh():
    """At second order through six contacts; four elements have eight modes.

    Of these nothing is left out but what a cubic inside of an element does not bend, which all nodes lack too.
    """
    coarse = STRUCK.replace(discretization__elements=4)
    expected = simulate(by_events(coarse, left_out=False, method="fem", elements=4, modes=8))
    found = [simulate(in_steps(coarse, 2e-4 / 2**k)) for k in range(4)]
    assert [len(history.contacts) for history in found] == [len(expected.contacts)] * 4 == [6] * 4
    errors = np.array([impulse(history) for history in found]) - impulse(expected)
    assert orders(errors) == pytest.approx(2.0, abs=0.25)
    assert starts(found[-1]) == pytest.approx(starts(expected), abs=3e-6)
    assert impulse(found[-1]) == pytest.approx(impulse(expected), rel=1e-5)


def test_elements_come_to_the_limit_of_many_modes():
    """At fourth order through five contacts at a node; sixteen modes with what they leave out are the limit."""
    struck = at_a_node(STRUCK)
    expected = simulate(by_events(struck, modes=16))
    fine = in_steps(struck, 5e-6)
    found = [simulate(fine.replace(discretization__elements=elements)) for elements in (4, 8, 16)]
    errors = np.array([impulse(history) for history in found]) - impulse(expected)
    assert orders(errors[:2]) == pytest.approx(4.0, abs=0.2)
    assert starts(found[-1]) == pytest.approx(starts(expected), abs=1e-7)
    assert impulse(found[-1]) == pytest.approx(impulse(expected), rel=5e-6)


def test_modes_reduced_elements_and_all_nodes_agree():
    """Eight modes of each kind by events, the case's own elements in small steps: contacts and their impulses."""
    struck = in_steps(STRUCK, 1e-5)
    nodes, modes = simulate(struck), simulate(by_events(struck, modes=8))
    reduced = simulate(by_events(struck, method="fem", elements=24, modes=8))
    for other, accuracy in ((modes, 1e-5), (reduced, 1e-5)):
        assert starts(nodes) == pytest.approx(starts(other), abs=1e-6)
        for one, two in zip(nodes.contacts, other.contacts, strict=True):
            assert one.obstacle == two.obstacle
            assert one.normal_impulse == pytest.approx(two.normal_impulse, abs=accuracy * impulse(other))


# --- the ledger

SPIN_UP = {
    "root__profile": "spin-up",
    "root__spin_rate": 20.0,
    "root__spin_up_time": 0.15,
    "root__hub_radius": 0.1,
}
LEDGERS = {
    "shaken, with contacts": STRUCK,
    "driven root of a radius": STRIP.adapted(contact__enabled=False, base__acceleration=0.0, **SPIN_UP),
    "both": STRIP.adapted(contact__enabled=False, base__acceleration=20.0, **SPIN_UP),
}


@pytest.mark.parametrize("case", LEDGERS)
def test_the_work_of_base_and_drive_closes_the_balance_of_energy(case):
    """At second order; to 1e-8 of the energies in 25,000 steps.  The iterations must not stop before."""
    base = LEDGERS[case].replace(
        end_time=0.25, discretization__elements=8, solver__tolerance=1e-13, solver__output_interval=0.01
    )
    keys = ["free_step", *(["contact_step"] if base.contact.enabled else [])]

    def balance(step):
        return simulate(base.replace(**{f"solver__{key}": step for key in keys})).balance

    left = [balance(step)["unaccounted"] for step in (2e-4, 1e-4, 5e-5)]
    assert orders(np.array(left)) == pytest.approx(2.0, abs=0.05)
    fine = balance(1e-5)
    assert abs(fine["supplied"]) > 1e-4
    assert abs(fine["unaccounted"]) < 1e-8 * max(abs(fine["final"]), abs(fine["initial"]))


# --- steady states


@pytest.mark.parametrize("scheme", ["generalized-alpha", "time-stepping"])
def test_a_steady_state_in_steps_repeats_and_is_that_of_modes(scheme):
    """Steps of a given length end at whole periods, so a response repeats to far less than a step."""
    settings = PeriodicSection(tolerance=1e-6)
    strip = STRIP.replace(discretization__elements=8, solver__contact_step=1e-4)
    nodes = strip.replace(solver__scheme=scheme)
    history = steady_state(nodes, settings=settings)
    found = history.summary["periodic"]
    assert (found["period"], found["impacts_per_period"]) == (1, 2.0)
    assert history["q"].values[-1] == pytest.approx(history["q"].values[0], abs=1e-6 * LENGTH)
    energy = history.balance
    assert energy["supplied"] == pytest.approx(energy["lost_damping"] + energy["lost_impact"], rel=2e-2)
    expected = steady_state(by_events(strip, modes=6), settings=settings).summary["periodic"]
    assert (expected["period"], expected["impacts_per_period"]) == (1, 2.0)
    assert found["samples"] == pytest.approx(expected["samples"], abs=3e-4 * float(history["deflection"].max()))


def test_a_run_goes_on_from_a_state_with_a_closed_contact():
    """Parted while a peg is touched: the second part begins with the force of the first, as the same contact."""
    contact = simulate(STRUCK).contacts[1]
    first = simulate(STRUCK.replace(end_time=0.5 * (contact.start + contact.end)))
    second = simulate(STRUCK.replace(end_time=0.01), initial_state=first)
    assert first["lambda_n"].values[-1] > 0.01
    for name in ("q", "qd", "lambda_n"):
        assert second[name].values[0] == pytest.approx(first[name].values[-1], rel=1e-9, abs=1e-12), name
    assert (second.contacts[0].start, second.contacts[0].obstacle) == (0.0, contact.obstacle)
