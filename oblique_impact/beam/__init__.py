"""The beam: cross-sections, operators, frames, results along it."""
