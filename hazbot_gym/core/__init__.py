"""The mathematics: pure functions of numbers and records, each beside its equation and source."""
