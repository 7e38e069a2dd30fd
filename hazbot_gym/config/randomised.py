"""Randomised values of a config: distributions in place of numbers, drawn anew in each episode.

    {uniform: [a, b]}     between a and b; whole numbers, both included, where the field is one
    {normal: [m, s]}      mean and standard deviation, truncated at three standard deviations
    {choice: [x, y, ...]} each with the same probability

A config keeps the distributions in ``randomised``, by dotted name (``people.count.1``), and a value
in the middle in the field itself.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from hazbot_gym.config.section import LARGEST, shown
from hazbot_gym.errors import InvalidInput
from hazbot_gym.utils.json_object import JsonObject

if TYPE_CHECKING:
    from hazbot_gym.config.parameters import Config

Distribution = Mapping[str, Any]  # from its kind to its values

KINDS = ("uniform", "normal", "choice")
MOST_DEVIATIONS = 3.0  # at which a normal distribution is truncated
RANDOMISED = "randomised"

# Values that spaces, the size of arrays, the clock of metrics or the scale of actions depend on.
FIXED = (
    "tier", "action_type", "max_episode_steps", "clock", "drive.nominal_speed_mps",
    "drive.latency_steps", "people.model", "people.walkers", "sensors.ring",
    "sensors.tracker.latency_steps", "tracks", "person_slots",
)  # fmt: skip


def is_distribution(value: object) -> bool:
    """Return True for a mapping with a single key, the kind of a distribution."""
    return isinstance(value, Mapping) and len(value) == 1 and next(iter(value)) in KINDS


def is_set(deltas: object, name: str) -> bool:
    """Return True if deltas give the value of a dotted name, or of something that contains it."""
    for key in name.split("."):
        if not isinstance(deltas, Mapping):
            return True
        if key not in deltas:
            return False
        deltas = deltas[key]
    return True


def taken_out(deltas: Mapping[str, object]) -> tuple[JsonObject, JsonObject]:
    """Return deltas with a value in the middle of each distribution, and the distributions.

    Raises:
        InvalidInput: A distribution is malformed, or its field must be the same in all episodes.
    """
    if is_distribution(deltas):
        raise InvalidInput(f"config: given {shown(dict(deltas))}, allowed is a mapping of fields")
    values, found = dict(deltas), dict[str, Any]()
    given = values.pop(RANDOMISED, None) or {}
    if not isinstance(given, Mapping) or not all(map(is_distribution, given.values())):
        allowed = "a mapping from dotted names to distributions"
        raise InvalidInput(f"{RANDOMISED}: given {shown(given)}, allowed is {allowed}")
    values = _taken_out(values, "", found)
    for name, distribution in given.items():
        _taken_out(distribution, str(name), found)
    return values, found


def _taken_out(node: Any, name: str, found: JsonObject) -> Any:
    if is_distribution(node):
        _check(name, node)
        found[name] = {kind: list(values) for kind, values in node.items()}
        return _middle(node)
    inside = f"{name}." if name else ""
    if isinstance(node, Mapping):
        if any(isinstance(node.get(kind), list | tuple) for kind in KINDS):
            allowed = f"one of {', '.join(KINDS)}"
            raise InvalidInput(f"{name}: given {shown(dict(node))}, allowed is {allowed}")
        return {key: _taken_out(each, f"{inside}{key}", found) for key, each in node.items()}
    if type(node) in (list, tuple):
        return [_taken_out(each, f"{inside}{i}", found) for i, each in enumerate(node)]
    return node


def _check(name: str, distribution: Distribution) -> None:
    """Raise if a distribution is malformed, or stands where none may."""
    (kind, values), said = *distribution.items(), shown(dict(distribution))
    if name == "gas" or any(f"{name}.".startswith(f"{each}.") for each in FIXED):
        raise InvalidInput(f"{name}: given {said}, but it must be the same in all episodes")
    is_list = isinstance(values, Sequence) and not isinstance(values, str) and len(values) > 0
    if kind == "choice":
        if not is_list:
            raise InvalidInput(f"{name}: given {said}, allowed is a list of values to choose from")
        return
    are_numbers = is_list and len(values) == 2 and all(map(_is_number, values))
    is_wide = are_numbers and (values[1] > (values[0] if kind == "uniform" else 0.0))
    if not is_wide:
        allowed = "[low, high]" if kind == "uniform" else "[mean, standard deviation above 0]"
        raise InvalidInput(f"{name}: given {said}, allowed is {kind}: {allowed}")


def _is_number(value: object) -> bool:
    if isinstance(value, bool) or not isinstance(value, int | float):
        return False
    return abs(value) <= LARGEST  # NaN is not


def _middle(distribution: Distribution) -> Any:
    ((kind, values),) = distribution.items()
    if kind != "uniform":
        return values[0]
    total = values[0] + values[1]
    return total // 2 if isinstance(total, int) else total / 2.0


def ends(distribution: Distribution, *, is_whole: bool) -> list[Any]:
    """Return the extreme values of a distribution; of a choice, all values."""
    ((kind, values),) = distribution.items()
    if kind != "normal":
        return list(values)
    reach = MOST_DEVIATIONS * values[1]
    found = [values[0] - reach, values[0] + reach]
    return [round(value) for value in found] if is_whole else found


def value_from(distribution: Distribution, u: float, normal: float, *, is_whole: bool) -> Any:
    """Return a value of a distribution.

    Args:
        distribution: The distribution.
        u: Uniform number in (0, 1).
        normal: Standard normal number.
        is_whole: Whether the field is a whole number.
    """
    ((kind, values),) = distribution.items()
    if kind == "choice":
        return values[min(int(u * len(values)), len(values) - 1)]
    low, high = ends(distribution, is_whole=is_whole)
    if kind == "normal":
        value = min(max(values[0] + values[1] * normal, low), high)
        return round(value) if is_whole else value
    return min(low + int(u * (high - low + 1)), high) if is_whole else low + u * (high - low)


def value_at(node: Any, name: str) -> Any:
    """Return the value of a field by its dotted name.

    Raises:
        InvalidInput: There is no such field.
    """
    for key in name.split("."):
        try:
            if isinstance(node, Mapping):
                node = node[key]
            else:
                node = node[int(key)] if key.isdigit() else getattr(node, key)
        except (AttributeError, IndexError, KeyError, TypeError) as error:
            raise InvalidInput(f"{RANDOMISED}: given {name!r}, which is no field") from error
    return node


def has_parts(config: Config, name: str) -> bool:
    """Return True if there is a field of a dotted name, and it is a section or a sequence."""
    try:
        return not isinstance(value_at(config, name), bool | int | float | str | None)
    except InvalidInput:
        return False


def replaced(node: Any, name: str, value: object) -> Any:
    """Return nested mappings and lists with the value of a dotted name, which exists, replaced."""
    key, _, rest = name.partition(".")
    node = node._asdict() if hasattr(node, "_asdict") else node
    if isinstance(node, list | tuple):
        items = list(node)
        items[int(key)] = replaced(items[int(key)], rest, value) if rest else value
        return items
    return {**node, key: replaced(node[key], rest, value) if rest else value}


def extreme_values(config: Config) -> Iterator[tuple[str, Any]]:
    """Yield name and extreme values of each randomised field."""
    for name, distribution in config.randomised.items():
        is_whole = isinstance(value_at(config, name), int)
        for value in ends(distribution, is_whole=is_whole):
            yield name, value


def check_same(base: Config, other: Config) -> None:
    """Raise if two configs differ in a value that must be the same in all episodes."""
    for name in FIXED:
        if value_at(base, name) != value_at(other, name):
            raise InvalidInput(
                f"{name}: given {shown(value_at(other, name))}, but it must be the same in all "
                f"episodes of an environment, {shown(value_at(base, name))}"
            )
    if (base.gas is None) != (other.gas is None):
        raise InvalidInput("gas: all episodes of an environment are with gas, or all without")
    if base.own_terms.keys() != other.own_terms.keys():
        raise InvalidInput("own_terms: all episodes of an environment have the same terms")
