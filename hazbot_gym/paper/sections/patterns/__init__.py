"""Section of the paper: patterns."""
