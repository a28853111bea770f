"""Draws the pictures of the pages: `python -m docs.pictures.draw [NAME ...]` in the folder of the sources."""
