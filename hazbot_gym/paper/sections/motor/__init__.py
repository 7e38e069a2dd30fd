"""Section of the paper: motor."""
