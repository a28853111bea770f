"""Bad input in one line: which key, what value, what is allowed, and what may have been meant."""

from __future__ import annotations

import difflib
import re
import reprlib
from collections.abc import Iterable
from typing import Any, NoReturn, get_args

from pydantic import BaseModel, ValidationError

from oblique_impact.scenario.units import Unit, unit_of

_REPR = reprlib.Repr()
_REPR.maxstring = _REPR.maxother = _REPR.maxlong = 60


def refuse(key: str, value: Any, allowed: str) -> NoReturn:
    """Raise the fault of one key inside a validator."""
    raise ValueError(f"{key} = {short(value)}: {allowed}")


def did_you_mean(word: Any, known: Iterable[str], quote: str = "") -> str:
    """Return "; did you mean WORD?" with the most similar of the known words, or nothing if none is similar."""
    close = difflib.get_close_matches(str(word)[:100], list(known), n=1)
    return f"; did you mean {quote}{close[0]}{quote}?" if close else ""


def one_of(word: Any, known: Iterable[str]) -> str:
    """Return "should be one of A, B", and which of them may have been meant."""
    known = list(known)
    return f"should be one of {', '.join(known)}{did_you_mean(word, known)}"


def one_line(error: ValidationError, root: type[BaseModel]) -> str:
    """Put the first fault of a failed validation of the model `root` into one line, which begins with the key."""
    first = error.errors()[0]
    location, value = first["loc"], short(first["input"])
    key = ".".join(str(part) for part in location) or root.__name__
    if first["type"] == "extra_forbidden":
        return f"{key} = {value}: unknown key{_known_keys(root, location)}"
    if first["type"] == "missing":
        return f"{key}: missing"
    if first["type"] in ("too_short", "too_long"):
        allowed = first["msg"].removeprefix("List ").partition(" after validation")[0]
        return f"{key} = {value}: {allowed}"
    message = first["msg"].removeprefix("Value error, ").removeprefix("Input should be ")
    if first["type"] == "value_error":
        return message
    if first["type"] in ("literal_error", "choice"):
        message += did_you_mean(first["input"], re.findall("'([^']*)'", message), "'")
    if first["type"] in ("less_than_equal", "greater_than_equal") and _unit(root, location) == Unit("rad"):
        message += f' rad; for degrees write "{value} deg"'
    return f"{key} = {value}: should be {message}"


def short(value: Any) -> str:
    """Return a value in at most 60 characters."""
    try:
        text = " ".join(_REPR.repr(value).split())
    except ValueError:
        text = "an integer of thousands of digits"
    return text if len(text) <= 60 else f"{text[:57]}..."


def _known_keys(root: type[BaseModel], location: tuple[Any, ...]) -> str:
    """Say which keys are known where an unknown one stands, and which was meant there or in another section."""
    name, known = location[-1], _model(root, location).model_fields
    meant = did_you_mean(name, known)
    if not meant:
        places = {key: f"{section}.{key}" for section in root.model_fields for key in _keys(root, section)}
        meant = f"; did you mean {places[name]}?" if name in places else ""
    return f"{meant} (allowed here: {', '.join(known)})" if meant else f"; allowed here: {', '.join(known)}"


def _keys(root: type[BaseModel], section: str) -> Iterable[str]:
    """Return the keys of a section of `root`, none if it is no section."""
    annotation = root.model_fields[section].annotation
    is_section = isinstance(annotation, type) and issubclass(annotation, BaseModel)
    return annotation.model_fields if is_section else ()  # type: ignore[union-attr]


def _unit(root: type[BaseModel], location: tuple[Any, ...]) -> Unit | None:
    field = _model(root, location).model_fields.get(location[-1])
    return unit_of(field) if field else None


def _model(model: type[BaseModel], location: tuple[Any, ...]) -> type[BaseModel]:
    """Return the model that holds the key at a location."""
    for part in location[:-1]:
        if isinstance(part, int):  # a place in a list of models
            continue
        field = model.model_fields.get(part)
        parts = _parts(field.annotation) if field else ()
        inner = (a for a in parts if isinstance(a, type) and issubclass(a, BaseModel))
        model = next(inner, model)
    return model


def _parts(annotation: Any) -> list[Any]:
    """Return an annotation and what it is made of: `list[X] | None` holds X."""
    return [annotation, *(part for argument in get_args(annotation) for part in _parts(argument))]
