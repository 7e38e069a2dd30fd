"""Sections of a config: strict, frozen and bounded; what is refused is named in one line."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Any, Self, get_args, get_origin

from pydantic import BaseModel, ConfigDict, Strict, ValidationError, model_validator

Loose = Strict(False)  # accepts a list for a tuple, a string for a path; contents are strict

# Bounds beyond any real problem: they catch misplaced digits.
SMALLEST, LARGEST = 1e-12, 1e9  # magnitude of every number but 0


class Section(BaseModel):
    """A section of the config: frozen; misspelt keys, NaN and other types are rejected.

    Types are strict: ``"5"``, ``yes`` and ``true`` are no numbers, and 1.0 is no integer. An
    integer is accepted for a float; ``Loose`` marks further conversions.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False, strict=True)

    @model_validator(mode="before")
    @classmethod
    def _lists_are_whole(cls, values: Any) -> Any:
        """Reject a list that is shorter than its named tuple."""
        for name, field in cls.model_fields.items() if isinstance(values, Mapping) else ():
            for place, names, given in _as_lists(name, field.annotation, values.get(name)):
                if len(given) != len(names):
                    allowed = f"a mapping, or a list of all {len(names)}: {', '.join(names)}"
                    raise ValueError(f"{place}: given {shown(given)}, allowed is {allowed}")
        return values

    @model_validator(mode="after")
    def _sizes_are_sane(self) -> Self:
        for name in type(self).model_fields:
            for field, number in _floats(name, getattr(self, name)):
                if number != 0.0 and not SMALLEST <= abs(number) <= LARGEST:
                    allowed = f"{SMALLEST:g} to {LARGEST:g}"
                    raise ValueError(f"{field}: given {number!r}, allowed are sizes of {allowed}")
        return self


def _as_lists(field: str, kind: object, value: object) -> Iterator[tuple[str, Any, Any]]:
    """Yield field, names and values of each named tuple given as a list."""
    if not isinstance(value, list | tuple):
        return
    if hasattr(kind, "_fields"):
        yield field, kind._fields, value
    elif get_origin(kind) is tuple:
        kinds = get_args(kind)
        kinds = kinds[:1] * len(value) if kinds[-1] is ... else kinds
        for i, (each, part) in enumerate(zip(kinds, value, strict=False)):
            yield from _as_lists(f"{field}.{i}", each, part)
    else:
        for each in get_args(kind):
            yield from _as_lists(field, each, value)


def _floats(field: str, value: object) -> Iterator[tuple[str, float]]:
    """Yield the floats in a field's value and their names, without nested sections."""
    if isinstance(value, float):
        yield field, value
    elif isinstance(value, dict):
        for name, each in value.items():
            yield from _floats(f"{field}.{name}", each)
    elif isinstance(value, tuple | list):
        names = getattr(value, "_fields", range(len(value)))
        yield from _floats(field, dict(zip(names, value, strict=True)))


def first_error(error: ValidationError, model: type[BaseModel]) -> str:
    """Return pydantic's first error as one line: field, given and allowed value."""
    # Of a union's errors, the deepest refers to the intended alternative.
    first = max(error.errors(include_url=False), key=lambda each: len(each["loc"]))
    location, keys = _located(first["loc"], model)
    field = ".".join(location) or "config"
    message = first["msg"].removeprefix("Value error, ")
    if first["type"] == "value_error":
        return f"{field}: {message.removeprefix('env: ')}"
    if first["type"] in ("extra_forbidden", "unexpected_keyword_argument"):
        allowed = f", allowed are {', '.join(keys)}" if keys else ""
        return f"{field}: unknown key{allowed}"
    if first["type"] == "missing":
        return f"{field}: is missing, a value is required"
    return f"{field}: given {shown(first['input'])}, {message[0].lower()}{message[1:]}"


def name_of(field: int | str) -> str:
    """Return the name of a field on one line."""
    return repr(field).strip("'")


def shown(value: object) -> str:
    """Return the repr of a value on one line, shortened."""
    try:
        text = repr(value).replace("\n", "")
    except ValueError:  # Python writes no integers of more than 4300 digits
        return "a number of thousands of digits"
    return text if len(text) <= 120 else f"{text[:117]}..."


def _located(
    location: tuple[int | str, ...], model: type[BaseModel]
) -> tuple[list[str], list[str]]:
    """Return a location without the names of a union's alternatives, and the keys allowed there."""
    names, keys = list[str](), list[str]()
    node: object = model
    for part in location:
        kinds = (node, *get_args(node))
        chosen = [kind for kind in kinds[1:] if getattr(kind, "__name__", None) == part]
        if chosen or "[" in str(part):  # such as literal['A', 'B']
            node = chosen[0] if chosen else node
            continue
        names.append(name_of(part))
        keys = [key for kind in kinds for key in _keys_of(kind)]
        if isinstance(part, int):
            node = next(iter(get_args(node)), None)
        else:
            sections = [getattr(kind, "model_fields", {}) for kind in kinds]
            known = next((each[part] for each in sections if part in each), None)
            node = known.annotation if known else None
    return names, keys


def _keys_of(kind: object) -> Iterator[str]:
    keys: Iterable[str] = getattr(kind, "model_fields", ()) or getattr(kind, "_fields", ())
    return iter(keys)
