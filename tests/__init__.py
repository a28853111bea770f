"""Tests of the program."""

from pathlib import Path

#: studies and sweeps of the documentation
STUDIES = Path(__file__).parents[1] / "docs" / "studies"
