"""Section of the paper: kinematics."""
