"""Tests of pictures, films, pages and exports."""
