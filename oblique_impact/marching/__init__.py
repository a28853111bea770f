"""Marching through the contact states: the loop, and schemes, one file each, with one contract (`scheme`)."""
