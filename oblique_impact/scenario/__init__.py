"""What to simulate."""
