"""The cache of compiled kernels is optional: whatever is wrong with it costs compiling, never the run."""

from __future__ import annotations

import json
import os
import subprocess
import sys

import pytest

#: a kernel; numba keeps nothing of what has no module
KERNEL = """
from collections import namedtuple
from oblique_impact.kernels.jit import kernel

class Packed(namedtuple("Packed", "number")):
    __slots__ = ()

def cube(system):
    return system.number**3

compiled = kernel("the cube")(cube)
"""
#: fill a cache, spoil copies of it in several ways, and use each in a process of its own
PROGRAM = """
import json, os, resource, shutil, sys
from pathlib import Path
from oblique_impact.contact.stops import ElasticStop
from oblique_impact.kernels.compiling import compilations
from cubes import Packed, compiled

def use(folder, most=None):
    "What a process finds that uses this cache: results, how many kernels it compiled, what it said."
    reader, writer = os.pipe()
    child = os.fork()
    if not child:
        said, told = os.open(f"{folder}.said", os.O_RDWR | os.O_CREAT | os.O_TRUNC), []
        os.dup2(said, 2)
        os.environ["NUMBA_CACHE_DIR"] = str(folder)
        if most is not None:
            resource.setrlimit(resource.RLIMIT_FSIZE, (most, most))
        with compilations(told.append):
            numbers = [compiled(Packed(3.0)), float(ElasticStop(2.0).energy(-3.0))]
        os.write(writer, json.dumps([numbers, len(told), Path(f"{folder}.said").read_text()]).encode())
        os._exit(0)
    os.close(writer)
    with os.fdopen(reader) as pipe:
        text = pipe.read()
    status = os.waitpid(child, 0)[1]
    return json.loads(text) if text else f"ended with {status}: " + Path(f"{folder}.said").read_text()

def zeros(content):
    middle = len(content) // 2
    return content[:middle] + bytes(200) + content[middle + 200 :]

top = Path(sys.argv[1])
found = {"first": use(top / "whole"), "second": use(top / "whole")}
spoiled = {
    "empty index": (".nbi", lambda content: b""),
    "half of the code": (".nbc", lambda content: content[: len(content) // 2]),
    "other bytes": (".nbc", zeros),
}
for name, (ending, spoil) in spoiled.items():
    folder = top / name
    shutil.copytree(top / "whole", folder)
    for file in folder.rglob(f"*{ending}"):
        file.write_bytes(spoil(file.read_bytes()))
    found[name] = use(folder)
    found[f"{name}, again"] = use(folder)
found["full"] = use(top / "full", 2000)
found["almost full"] = use(top / "whole", 0)
(top / "file").write_text("in the way")
found["no folder"] = use(top / "file")
print(json.dumps(found))
"""


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    folder = tmp_path_factory.mktemp("caches")
    (folder / "cubes.py").write_text(KERNEL)
    (folder / "program.py").write_text(PROGRAM)
    words = [sys.executable, str(folder / "program.py"), str(folder)]
    environment = {name: value for name, value in os.environ.items() if name != "NUMBA_DISABLE_JIT"}
    done = subprocess.run(words, capture_output=True, text=True, timeout=300, env=environment)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def test_a_whole_cache_is_used(found):
    assert found["first"] == [[27.0, 9.0], 1, ""]
    assert found["second"] == found["almost full"] == [[27.0, 9.0], 0, ""]


@pytest.mark.parametrize("damage", ["empty index", "half of the code", "other bytes"])
def test_a_damaged_cache_is_filled_anew(found, damage):
    numbers, compiled, said = found[damage]
    assert (numbers, compiled) == ([27.0, 9.0], 1)
    assert said.count("\n") <= 1
    assert found[f"{damage}, again"] == [[27.0, 9.0], 0, ""]


@pytest.mark.parametrize("case", ["full", "no folder"])
def test_what_cannot_be_kept_is_said_in_one_line(found, case):
    numbers, compiled, said = found[case]
    assert (numbers, compiled, said.count("\n")) == ([27.0, 9.0], 1, 1)
    assert "NUMBA_CACHE_DIR" in said
