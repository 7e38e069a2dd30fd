"""``python -m hazbot_gym`` is the same as ``hazbot``."""

from hazbot_gym.cli import main

main()
