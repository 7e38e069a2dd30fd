"""Section of the paper: combination."""
