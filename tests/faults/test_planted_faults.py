"""Wrong signs and dropped terms: `validate` fails on each and names a fitting group.

Each fault is planted into a copy of the sources, and the command runs from that copy.  The groups run here need no
compiled kernels; the slow test runs the quick validation as a whole, and compiles them.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PACKAGES = ("oblique_impact", "modal", "fem_beam", "validation", "renders")


@dataclass(frozen=True)
class Fault:
    """A line that is changed, and the checks that are run: groups or single checks."""

    file: str
    right: str
    wrong: str
    only: tuple[str, ...]
    groups: tuple[str, ...]  # that must fail


FAULTS = {
    "centrifugal stiffness C dropped": Fault(
        "oblique_impact/beam/beam.py",
        "SPIN_STIFFNESS: o.M1 - kept * o.C",
        "SPIN_STIFFNESS: o.M1",
        (
            "equations",
            "spinning",
        ),
        (
            "equations",
            "spinning",
        ),
    ),
    "gravity stiffness D dropped": Fault(
        "oblique_impact/beam/beam.py",
        "GRAVITY_STIFFNESS: kept * o.D",
        "GRAVITY_STIFFNESS: 0.0 * o.D",
        ("equations",),
        ("equations",),
    ),
    "sign of D in the operators of the nodal model": Fault(
        "oblique_impact/beam/beam.py",
        "(frame.GRAVITY_BAND, o.D)",
        "(frame.GRAVITY_BAND, -1.0 * o.D)",
        ("equations",),
        ("equations",),
    ),
    "friction pushes forward": Fault(
        "oblique_impact/contact/friction.py",
        "return Branch(-self.kinetic, 0.0, 0.0, inf)",
        "return Branch(self.kinetic, 0.0, 0.0, inf)",
        ("small-systems",),
        ("small-systems",),
    ),
    "impulse halved": Fault(
        "oblique_impact/contact/impacts.py",
        "-(1.0 + restitution) * instant.gap_rate / instant.a_nn",
        "-0.5 * (1.0 + restitution) * instant.gap_rate / instant.a_nn",
        ("small-systems",),
        ("small-systems",),
    ),
    "foreshortening of the contact point halved (H_F)": Fault(
        "oblique_impact/beam/beam.py",
        "CONTACT_SHORTENING: shortening * o.contact_shortening",
        "CONTACT_SHORTENING: 0.5 * shortening * o.contact_shortening",
        ("equations",),
        ("equations",),
    ),
    "Baumgarte's stiffness with the wrong sign": Fault(
        "oblique_impact/contact/forces.py",
        "normal = -(c.gap_acceleration + phase.damping * c.gap_rate + phase.stiffness * c.gap) / effective",
        "normal = -(c.gap_acceleration + phase.damping * c.gap_rate - phase.stiffness * c.gap) / effective",
        ("small-systems",),
        ("small-systems",),
    ),
    "Coriolis term forgotten": Fault(
        "oblique_impact/beam/floating_frame.py",
        "v[row.FORCES, 0] = -2.0 * spin * _contract(v[row.SCRATCH_A], Bd)",
        "v[row.FORCES, 0] = 0.0",
        ("equations",),
        ("equations",),
    ),
    "centripetal acceleration of the gap dropped": Fault(
        "oblique_impact/beam/floating_frame.py",
        "2.0 * spin * (c * x_rate - s * y_rate) - square * (s * x + c * y) - s * bending",
        "2.0 * spin * (c * x_rate - s * y_rate) - s * bending",
        ("equations",),
        ("equations",),
    ),
    "rank-one gauge term skipped": Fault(
        "oblique_impact/beam/nodal_frame.py",
        "+ moment * u[COUPLING, i] - v[row.FORCES, i]",
        "- v[row.FORCES, i]",
        ("equations",),
        ("equations",),
    ),
    "weak form of the bending stiffness off by a thousandth": Fault(
        "fem_beam/nodal.py",
        "csr_array(self._assemble(_bending, self.sections.bending_stiffness))",
        "1.001 * csr_array(self._assemble(_bending, self.sections.bending_stiffness))",
        ("frequencies",),
        ("frequencies",),
    ),
    "Hunt-Crossley damping with the wrong sign": Fault(
        "oblique_impact/contact/stops.py",
        "return stiffness * depth * (1.0 + damping * rate)",
        "return stiffness * depth * (1.0 - damping * rate)",
        ("small-systems",),
        ("small-systems",),
    ),
}


def plant(fault: Fault, folder: Path) -> None:
    """Copy the sources into `folder` and change the line there."""
    for package in PACKAGES:
        shutil.copytree(ROOT / package, folder / package, ignore=shutil.ignore_patterns("__pycache__"))
    file = folder / fault.file
    text = file.read_text(encoding="utf-8")
    assert text.count(fault.right) == 1
    file.write_text(text.replace(fault.right, fault.wrong), encoding="utf-8")


def run_validate(folder: Path, *options: str) -> tuple[int, set[str]]:
    """Exit code and failing groups of `validate` run from the sources in `folder`."""
    out = folder / "out"
    command = [sys.executable, "-m", "oblique_impact", "validate", "--out", str(out), *options]
    environment = {**os.environ, "PYTHONPATH": str(folder), "NUMBA_CACHE_DIR": str(folder / "kernels")}
    done = subprocess.run(
        command, cwd=folder, env=environment, capture_output=True, text=True, timeout=500, check=False
    )
    assert "Traceback" not in done.stderr, done.stderr
    checks = json.loads((out / "results.json").read_text(encoding="utf-8"))["checks"]
    return done.returncode, {check["group"] for check in checks if check["verdict"] == "fail"}


#: each fault compiles the kernels anew: two are tried at once, the others are for `make test-slow`
QUICK = ("friction pushes forward", "rank-one gauge term skipped")
EACH = [pytest.param(name, marks=[] if name in QUICK else [pytest.mark.slow]) for name in FAULTS]


@pytest.mark.parametrize("name", EACH)
def test_a_planted_fault_fails_a_fitting_group(name, tmp_path):
    fault = FAULTS[name]
    plant(fault, tmp_path)
    chosen = [part for check in fault.only for part in ("--only", check)]
    code, failed = run_validate(tmp_path, *chosen, "--workers", "1")
    assert code == 1
    assert set(fault.groups) <= failed


@pytest.mark.slow
@pytest.mark.parametrize("name", FAULTS)
def test_a_planted_fault_fails_the_quick_validation(name, tmp_path):
    plant(FAULTS[name], tmp_path)
    code, failed = run_validate(tmp_path, "--quick", "--workers", "1")
    assert code == 1
    assert failed
