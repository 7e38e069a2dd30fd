"""Section of the paper: circle."""
