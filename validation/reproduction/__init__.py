"""The paper's figures and claims, from our runs."""
