"""Ranges of validity: what stands against the numbers of a run, told in lines that begin with a key."""
