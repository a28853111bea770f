"""The compiled forms of the marching source, specialized for the beam and cached on disk."""

from __future__ import annotations

from oblique_impact.beam import floating_frame, nodal_frame  # noqa: F401  register the beams' compiled functions
from oblique_impact.kernels.jit import kernel
from oblique_impact.marching import equations, event, fixed_step, generalized_alpha, sampling

march_event = kernel(event.march_event, "the event scheme")
march_fixed = kernel(fixed_step.march_fixed, "the fixed steps")
march_alpha = kernel(generalized_alpha.march_alpha, "generalized-alpha")
observe_into = kernel(sampling.observe_into, "the sampling")
observe_kept_into = kernel(sampling.observe_kept_into, "the sampling")
derivative = kernel(equations.derivative, "the equations")
condense_at = kernel(sampling.condense_at, "the contact forces")
