"""Benchmarks: steps per second beside CartPole-v1, and training speed."""
