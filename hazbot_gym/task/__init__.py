"""What the problem is: places, people, observation, reward, outcome."""
