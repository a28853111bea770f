"""Contact: states, laws, forces, transitions."""
