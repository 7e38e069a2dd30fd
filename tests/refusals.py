"""Check of error messages by the words that carry information."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from hazbot_gym.errors import InvalidInput


@contextmanager
def refused(
    said: str = "", error: type[Exception] = InvalidInput
) -> Iterator[pytest.ExceptionInfo[Exception]]:
    """Expect an error of one line that says the given words.

    Args:
        said: the field, the given value, what is allowed: whatever the message must name, in this
            order; ``...`` stands for any text between them.
        error: its type.
    """
    with pytest.raises(error) as caught:
        yield caught
    says(str(caught.value), said)


def says(message: str, said: str) -> None:
    """Check that a message is one line which says the given words in their order."""
    assert "\n" not in message.strip()
    words = ".*".join(re.escape(word.strip()) for word in said.split("..."))
    assert re.search(words, message), f"{message!r} does not say {said!r}"
