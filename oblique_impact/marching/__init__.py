"""Marching schemes, one file each, one contract (:mod:`~oblique_impact.marching.scheme`).

`EventScheme`      adaptive order 8, transitions located as roots
`FixedStepScheme`  RK4 with the paper's steps, transitions judged once per step
`GeneralizedAlphaScheme`  implicit, second order, transitions located by shortening the step
`ExplicitScheme`   the contract for explicit integrators of one's own: `step`, and nothing else
"""

from oblique_impact.marching.event import EventScheme
from oblique_impact.marching.explicit import ExplicitScheme
from oblique_impact.marching.fixed_step import FixedStepScheme
from oblique_impact.marching.generalized_alpha import GeneralizedAlphaScheme
from oblique_impact.marching.scheme import Scheme

__all__ = ["EventScheme", "ExplicitScheme", "FixedStepScheme", "GeneralizedAlphaScheme", "Scheme"]
