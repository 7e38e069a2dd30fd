"""``python -m hazbot_gym`` is the same as ``hazbot``."""

import sys

if not sys.flags.safe_path:  # Python puts the working folder first, where it could replace modules
    sys.path.append(sys.path.pop(0))

from hazbot_gym.cli import main

main()
