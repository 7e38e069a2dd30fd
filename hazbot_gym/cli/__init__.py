"""Command line ``hazbot``: arguments and one call per command.

User errors give one line and exit code 2. Heavy imports are inside the commands, so that
``hazbot --help`` is fast.
"""

from hazbot_gym.cli import package, policies, recordings, studies  # noqa: F401  (registers commands)
from hazbot_gym.cli.application import app, main

__all__ = ["app", "main"]
