"""Section of the paper: speed controller."""
