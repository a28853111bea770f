"""The compiled forms of the marching source, specialized for the beam and cached on disk."""

from __future__ import annotations

from oblique_impact import floating_frame, nodal_frame  # noqa: F401  register the beams' compiled functions
from oblique_impact.integrators import event, fixed_step, generalized_alpha, motion, observe
from oblique_impact.jit import kernel

march_event = kernel(event.march_event, "the event scheme")
march_fixed = kernel(fixed_step.march_fixed, "the fixed steps")
march_alpha = kernel(generalized_alpha.march_alpha, "generalized-alpha")
observe_into = kernel(observe.observe_into, "the sampling")
observe_kept_into = kernel(observe.observe_kept_into, "the sampling")
derivative = kernel(motion.derivative, "the equations")
condense_at = kernel(observe.condense_at, "the contact forces")
