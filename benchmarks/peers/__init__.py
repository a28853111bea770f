"""Other programs on problems of this one."""
