"""Section of the paper: control system."""
