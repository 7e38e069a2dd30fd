"""Section of the paper: sensors."""
