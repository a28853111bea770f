"""What every section of an input file is: frozen, strict, and refused with an InputError of one line."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any, Self, TypeVar, get_args

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from oblique_impact.errors import InputError
from oblique_impact.scenario.messages import did_you_mean, short
from oblique_impact.scenario.units import Unit, unit_of

T = TypeVar("T")


def key(default: T, meaning: str) -> T:
    """Return the default of a key together with its meaning, which every text about the key is made from."""
    return Field(default=default, description=meaning)


class Section(BaseModel):
    """Base of all sections: frozen, strict, no unknown keys, no NaN or infinity.

    Numbers with a dimension declare their unit, ``Annotated[float, Unit("m")]``; those without one have none.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, allow_inf_nan=False)

    if not TYPE_CHECKING:  # type checkers know the keys as arguments

        def __init__(self, /, **data: Any) -> None:
            try:
                super().__init__(**data)
            except ValidationError as error:
                raise InputError(_one_line(error, type(self))) from None

        # validation of a whole file makes its sections itself, and tells where in it an error is
        __init__.__pydantic_base_init__ = True

        def __setattr__(self, name: str, value: Any) -> None:
            raise InputError(
                f"{name} = {short(value)}: scenarios are frozen; Scenario.replace returns a changed one"
            )

    @classmethod
    def model_validate(cls, obj: Any, **options: Any) -> Self:
        """Validate plain data; raises InputError with one line about the first error."""
        try:
            return super().model_validate(obj, **options)
        except ValidationError as error:
            raise InputError(_one_line(error, cls)) from None

    @classmethod
    def from_dict(cls, data: dict[str, Any]) -> Self:
        """Validate nested sections; raises InputError with one line about the first error."""
        return cls.model_validate(data)


def _one_line(error: ValidationError, root: type[BaseModel]) -> str:
    """Put the first error of a failed validation of the model `root` into one line, which begins with the key."""
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
    if first["type"] == "value_error":  # of a rule between keys: it names the key itself
        return message
    if first["type"] in ("literal_error", "choice"):
        message += did_you_mean(first["input"], re.findall("'([^']*)'", message), "'")
    if first["type"] in ("less_than_equal", "greater_than_equal"):
        field = _model(root, location).model_fields.get(str(location[-1]))
        if field and unit_of(field) == Unit("rad"):
            message += f' rad; for degrees write "{value} deg"'
    return f"{key} = {value}: should be {message}"


def _known_keys(root: type[BaseModel], location: tuple[Any, ...]) -> str:
    """Say which keys are known where an unknown one stands, and which was meant there or in another section."""
    name, known = location[-1], _model(root, location).model_fields
    meant = did_you_mean(name, known)
    if not meant:
        places = {
            key: f"{section}.{key}"
            for section, field in root.model_fields.items()
            for model in _models(field.annotation)[:1]
            for key in model.model_fields
        }
        meant = f"; did you mean {places[name]}?" if name in places else ""
    return f"{meant} (allowed here: {', '.join(known)})" if meant else f"; allowed here: {', '.join(known)}"


def _model(model: type[BaseModel], location: tuple[Any, ...]) -> type[BaseModel]:
    """Return the model that holds the key at a location; numbers in it are places in a list of models."""
    for part in location[:-1]:
        field = model.model_fields.get(part) if isinstance(part, str) else None
        model = next(iter(_models(field.annotation) if field else ()), model)
    return model


def _models(annotation: Any) -> list[type[BaseModel]]:
    """Return the models in an annotation: `list[X] | None` holds X."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    parts: Iterable[Any] = get_args(annotation)
    return [model for part in parts for model in _models(part)]
