"""Benchmarks: steps per second beside CartPole-v1, training speed, latency, exports."""
