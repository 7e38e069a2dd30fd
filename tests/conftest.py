"""Settings for all tests."""

from __future__ import annotations

from hypothesis import settings

# The same examples every time, and however slow the machine: a red test is a red test.
settings.register_profile("steady", derandomize=True, deadline=None)
settings.load_profile("steady")
