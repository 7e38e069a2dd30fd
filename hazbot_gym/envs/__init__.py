"""Gymnasium environments, their registration, and rendering."""
