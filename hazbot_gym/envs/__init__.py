"""The environments, their names, and their pictures."""
