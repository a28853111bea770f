"""What mechanical systems see of the candidates of contact, which are built on this package."""

from __future__ import annotations

from typing import Any, Protocol

from oblique_impact.kernels.workspace import Array


class CandidateFields(Protocol):
    """A candidate in a state of the system, see :class:`oblique_impact.contact.state.Candidate`."""

    gap: float  # m
    slip: float
    gap_rate: float  # m/s
    slip_rate: float
    gap_bias: float  # m/s^2, accelerations without q''
    slip_bias: float
    shift: float  # what the compliance behind it depends on: angle (rad) of the frame, or place (m) along the beam
    shift_rate: float
    shift_bias: float  # acceleration without q''


class ContactArrays(Protocol):
    """All n candidates of a run, see :class:`oblique_impact.contact.state.Contacts`."""

    @property
    def each(self) -> Any:
        """Records of the candidates (n,), each with its `state`, 0 in flight."""

    @property
    def rows(self) -> Array:
        """Rows of the closed contacts and the responses to them, (2, n, 2, d)."""
