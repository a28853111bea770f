"""Refinement studies: quantities of interest over elements, modes or steps, and what they converge to."""
