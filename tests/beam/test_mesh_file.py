"""Meshes from files: the operators are those of the same mesh made here; what does not fit is one line."""

from __future__ import annotations

import meshio
import numpy as np
import pytest

from oblique_impact import History, InputError, Scenario, simulate
from oblique_impact.fem_beam import NodalBeam, beam_mesh

FEM = ["discretization.method=fem", "contact.point=0.7", "discretization.modes=2"]
NODES = beam_mesh(1.0, 9, 0.7, grading=3.0).p[0]


def chain(count):
    return np.stack([np.arange(count - 1), np.arange(1, count)], axis=1)


def write(path, places, cells=None, aside=0.0, axis=0):
    """A mesh of line elements at places on an axis; the last point lies aside of it."""
    points = np.full((len(places), 3), 0.25)
    points[:, axis] = places
    points[-1, 1] += aside
    meshio.Mesh(points, {"line": chain(len(places)) if cells is None else cells}).write(
        path, file_format={".msh": "gmsh"}.get(path.suffix)
    )
    return path


@pytest.mark.parametrize("name", ["beam.vtk", "beam.msh", "beam.inp"])
def test_operators_are_those_of_the_same_mesh(tmp_path, name, capfd):
    """Shuffled, turned round, on another axis, and not beginning at 0."""
    order = np.random.default_rng(3).permutation(len(NODES))
    cells = np.argsort(order)[chain(len(NODES))][::-1, ::-1]
    write(tmp_path / name, NODES[order] + 2.0, cells, axis=2)
    (tmp_path / "case.toml").write_text(f'[discretization]\nmesh = "{name}"\n')
    found = NodalBeam.from_scenario(Scenario.load(str(tmp_path / "case.toml"), FEM))
    made = NodalBeam.from_scenario(
        Scenario.builtin("paper", [*FEM, "discretization.elements=9", "discretization.grading=3"])
    )
    np.testing.assert_allclose(found.nodes, made.nodes, rtol=0.0, atol=1e-12)
    for matrix in ("M1", "K", "C", "contact_shortening"):
        expected = getattr(made, matrix).toarray()
        np.testing.assert_allclose(
            getattr(found, matrix).toarray(), expected, rtol=1e-8, atol=1e-9 * abs(expected).max()
        )
    assert capfd.readouterr() == ("", "")


def test_a_resolved_scenario_needs_the_file_no_more(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write(tmp_path / "beam.vtk", NODES)
    changes = [*FEM, "discretization.mesh=beam.vtk", "contact.point=0.7", "end_time=0.01"]
    history = simulate(Scenario.load("paper", changes))
    folder = history.save(tmp_path / "run")
    (tmp_path / "beam.vtk").unlink()
    again = simulate(Scenario.load(str(folder / "scenario.toml")))
    np.testing.assert_array_equal(again["theta"], history["theta"])
    assert Scenario.from_toml(History.load(folder).scenario_toml).discretization.elements == 9


BAD = {
    "missing": (None, "no such file"),
    "text": ("nonsense", "cannot be read"),
    "no lines": (
        lambda path: meshio.Mesh(np.eye(3), {"triangle": [[0, 1, 2]]}).write(path),
        "has no line elements",
    ),
    "bent": (lambda path: write(path, NODES, aside=0.1), "should lie on one axis"),
    "gap": (lambda path: write(path, NODES, np.delete(chain(len(NODES)), 3, axis=0)), "without gaps and overlaps"),
    "too long": (lambda path: write(path, 2.0 * NODES), "should go from 0 to beam.length = 1.0"),
    "no node at the contact": (
        lambda path: write(path, [0.0, 0.5, 1.0]),
        "none of them is at contact.point = 0.7",
    ),
}


@pytest.mark.parametrize("case", BAD)
def test_what_does_not_fit_is_one_line(tmp_path, monkeypatch, case):
    monkeypatch.chdir(tmp_path)
    make, words = BAD[case]
    if callable(make):
        make(tmp_path / "beam.vtk")
    elif make:
        (tmp_path / "beam.vtk").write_text(make)
    with pytest.raises(InputError, match=words) as refused:
        Scenario.load("paper", [*FEM, "discretization.mesh=beam.vtk"])
    assert str(refused.value).startswith("discretization.")
    assert "\n" not in str(refused.value)
