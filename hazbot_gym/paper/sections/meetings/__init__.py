"""Section of the paper: meetings."""
