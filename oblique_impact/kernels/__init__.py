"""Compiled numeric source: the protocol of systems, dense and banded algebra, numba."""
