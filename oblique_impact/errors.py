"""Errors raised for bad input, and the named ways in which a run can end."""

from __future__ import annotations

from enum import Enum
from typing import Any


class InputError(ValueError):
    """Bad input: the message is one line that names the key, the value and what is allowed."""

    def __init__(self, message: str) -> None:
        # the input may hold line breaks and control characters
        super().__init__("".join(c if c.isprintable() else ascii(c)[1:-1] for c in message))


class Interrupted(KeyboardInterrupt):
    """Ctrl-C during a run; `history` holds what was computed until then."""

    def __init__(self, history: Any) -> None:
        super().__init__("interrupted")
        self.history = history


class Outcome(Enum):
    """How a run ended; each member carries a sentence for the user."""

    COMPLETED = ("completed", "The run reached its end time.")
    MASS_MATRIX_INDEFINITE = (
        "mass-matrix-indefinite",
        "The first-order mass matrix lost positive definiteness (too many clamped shapes in the tangent "
        'frame); use discretization.frame = "mean-axis", or discretization.kinetics = "full", or fewer modes.',
    )
    PAINLEVE = (
        "painleve",
        "Painleve configuration: the effective inverse normal mass of the sliding contact is not positive, "
        "so the contact force has no or several solutions; lower contact.mu_kinetic or change the geometry.",
    )
    CHATTERING = (
        "chattering",
        "The contact state changed too often at one instant; the contact problem has no persistent state there.",
    )
    REDUNDANT_CONSTRAINTS = (
        "redundant-constraints",
        "Sticking contact leaves no freedom to determine its two forces; use more modes.",
    )
    STEP_UNDERFLOW = (
        "step-underflow",
        "The step fell below the resolution of time; the motion is too stiff for this scheme or singular.",
    )
    NOT_CONVERGED = (
        "iterations-diverged",
        "The iterations of an implicit step did not converge; use a shorter solver.free_step or contact_step.",
    )
    TOO_MANY_EVENTS = ("too-many-events", "The run exceeded its bound on the number of events.")
    DIVERGED = (
        "diverged",
        "The solution grew without bound or is no longer finite; the model or the step is not valid here.",
    )
    INTERRUPTED = ("interrupted", "The run was interrupted; what was computed is kept.")

    def __init__(self, label: str, sentence: str) -> None:
        self.label = label
        self.sentence = sentence

    @property
    def exit_code(self) -> int:
        """Exit code of the command line: 0 done, 1 stopped by the physics, 130 interrupted."""
        return {Outcome.COMPLETED: 0, Outcome.INTERRUPTED: 130}.get(self, 1)


class PhysicsStop(Exception):  # noqa: N818  it is an outcome, not an error
    """Raised inside the loop when the physics ends a run; carries the named outcome."""

    def __init__(self, outcome: Outcome) -> None:
        super().__init__(outcome.sentence)
        self.outcome = outcome
