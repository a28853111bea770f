"""Meshes from files: the operators are those of the same mesh made here; what does not fit is one line."""

from __future__ import annotations

import re

import meshio
import numpy as np
import pytest

from oblique_impact import History, InputError, Scenario, simulate
from oblique_impact.fem_beam import NodalBeam, beam_mesh
from oblique_impact.scenario.mesh_file import read_nodes

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


#: a graded mesh; the finest element is at the root
PLACES = [0.0, 0.1, 0.3, 0.6, 1.0]
ABAQUS = "*Heading\n*Node\n" + "".join(f"{n}, 0., {-y}\n" for n, y in enumerate(PLACES, start=1))


@pytest.mark.parametrize("kind", ["B33H", "b31", "B31OS", "PIPE21", "t2d2", "B22"])
def test_beams_of_abaqus_by_hand(tmp_path, caplog, kind):
    """Two nodes, also of cubic elements, or three; drawn from the origin downwards, the root is at the origin."""
    quadratic = "1, 1, 2, 3\n2, 3, 4, 5\n"
    lines = quadratic if kind == "B22" else "".join(f"{n}, {n}, {n + 1}\n" for n in range(1, 5))
    path = tmp_path / "beam.inp"
    path.write_text(f"{ABAQUS}*Element, type={kind}, elset=beam\n{lines}*Elset, elset=all\n 1, 2\n*Step\n")
    with caplog.at_level("INFO"):
        assert read_nodes(path) == PLACES
    assert "along y; the root is its end at y = 0 m, the free end at y = -1 m" in caplog.text.replace(
        ", mid nodes taken as nodes,", ""
    )
    assert ("mid nodes" in caplog.text) == (kind == "B22")


@pytest.mark.parametrize("shift", [0.0, 3.0])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_the_root_is_the_end_at_the_origin_or_else_the_lower_one(tmp_path, caplog, sign, shift):
    path = write(tmp_path / "beam.vtk", [shift + sign * x for x in PLACES])
    turned = shift != 0.0 and sign < 0.0
    expected = [1.0 - x for x in PLACES[::-1]] if turned else PLACES
    np.testing.assert_allclose(read_nodes(path), expected, rtol=0.0, atol=1e-15)
    # where no end is at the origin this is not left unsaid
    assert [record.levelname for record in caplog.records] == ["WARNING"] * (shift != 0.0)


@pytest.mark.parametrize("name", ["beam.vtk", "beam.msh"])
def test_mid_nodes_are_nodes(tmp_path, name):
    """gmsh and VTK list them behind the ends."""
    points = np.stack([PLACES, np.zeros(5), np.zeros(5)], axis=1)
    mesh = meshio.Mesh(points, {"line3": [[0, 2, 1], [4, 2, 3]]})
    mesh.write(tmp_path / name, file_format={"beam.msh": "gmsh"}.get(name))
    assert read_nodes(tmp_path / name) == PLACES


def test_nodes_of_neighbours_within_rounding_are_one(tmp_path):
    """0.1 + 0.2 is 0.30000000000000004."""
    write(tmp_path / "beam.vtk", [0.0, 0.1 + 0.2, 0.3, 1.0], [[0, 1], [2, 3]])
    assert read_nodes(tmp_path / "beam.vtk") == [0.0, 0.3, 1.0]


def test_a_command_says_how_a_mesh_was_read(tmp_path, monkeypatch, cli):
    monkeypatch.chdir(tmp_path)
    write(tmp_path / "beam.vtk", [-x for x in PLACES])
    changes = ["discretization.method=fem", "discretization.modes=2", "discretization.mesh=beam.vtk"]
    options = [word for change in changes for word in ("--set", change)]
    code, _, notes = cli("modes", "paper", *options)
    assert code == 0
    assert "4 elements along x; the root is its end at x = 0 m, the free end at x = -1 m" in notes


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


def test_numbers_of_nodes_without_a_type_are_floating_point_ones(tmp_path):
    """As XDMF says of a DataItem without NumberType; a polyline of five nodes is four elements."""
    items = [(f'Polyline" NodesPerElement="{n}', cells) for n, cells in ((5, "0 1 2 3 4"), (2, "0 1 1 2 2 3 3 4"))]
    for topology, cells in items:
        rows = 1 if topology.endswith("5") else 4
        (tmp_path / "beam.xdmf").write_text(
            f"""<Xdmf Version="2.0"><Domain><Grid Name="beam" GridType="Uniform">
            <Topology TopologyType="{topology}" NumberOfElements="{rows}">
            <DataItem Dimensions="{rows} {len(cells.split()) // rows}" Format="XML">{cells}</DataItem></Topology>
            <Geometry GeometryType="XYZ"><DataItem Dimensions="5 3" Format="XML" Precision="8">
            {" ".join(f"{x} 0 0" for x in PLACES)}</DataItem></Geometry></Grid></Domain></Xdmf>"""
        )
        assert read_nodes(tmp_path / "beam.xdmf") == PLACES


#: two lines of two nodes, and what follows them, in VTK's own format
VTK = """# vtk DataFile Version 5.1
beam
ASCII
DATASET UNSTRUCTURED_GRID
POINTS 5 double
0 0 0 0.25 0 0 0.5 0 0 0.7 0 0 1 0 0
CELLS 4 {size}
OFFSETS vtktypeint64
0 2 4 {size}
CONNECTIVITY vtktypeint64
0 1 1 2 {rest}
CELL_TYPES 3
3 3 {kind}
"""
BAD = {
    "polyline": (VTK.format(size=7, rest="2 3 4", kind=4), "has polylines, which meshio leaves out"),
    "unknown node": (VTK.format(size=6, rest="2 9", kind=3), "should be of the 5 nodes that it has"),
    "missing": (None, "no such file"),
    "text": ("nonsense", "cannot be read"),
    "no lines": (
        lambda path: meshio.Mesh(np.eye(3), {"triangle": [[0, 1, 2]]}).write(path),
        "has no line elements",
    ),
    "a kind unknown": (
        f"{ABAQUS}*Element, type=S99\n1, 1, 2\n",
        "Element type not available: S99; of Abaqus beams",
    ),
    "orientation": (f"{ABAQUS}*Element, type=B31\n1, 1, 2, 5\n2, 2, 3, 5\n", "without nodes of orientation"),
    "no length": (lambda path: write(path, [0.0, 0.5, 0.5 + 1e-16, 1.0]), "without gaps and overlaps"),
    "another format": (
        lambda path: path.write_text("# vtk DataFile Version 5.1\nno\nASCII\n"),
        "cannot be read: ",
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
def test_what_does_not_fit_is_one_line(tmp_path, monkeypatch, capfd, case):
    monkeypatch.chdir(tmp_path)
    make, words = BAD[case]
    name = "beam.inp" if str(make).startswith("*") else "beam.vtk"
    if callable(make):
        make(tmp_path / name)
    elif make:
        (tmp_path / name).write_text(make)
    with pytest.raises(InputError, match=words) as refused:
        Scenario.load("paper", [*FEM, f"discretization.mesh={name}"])
    assert str(refused.value).startswith("discretization.")
    assert "\n" not in str(refused.value)
    assert not re.search("cannot be read: ([0-9]|;|$)", str(refused.value))  # a reason in words
    assert capfd.readouterr() == ("", "")
