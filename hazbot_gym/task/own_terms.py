"""Reward terms of users in an environment: plain in the reference engine, compiled in batches."""

from __future__ import annotations

from collections.abc import Callable
from numbers import Real

import numpy as np

from hazbot_gym.config import Config
from hazbot_gym.config.section import shown
from hazbot_gym.core.hooks import Untyped, address_of, carray
from hazbot_gym.core.own_terms import REWARD_TERMS, RewardTerm
from hazbot_gym.core.state import PERSON, ROBOT, Floats, Ints, Records, as_record, records
from hazbot_gym.errors import InvalidInput
from hazbot_gym.task.step_record import STEP, Rules


class OwnTerms:
    """The terms of users in an environment, which come after those of the library.

    Attributes:
        terms: The terms, in the order of ``config.own_terms``.
        first: Index of the first of them.
    """

    def __init__(self, config: Config, first: int) -> None:
        self.terms = [REWARD_TERMS[name] for name in config.own_terms]
        self.first = first
        self._weights = config.own_terms
        self._low = np.array([term.low for term in self.terms])
        self._high = np.array([term.high for term in self.terms])

    def info(self) -> dict[str, dict[str, float]]:
        """Return range and weight of each term, by name."""
        return {
            term.name: {"low": term.low, "high": term.high, "weight": self._weights[term.name]}
            for term in self.terms
        }

    def addresses(self) -> Ints:
        """Return the addresses of the compiled terms.

        Raises:
            InvalidInput: One cannot be compiled.
        """
        return np.array([_address(term) for term in self.terms], np.int64)

    def write(
        self, robots: Records, people: Records, record: Records, rules: Records, out: Floats
    ) -> None:
        """Compute the terms as plain Python; the arguments are arrays of one record, and people.

        Raises:
            InvalidInput: A term gives no number, or one out of its range.
        """
        one = [_read_only(each) for each in (robots, people, record, rules)]
        with np.errstate(all="ignore"):
            for k, term in enumerate(self.terms, self.first):
                value = term.function(one[0][0], one[1], one[2][0], one[3][0])
                if not isinstance(value, Real | np.bool_):
                    raise InvalidInput(
                        f"reward term {term.name!r}: gave {shown(value)}, allowed is a number"
                    )
                out[k] = value
        self.check(out)

    def check(self, values: Floats) -> None:
        """Raise if a term (..., terms) is out of its range, or NaN."""
        own = values[..., self.first :]
        is_wrong = ~((own >= self._low) & (own <= self._high))
        if is_wrong.any():
            k = int(np.argwhere(is_wrong)[0][-1])
            term, given = self.terms[k], own[is_wrong][0]
            raise InvalidInput(
                f"reward term {term.name!r}: gave {given:g}, allowed is its range, "
                f"{term.low:g} to {term.high:g}"
            )


def _read_only(given: Records) -> Records:
    """Return a view with attribute access in which a term cannot change the simulation."""
    view = given.view(np.recarray)
    view.flags.writeable = False
    return view


def _address(term: RewardTerm) -> int:
    examples = (
        records(ROBOT, 1)[0], records(PERSON, 1), records(STEP, 1)[0],
        as_record(Rules(1.0, 1.0, 1.0, 1))[0],
    )  # fmt: skip
    return address_of(
        f"reward term {term.name!r}", term.function,
        examples=examples, results=1, passed=(*examples, np.zeros(1)), adapted=_adapted,
    )  # fmt: skip


def _adapted(term: Callable[..., float]) -> tuple[Callable[..., None], Callable[..., None]]:
    def plain(
        robot: Untyped, people: Untyped, record: Untyped, rules: Untyped, out: Floats
    ) -> None:
        out[0] = term(robot, people, record, rules)

    def entry(
        robot: Untyped,
        people: Untyped,
        count: int,
        record: Untyped,
        rules: Untyped,
        out: Untyped,
        size: int,
    ) -> None:
        value = carray(out, (size,))
        value[0] = np.nan  # what stays where the term raises
        value[0] = term(
            carray(robot, (1,))[0], carray(people, (count,)), carray(record, (1,))[0],
            carray(rules, (1,))[0],
        )  # fmt: skip

    return plain, entry
