"""Calibration of the pedestrian model on recorded people."""
