"""hazbot_gym: choose the speed of a gas-inspection robot among people in narrow places.

Importing the package registers its environments with Gymnasium; nothing heavy is loaded before an
environment is made.
"""

from hazbot_gym.envs.registration import register_environments

__version__ = "0.1.0"

register_environments()
