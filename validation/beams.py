"""Beams with unit data, for checks and tests."""

from __future__ import annotations

from typing import Any

import numpy as np

from oblique_impact import Scenario

#: length, mass per length and bending stiffness of one
UNIT = {"length": 1.0, "area": 1.0, "density": 1.0, "youngs_modulus": 1.0, "second_moment": 1.0}
EPS = float(np.finfo(float).eps)


def unit_beam(root: dict[str, Any] | None = None, **discretization: Any) -> Scenario:
    """Return a beam of unit data without contact."""
    return Scenario.from_dict(
        {
            "beam": UNIT,
            "contact": {"enabled": False},
            "root": root or {"kind": "pin"},
            "discretization": discretization,
        }
    )
