"""Section of the paper: design."""
