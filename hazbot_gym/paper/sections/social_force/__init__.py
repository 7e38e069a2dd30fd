"""Section of the paper: social force."""
