"""Marching schemes, one file each, one contract (:mod:`~oblique_impact.integrators.base`).

`EventScheme`      adaptive order 8, transitions located as roots
`FixedStepScheme`  RK4 with the paper's steps, transitions judged once per step
"""

from oblique_impact.integrators.base import Scheme
from oblique_impact.integrators.event import EventScheme
from oblique_impact.integrators.fixed_step import FixedStepScheme

__all__ = ["EventScheme", "FixedStepScheme", "Scheme"]
