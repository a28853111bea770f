"""The checks of `validate`, a module per group; `registry` says how to add one."""
