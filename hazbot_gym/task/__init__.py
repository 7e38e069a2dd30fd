"""Task definition: places, people, observation, reward, outcome."""
