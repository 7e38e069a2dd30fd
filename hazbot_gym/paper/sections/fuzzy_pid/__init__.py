"""Section of the paper: fuzzy pid."""
