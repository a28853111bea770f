"""The compiled forms of the marching source, specialized for the beam and cached on disk."""

from __future__ import annotations

from oblique_impact import floating_frame  # noqa: F401  registers the beam's compiled `evaluate`
from oblique_impact.integrators import event, fixed_step, observe
from oblique_impact.jit import kernel

march_event = kernel(event.march_event)
march_fixed = kernel(fixed_step.march_fixed)
observe_into = kernel(observe.observe_into)
condense_at = kernel(observe.condense_at)
