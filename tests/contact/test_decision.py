"""Decisions about contacts, alone and together: hand-made contact problems with known answers."""

from __future__ import annotations

from collections.abc import Sequence
from math import inf

import numpy as np
import pytest

from oblique_impact.contact.complementarity import Closed, contact_forces
from oblique_impact.contact.decision import Decision, stick_at
from oblique_impact.contact.friction import Coulomb
from oblique_impact.contact.impacts import NewtonImpact
from oblique_impact.contact.pairs import ContactPair
from oblique_impact.contact.state import GUARDS, LOWER, NORMAL, UPPER, Candidate, State, Tolerances
from oblique_impact.contact.stops import ElasticStop
from oblique_impact.contact.transitions import EventKind, StickCriterion, Transition
from oblique_impact.errors import RunEnded

TOLERANCES = Tolerances(gap=1e-12, force=1e-9, velocity=1e-11, time=1.0, energy=1.0)
#: of two normals and two tangents; a push at one contact lifts the other half as much
DELASSUS = np.einsum("ab,cd->acbd", [[1.0, 0.5], [0.5, 1.0]], np.eye(2))
EDGE = 0.3 * 9.8 / 1.5  # N, of the friction cone where each contact carries 9.8 / 1.5 N


class Both:
    """The contact problem of two contacts under the weight of 1 kg each, by what differs from rest in flight."""

    def __init__(
        self, *contacts: dict[str, float], states: Sequence[Candidate] = (Candidate(), Candidate())
    ) -> None:
        problem = {"a_nn": 1.0, "a_tt": 1.0, "gap_acceleration": -9.8}
        self.contacts = [c.changed(**{**problem, **changes}) for c, changes in zip(states, contacts, strict=True)]

    def of(self, contact: int) -> Candidate:
        return self.contacts[contact]

    coupled = of

    def together(self, contacts, impulses):
        found = []
        for i in contacts:
            pushed = sum((DELASSUS[i, :, j] @ [p.normal, p.tangential] for j, p in impulses.items()), np.zeros(2))
            at = self.contacts[i]
            found.append(at.changed(gap_rate=at.gap_rate + pushed[0], slip_rate=at.slip_rate + pushed[1]))
        return found, DELASSUS[np.ix_(contacts, [0, 1], contacts, [0, 1])]


def table_of_two(criterion: StickCriterion | None = None, stop: ElasticStop | None = None) -> Decision:
    laws = Coulomb(0.3, 0.3), NewtonImpact(), TOLERANCES
    return Decision([ContactPair(stop)] * 2, *laws, stick_criterion=criterion)


def directions(change: Transition) -> dict[int, int]:
    """Direction of slip of each contact, 0 where it sticks."""
    slips = {i: (c.lower, c.upper) for i, c in change.states.items() if c.state == State.SLIP}
    return {i: {(0.0, inf): 1, (-inf, 0.0): -1}[slips[i]] if i in slips else 0 for i in change.states}


@pytest.mark.parametrize("drive", [3.0, -3.0])
def test_of_two_contacts_at_rest_the_one_slips_that_is_driven_beyond_its_cone(drive):
    """Both tangents are coupled: 3 m/s^2 is beyond what friction holds, what it does to the other is not."""
    table = table_of_two()
    change = table.start(Both({"slip_acceleration": drive}, {}))
    assert directions(change) == {0: np.sign(drive), 1: 0}
    assert change.events == [(0, EventKind.IMPACT), (1, EventKind.IMPACT)]


@pytest.mark.parametrize(("guard", "direction"), [(LOWER, -1), (UPPER, 1)])
def test_the_end_of_stick_is_slip_though_rounding_puts_it_inside_of_the_cone(guard, direction):
    table = table_of_two()
    stuck = [stick_at(table.opened(0, Candidate()))] * 2
    # friction holds the first at the edge of its cone, the second with a fifth of that
    drives = -DELASSUS[:, 1, :, 1] @ (-direction * EDGE * np.array([1.0 - 1e-12, 0.2]))
    probe = Both(*({"slip_acceleration": drive} for drive in drives), states=stuck)
    change = table.after_guard(guard, [], probe)
    assert directions(change) == {0: direction, 1: 0}
    assert change.events == [(0, EventKind.SLIP)]


