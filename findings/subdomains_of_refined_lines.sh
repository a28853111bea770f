#!/usr/bin/env bash
# scikit-fem's subdomains of lines lie on other elements once the mesh is refined; those of triangles do not.
#
# Guess before: names of subdomains go with their elements through `refined`, as those of boundaries do; where they
# cannot, they are dropped with the words that scikit-fem has for it ("Named subdomains invalidated").
#
# Seen (scikit-fem 12.0.2): a subdomain is as large as before, no word is said, and half of its elements lie elsewhere:
# children of a line are numbered in turns, the names are passed on as if they came in blocks.  Refined in one element
# it keeps the old numbers, under which the elements are others now.  Tetrahedra that are refined in one element lose
# those of the subdomain that are new.  Triangles are right either way, and so are boundaries.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check scikit-fem==12.0.2 numpy==2.4.6 scipy==1.17.1
cd "$folder"
"$folder/venv/bin/python" - <<'PY'
from importlib.metadata import version

import numpy as np
from skfem import MeshLine, MeshTet, MeshTri

print(f"scikit-fem {version('scikit-fem')}")
ONE = np.array([0])


def off(mesh):
    """Numbers of elements of the subdomain at x < 0.5 that are not there, and of those that are missing."""
    there = set(np.flatnonzero(mesh.p[0, mesh.t].mean(axis=0) < 0.5).tolist())
    named = set(mesh.subdomains["left"].tolist())
    return len(named - there), len(there - named)


for name, mesh, expected in (
    ("lines", MeshLine(np.linspace(0.0, 1.0, 5)), [(0, 0), (2, 2), (1, 2)]),
    ("triangles", MeshTri().refined(), [(0, 0), (0, 0), (0, 0)]),
    ("tetrahedra", MeshTet().refined(), [(0, 0), (0, 0), (0, 7)]),
):
    mesh = mesh.with_subdomains({"left": lambda x: x[0] < 0.5})
    found = [off(each) for each in (mesh, mesh.refined(), mesh.refined(ONE))]
    print(f"{name}: elements elsewhere, missing: before {found[0]}, refined {found[1]}, one element refined {found[2]}")
    assert found == expected, f"was {expected}"

line = MeshLine(np.linspace(0.0, 1.0, 5)).with_subdomains({"left": lambda x: x[0] < 0.5}).refined()
places = np.sort(line.p[0, line.t[:, line.subdomains["left"]]].mean(axis=0)).tolist()
print(f"four lines from 0 to 1, refined: middles of the elements of the left half {places}")
assert places == [0.0625, 0.1875, 0.5625, 0.6875]
ends = line.with_boundaries({"end": lambda x: x[0] == 1.0}).refined()
assert ends.p[0, ends.facets[0, ends.boundaries["end"]]].tolist() == [1.0]
PY
