"""Errors raised for bad input, and the named outcomes of a run."""

from __future__ import annotations

from enum import Enum
from typing import Any


class InputError(ValueError):
    """Bad input: the message is one line that names the key, the value and what is allowed."""

    def __init__(self, message: str) -> None:
        # the input may hold line breaks and control characters
        super().__init__("".join(c if c.isprintable() else ascii(c)[1:-1] for c in message))


class SimulationWarning(UserWarning):
    """What stands against numbers of a run; `simulate` gives one for each entry of ``summary["warnings"]``."""


class FileWarning(UserWarning):
    """A history was read whose file cannot be checked for damage, or does not belong to the files beside it."""


class Interrupted(KeyboardInterrupt):
    """Ctrl-C during a run; `history` holds what was computed until then."""

    def __init__(self, history: Any) -> None:
        super().__init__("interrupted")
        self.history = history


class Outcome(Enum):
    """Named outcome of a run, with a sentence for the user."""

    COMPLETED = ("completed", "The run reached its end time.")
    MASS_MATRIX_INDEFINITE = (
        "mass-matrix-indefinite",
        "The first-order mass matrix lost positive definiteness (too many clamped shapes in the tangent "
        'frame); use discretization.frame = "mean-axis", or discretization.kinetics = "full", or fewer modes.',
    )
    PAINLEVE = (
        "painleve",
        "Painleve configuration: the effective inverse normal mass of the sliding contact is not positive, "
        "and no contact force solves the problem; lower contact.mu_kinetic or change the geometry.",
    )
    CHATTERING = (
        "chattering",
        "The contact state changed too often at one instant; the contact problem has no persistent state there.",
    )
    REDUNDANT_CONSTRAINTS = (
        "redundant-constraints",
        "The constraints of the contact along and across the slope, or of several contacts, are not independent: "
        'their forces are not determined; use more modes, fewer contacts, or contact.friction = "frictionless".',
    )
    IMPACT_OF_SEVERAL = (
        "impact-of-several",
        "An impact while another contact is closed, or of several at once: the law of impacts is one of a contact "
        'that is alone; use contact.impact = "newton", or fewer obstacles.',
    )
    STEP_UNDERFLOW = (
        "step-underflow",
        "The step fell below the resolution of time: the motion is singular, or too stiff for this scheme; "
        'solver.scheme = "time-stepping" takes steps of a given length, "generalized-alpha" on elastic stops.',
    )
    NOT_CONVERGED = (
        "iterations-diverged",
        "The iterations of an implicit step did not converge; use a shorter solver.free_step or "
        "solver.contact_step, or a larger solver.tolerance.",
    )
    TOO_MANY_EVENTS = (
        "too-many-events",
        "The run exceeded its bound on the number of events; use a shorter end_time, a smaller "
        "contact.restitution, or, in time-stepping, longer steps.",
    )
    TOO_MANY_STEPS = (
        "too-many-steps",
        "The run would need more steps than can be computed; use longer steps, or a shorter end_time.",
    )
    LARGE_DEFLECTION = (
        "large-deflection",
        "The deflection exceeded half of the beam's length, where small-deflection theory does not hold; use "
        'discretization.method = "absolute", which is exact there, or a stiffer beam.',
    )
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


class RunEnded(Exception):  # noqa: N818  it is an outcome, not an error
    """Raised inside the loop where the physics ends a run; carries the named outcome and a message.

    The message is the outcome's own sentence if none with the numbers of the run is given.
    """

    def __init__(self, outcome: Outcome, message: str = "") -> None:
        super().__init__(message or outcome.sentence)
        self.outcome, self.message = outcome, message or outcome.sentence