def test_impacts_that_alternate_end_with_both_contacts_closed():
    """The second has just been opened by an impact of the first: impulses that push leave no gap rate."""
    table = table_of_two()
    probe = Both({"gap_rate": -2.0, "slip_rate": 1.0}, {"gap_rate": -1.5, "slip_rate": 1.0})
    change = table.after_guard(NORMAL, [1], probe)
    after = [c.gap_rate for c in probe.together([0, 1], change.impulses)[0]]
    assert after == pytest.approx([0.0, 0.0], abs=1e-14)
    assert all(impulse.normal > 0.0 for impulse in change.impulses.values())
    # half the squares of the rates in the metric of the effective masses
    rates = np.array([-2.0, -1.5])
    lost = 0.5 * rates @ np.linalg.solve(DELASSUS[:, 0, :, 0], rates)
    assert sum(impulse.energy_loss for impulse in change.impulses.values()) == pytest.approx(lost, rel=1e-12)
    assert directions(change) == {0: 1, 1: 1}


@pytest.mark.parametrize("contact", [0, 1])
def test_a_scheme_that_notices_stick_late_stops_the_contact_that_it_names(contact):
    table = table_of_two(StickCriterion(0.01), ElasticStop(1e4))
    slides = table.slide(table.opened(0, Candidate()), 1e-3, 1)
    probe = Both(*[{"gap": -1e-3, "slip_rate": 1e-3}] * 2, states=[slides, slides])
    change = table.after_guard(2 * GUARDS + contact, [], probe)
    assert directions(change) == {contact: 0}
    assert change.events == [(contact, EventKind.STICK)]
    assert change.stick_projections[contact].tangential == pytest.approx(-1e-3, rel=1e-12)


class Alone:
    """One contact that touches its stop without speed."""

    def __init__(self, delassus: np.ndarray, free: np.ndarray) -> None:
        (nn, nt), (_, tt) = delassus.tolist()
        gap, slip = free.tolist()
        self.contact = Candidate(a_nn=nn, a_nt=nt, a_tt=tt, gap_acceleration=gap, slip_acceleration=slip)
        self.delassus = delassus.reshape(1, 2, 1, 2)

    def of(self, contact: int) -> Candidate:
        return self.contact

    def together(self, contacts, impulses):
        return [self.contact], self.delassus


def test_the_closed_form_of_one_contact_is_its_solution_by_complementarity():
    """Of 5,000 random contacts at rest each opens, sticks or slips as Lemke's method and enumeration say."""
    random, seen = np.random.default_rng(3), list[State]()
    for _ in range(5000):
        rows, free, mu = random.normal(size=(2, 3)), random.normal(size=2), random.uniform(0.0, 2.0)
        delassus = rows @ rows.T
        table = Decision([ContactPair()], Coulomb(mu, mu), NewtonImpact(), TOLERANCES)
        try:
            found = contact_forces(delassus.reshape(1, 2, 1, 2), free[None], [Closed(0, 0.0, mu, None)])
        except RunEnded as ended:
            with pytest.raises(RunEnded, match=ended.message[:20]):
                table.start(Alone(delassus, free))
            continue
        change, (normal, tangential) = table.start(Alone(delassus, free)), found.forces[0]
        assert change.ambiguous == found.several
        state, expected = State(change.states[0].state), State.FREE
        if normal > 0.0:
            expected = State.STICK if abs(tangential) < mu * normal * (1.0 - 1e-9) else State.SLIP
        assert state == expected
        if state == State.SLIP:
            assert directions(change)[0] == np.sign(found.accelerations[0, 1])
        seen.append(state)
    assert {state for state in State if seen.count(state) > 500} == set(State)


def test_newtons_impact_of_several_contacts_is_that_of_moreau():
    """Each contact that is pushed leaves with the restitution of its approach, the others no slower."""
    normal, rates = DELASSUS[:, 0, :, 0], np.array([-2.0, -0.5])
    impulses = NewtonImpact(0.5).impulses(normal, rates)
    after = rates + normal @ impulses
    assert (impulses >= 0.0).all()
    assert (after + 0.5 * rates >= -1e-14).all()
    assert impulses @ (after + 0.5 * rates) == pytest.approx(0.0, abs=1e-14)
