"""Histories: samples, events and summary of a run."""
