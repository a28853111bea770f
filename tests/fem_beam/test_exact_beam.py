"""The geometrically exact beam itself: strains, tangents, statics, steps, conservation, literature problems."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from oblique_impact.fem_beam.exact import ElasticSections, ExactBeam, Stage, advance
from oblique_impact.fem_beam.exact.exact_beam import strains
from oblique_impact.kernels.band_rows import BANDWIDTH

EI = 541.27
#: a slender beam of unit length: radius of gyration 1e-4
SLENDER = ElasticSections.uniform(EI / 1e-8, 0.4 * EI / 1e-8, EI, 0.87)
#: Simo and Vu-Quoc's flying rod (1986, Part II): E A = G A = 1e4, E I = 500, rho A = 1, rho I = 10, length 10
FLYING = ElasticSections.uniform(1e4, 1e4, 500.0, 1.0, 10.0)
UNEVEN = np.array([0.0, 0.1, 0.35, 0.6, 1.0])


def beam(elements: int = 8, sections: ElasticSections = SLENDER, length: float = 1.0) -> ExactBeam:
    return ExactBeam(np.linspace(0.0, length, elements + 1), sections)


def shaken(b: ExactBeam, size: float, seed: int) -> np.ndarray:
    return b.straight(0.4) + size * np.random.default_rng(seed).normal(size=b.size)


def product(band: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Product of a banded matrix with a vector, from the definition of its storage."""
    dense = np.zeros((v.size, v.size))
    for i in range(v.size):
        for j in range(max(0, i - BANDWIDTH), min(v.size, i + BANDWIDTH + 1)):
            dense[i, j] = band[BANDWIDTH + i - j, j]
    return dense @ v


@pytest.mark.parametrize(("extension", "shear"), [(0.1, 0.0), (0.0, 0.2), (-0.05, 0.3)])
def test_patch_of_constant_strain(extension, shear):
    """On an uneven mesh: the strain is the constant one, and only the ends feel a force."""
    b = ExactBeam(UNEVEN, SLENDER)
    turn = np.exp(0.7j)
    r = turn * (1.0 + extension + 1j * shear) * b.x
    q = np.stack([r.real, r.imag, np.full(b.x.size, 0.7)], axis=1).ravel()
    found = strains(b.fields(q))
    assert np.abs(found - (extension + 1j * shear)).max() < 1e-13
    forces = b.static_forces(q).forces
    expected = turn * (EI / 1e-8 * extension + 0.4j * EI / 1e-8 * shear)
    assert forces[-3] + 1j * forces[-2] == pytest.approx(expected, rel=1e-10)
    assert np.abs(forces.reshape(-1, 3)[1:-1, :2]).max() < 1e-10 * abs(expected)


@pytest.mark.parametrize("turn", [1e-4, 0.5])
@pytest.mark.parametrize("relaxation", [0.0, 0.3])
def test_tangent_of_a_step_is_the_derivative_of_its_forces(turn, relaxation):
    b = beam(3, FLYING, 10.0)
    q0 = shaken(b, 0.3, 4)
    q1 = q0 + turn * np.random.default_rng(5).normal(size=b.size)
    direction, step = np.random.default_rng(6).normal(size=b.size), 1e-5
    ahead, behind = (b.step_forces(q0, q1 + s * step * direction, relaxation).forces for s in (1, -1))
    exact = product(b.step_forces(q0, q1, relaxation).tangent, direction)
    assert np.abs(exact - (ahead - behind) / (2 * step)).max() < 1e-8 * np.abs(exact).max()


# --- dynamics


def test_order_of_the_step_in_time():
    """A pinned rod falls from the horizontal and bends: its centre of mass in the first second."""
    b, ends = beam(4, FLYING, 10.0), []
    for length in (0.01, 0.005, 0.0025, 0.00125):
        stage, every, places = Stage(b.straight(0.0), np.zeros(b.size)), round(0.02 / length), []
        for k in range(round(1.0 / length)):
            stage = advance(b, stage, length, b.weight(9.8), held=np.zeros(2)).stage
            if (k + 1) % every == 0:
                places.append((b.M @ stage.q).reshape(-1, 3)[:, :2].sum(axis=0) / 10.0)
        ends.append(np.array(places))
    differences = [np.abs(b - a).max() for a, b in pairwise(ends)]
    order = 0.5 * np.log2(differences[0] / differences[-1])
    assert 1.85 < order < 2.15, differences
    assert differences[-1] < 5e-5


def test_damping_takes_what_the_energy_loses():
    b, viscosity, length = beam(6, FLYING, 10.0), 1e-3, 0.02
    start = stage = Stage(shaken(b, 0.05, 11), np.zeros(b.size))
    lost = 0.0
    for _ in range(20):
        step = advance(b, stage, length, np.zeros(b.size), held=np.zeros(0), viscosity=viscosity)
        lost += b.damping_loss(stage.q, step.stage.q, viscosity / length)
        stage = step.stage
    gone = b.elastic_energy(start.q) - b.elastic_energy(stage.q) - b.kinetic_energy(stage.v)
    assert lost == pytest.approx(float(gone), rel=1e-9)
    assert lost > 0.0
