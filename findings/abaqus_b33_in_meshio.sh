#!/usr/bin/env bash
# meshio 5.3.5 reads Abaqus' B33, a cubic beam element with two nodes, as a line with three.
#
# Guess before: B33 is either unknown to meshio (an error) or read as a line with two nodes; the digits of an Abaqus
# beam are its space and its interpolation (B31 linear, B32 quadratic, B33 cubic), and B33 has two nodes in the Abaqus
# Elements Guide, "Beam element library".
#
# Seen: B33 is taken for "line3".  Rows of a number and two nodes are cut into rows of a number and three: where the
# count fits, as for four elements, they are read without an error or a word as three elements that do not exist,
# some of their nodes numbers of elements.  B31, written the same way, is read as it stands.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check meshio==5.3.5 numpy==2.4.6
cd "$folder"
for element in B31 B33; do
    cat > "$element.inp" <<INP
*NODE
1, 0.0, 0.0, 0.0
2, 1.0, 0.0, 0.0
3, 2.0, 0.0, 0.0
4, 3.0, 0.0, 0.0
5, 4.0, 0.0, 0.0
*ELEMENT, TYPE=$element
1, 1, 2
2, 2, 3
3, 3, 4
4, 4, 5
INP
done
"$folder/venv/bin/python" - <<'PY'
import meshio

found = {}
for name in ("B31", "B33"):
    mesh = meshio.read(f"{name}.inp")
    found[name] = {block.type: block.data.tolist() for block in mesh.cells}
    print(f"meshio {meshio.__version__}, four elements {name} in a row: {found[name]}")
assert found["B31"] == {"line": [[0, 1], [1, 2], [2, 3], [3, 4]]}, "B31 is no longer read as it stands"
assert list(found["B33"]) == ["line3"], "B33 is no longer a line with three nodes"
assert len(found["B33"]["line3"]) == 3, "four elements are no longer three"
PY
