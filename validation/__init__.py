"""Holding results against each other and against references, from history files alone.

`comparison.compare_events`  the event logs of two histories side by side
"""
