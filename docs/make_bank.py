"""Draw the scenario bank anew and write it down: ``python docs/make_bank.py``."""

from hazbot_gym.study import scenario_bank

if __name__ == "__main__":
    scenario_bank.write()
