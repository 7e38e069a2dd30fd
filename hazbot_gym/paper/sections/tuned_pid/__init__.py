"""Section of the paper: tuned pid."""
