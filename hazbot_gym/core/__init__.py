"""Core mathematics: pure functions of numbers and records, with equation and source."""
