"""Marching schemes, one file each, one contract (:mod:`~oblique_impact.integrators.base`).

`EventScheme`      adaptive order 8, transitions located as roots
`FixedStepScheme`  RK4 with the paper's steps, transitions judged once per step
`GeneralizedAlphaScheme`  implicit, second order, transitions located by shortening the step
`ExplicitScheme`   the contract for explicit integrators of one's own: `step`, and nothing else
"""

from oblique_impact.integrators.base import Scheme
from oblique_impact.integrators.event import EventScheme
from oblique_impact.integrators.explicit import ExplicitScheme
from oblique_impact.integrators.fixed_step import FixedStepScheme
from oblique_impact.integrators.generalized_alpha import GeneralizedAlphaScheme

__all__ = ["EventScheme", "ExplicitScheme", "FixedStepScheme", "GeneralizedAlphaScheme", "Scheme"]
