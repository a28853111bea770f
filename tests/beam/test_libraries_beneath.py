"""What scikit-fem and SciPy make of meshes and masses that are not their usual ones: not so here.

Each case is measured with scikit-fem 12.0.2 and SciPy 1.17.1; `findings/` has scripts of what was not expected.
"""

from __future__ import annotations

import meshio
import numpy as np
import pytest
from scipy.linalg import cholesky
from skfem import Basis, BilinearForm, MeshLine
from skfem.helpers import dd, ddot

from oblique_impact import InputError, Scenario
from oblique_impact.fem_beam import NodalBeam
from oblique_impact.fem_beam.element import LocalHermite
from oblique_impact.fem_beam.reduction import eigenmodes
from oblique_impact.validation.runs import UNIT

FEM = ["discretization.method=fem", "discretization.frame=tangent"]
PLACES = np.linspace(0.0, 1.0, 9)  # exact in binary, 1024 lengths away too


@BilinearForm
def bending(u, v, _):
    return ddot(dd(u), dd(v))


def stiffness(mesh, element):
    return bending.assemble(Basis(mesh, element, intorder=7)).toarray()


@pytest.mark.parametrize("other", [2.0 * PLACES, np.linspace(0.0, 1.0, 5), np.linspace(0.0, 1.0, 21)])
def test_an_element_object_keeps_nothing_of_its_first_mesh(other):
    """scikit-fem's Hermite element keeps that of the first: 112 times the stiffness, or IndexError."""
    element = LocalHermite()
    stiffness(MeshLine(PLACES), element)
    h = other[1]
    found = stiffness(MeshLine(other), element)
    np.testing.assert_allclose(
        found[:2, :2], np.array([[12.0, 6.0 * h], [6.0 * h, 4.0 * h**2]]) / h**3, rtol=1e-13
    )


def test_a_beam_far_from_the_origin_keeps_all_digits(tmp_path):
    """From a file 1,024 lengths away, where scikit-fem's element loses 3e-4 of the stiffness."""
    found, here = [], stiffness(MeshLine(PLACES), LocalHermite())
    for shift in (0.0, 1024.0):
        points = np.stack([PLACES + shift, 0.0 * PLACES, 0.0 * PLACES], axis=1)
        meshio.Mesh(points, {"line": [[k, k + 1] for k in range(8)]}).write(tmp_path / "beam.vtk")
        (tmp_path / "case.toml").write_text('[discretization]\nmesh = "beam.vtk"\n')
        found.append(NodalBeam.from_scenario(Scenario.load(str(tmp_path / "case.toml"), FEM)).K.toarray())
        np.testing.assert_array_equal(stiffness(MeshLine(PLACES + shift), LocalHermite()), here)
    np.testing.assert_array_equal(*found)


@pytest.mark.parametrize("elements", [4, 8, 16, 64])
def test_sections_stay_on_their_elements_however_fine_the_mesh(elements):
    """Of a beam whose root half is twice as stiff and heavy; scikit-fem's subdomains move as lines are refined.

    The jump is a ramp of 1e-9 of the length.  By hand: deflection under an end load, inertia about the root.
    """
    jump = [[0.0, 2.0], [0.5 - 5e-10, 2.0], [0.5 + 5e-10, 1.0], [1.0, 1.0]]
    beam = {**UNIT, "area": jump, "second_moment": jump}
    mesh = {"method": "fem", "modes": 2, "elements": elements}
    case = {"beam": beam, "contact": {"enabled": False}, "discretization": mesh}
    nodal = NodalBeam.from_scenario(Scenario.from_dict(case))
    force = np.eye(1, nodal.basis.N, nodal.basis.N - 2)[0]
    free = nodal.free_dofs("clamped")
    deflection = np.linalg.solve(nodal.K.toarray()[np.ix_(free, free)], force[free])[-2]
    assert deflection == pytest.approx((1.0 / 8.0 + 7.0 / 16.0) / 3.0, rel=1e-8)
    rigid = nodal.rigid_rotation
    assert rigid @ nodal.M1 @ rigid == pytest.approx(2.0 / 24.0 + 7.0 / 24.0, rel=1e-8)


HEAVY = ["masses=[{place=0.4,mass=2,inertia=0.1},{mass=1,inertia=0.5}]", "root.kind=hub", "root.inertia=0.1"]


@pytest.mark.parametrize("changes", [[], HEAVY], ids=["uniform", "masses"])
def test_lanczos_has_a_mass_that_is_definite(changes):
    """Of an indefinite one `eigsh` returns what is no eigenvalue; ours are those of dense matrices."""
    many = ["discretization.elements=128", "discretization.modes=6", *changes]
    nodal = NodalBeam.from_scenario(Scenario.builtin("paper", [*FEM, *many]))
    cholesky(nodal.whole_mass.toarray())
    few, whole = (eigenmodes(nodal, "clamped", count)[:, :6] for count in (6, None))
    squares = [np.sum((nodal.curvature_factor() @ modes) ** 2, axis=0) for modes in (few, whole)]
    np.testing.assert_allclose(*squares, rtol=4e-10)


@pytest.mark.parametrize(
    "change",
    ["beam.density=-1", "masses=[{place=0.4,mass=-2}]", "masses=[{mass=1,inertia=-0.5}]", "beam.tip_mass=-1"],
)
def test_a_mass_that_is_not_positive_is_refused(change):
    with pytest.raises(InputError, match="greater than"):
        Scenario.builtin("paper", [*FEM, change])
