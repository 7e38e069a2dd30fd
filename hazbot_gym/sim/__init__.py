"""Simulation: drive, people, sensors and contacts, on two engines."""
