"""Bad input in one line: which key, what value, what is allowed."""

from __future__ import annotations

import reprlib
from typing import Any, NoReturn, get_args

from pydantic import BaseModel, ValidationError

_REPR = reprlib.Repr()
_REPR.maxstring = _REPR.maxother = _REPR.maxlong = 60


def refuse(key: str, value: Any, allowed: str) -> NoReturn:
    """Raise the fault of one key inside a validator."""
    raise ValueError(f"{key} = {short(value)}: {allowed}")


def one_line(error: ValidationError, root: type[BaseModel]) -> str:
    """Put the first fault of a failed validation of the model `root` into one line."""
    first = error.errors()[0]
    key = ".".join(str(part) for part in first["loc"])
    if first["type"] == "extra_forbidden":
        known = _known_keys(root, first["loc"])
        return f"{key} = {short(first['input'])}: unknown key; allowed here: {known}"
    if first["type"] == "missing":
        return f"{key}: missing"
    if first["type"] in ("too_short", "too_long"):
        allowed = first["msg"].removeprefix("List ").partition(" after validation")[0]
        return f"{key} = {short(first['input'])}: {allowed}"
    message = first["msg"].removeprefix("Value error, ").removeprefix("Input should be ")
    if first["type"] == "value_error":
        return message
    return f"{key} = {short(first['input'])}: should be {message}"


def short(value: Any) -> str:
    """Return a value in at most 60 characters."""
    try:
        text = " ".join(_REPR.repr(value).split())
    except ValueError:
        text = "an integer of thousands of digits"
    return text if len(text) <= 60 else f"{text[:57]}..."


def _known_keys(model: type[BaseModel], location: tuple[Any, ...]) -> str:
    for part in location[:-1]:
        if isinstance(part, int):  # a place in a list of models
            continue
        annotation = model.model_fields[part].annotation
        model = next(a for a in _parts(annotation) if isinstance(a, type) and issubclass(a, BaseModel))
    return ", ".join(model.model_fields)


def _parts(annotation: Any) -> list[Any]:
    """Return an annotation and what it is made of: `list[X] | None` holds X."""
    return [annotation, *(part for argument in get_args(annotation) for part in _parts(argument))]
