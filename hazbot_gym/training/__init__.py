"""Training: Stable-Baselines3 on the batched engine, validated, resumable and exported."""
