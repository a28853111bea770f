"""Base class of the sections of input files: frozen, strict, errors in one line."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from inspect import Parameter, Signature
from typing import TYPE_CHECKING, Any, ClassVar, Self, TypeVar

from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from oblique_impact.errors import InputError
from oblique_impact.scenario.messages import did_you_mean, refused, short
from oblique_impact.scenario.units import unit_of

T = TypeVar("T")


def key(default: T, meaning: str) -> T:
    """Return the default of a key with its meaning, from which comments, schema and documentation are made."""
    return Field(default=default, description=meaning)


class InputSection(BaseModel):
    """Base of all sections: frozen, strict, no unknown keys, no NaN or infinity.

    Numbers with a dimension declare their unit, ``Annotated[float, Unit("m")]``.  Bad input raises InputError, in
    one line that begins with the key; a section in a section puts its own name in front of the line.
    """

    model_config = ConfigDict(strict=True, allow_inf_nan=False, frozen=True, extra="forbid")

    #: number, in errors, of the first item of a list in this section
    first_item: ClassVar[int] = 0
    #: keys that follow those of other sections where they are not given
    followers: ClassVar[frozenset[str]] = frozenset()

    if not TYPE_CHECKING:  # type checkers know the keys as arguments

        def __init__(self, /, **data: Any) -> None:
            try:
                super().__init__(**data)
            except ValidationError as error:
                raise InputError(_one_line(error, type(self))) from None

        @classmethod
        def __pydantic_init_subclass__(cls, **options: Any) -> None:
            # for help(): the annotations of keys with a unit and a range fill screens
            keys = {name: field.default for name, field in cls.model_fields.items()}
            kind = Parameter.KEYWORD_ONLY
            cls.__signature__ = Signature([Parameter(name, kind, default=value) for name, value in keys.items()])

        def __repr__(self) -> str:
            """Return the call that makes it, of the keys that were given and are not at a fixed default."""
            given = {
                name: getattr(self, name) for name in type(self).model_fields if name in self.model_fields_set
            }
            fields = type(self).model_fields
            known = {k: fields[k].default for k in fields if k not in self.followers}
            told = (f"{k}={v!r}" for k, v in given.items() if k not in known or v != known[k])
            return f"{type(self).__name__}({', '.join(told)})"

        __str__ = __repr__

        def __setattr__(self, name: str, value: Any) -> None:
            raise refused(name, value, "scenarios are frozen; Scenario.replace returns a changed one")

    def conflicts(self) -> Iterator[tuple[str, str]]:
        """Yield each key that does not fit the others of this section, with what is allowed."""
        yield from ()

    @model_validator(mode="after")
    def _keys_fit_together(self) -> Self:
        for name, allowed in self.conflicts():
            raise refused(name, self.value_of(name), allowed)
        return self

    def value_of(self, name: str) -> Any:
        """Return the value of "section.key"; items of lists of sections count from 1, "obstacles.1.radius"."""
        value: Any = self
        for part in name.split("."):
            value = value[int(part) - 1] if part.isdigit() else getattr(value, part)
        return value

    def given(self, prefix: str = "") -> Iterator[str]:
        """Yield the keys that were given, "section.key", those of sections within this one too."""
        for name in type(self).model_fields:
            if name not in self.model_fields_set:
                continue
            value = getattr(self, name)
            yield from value.given(f"{prefix}{name}.") if isinstance(value, InputSection) else [f"{prefix}{name}"]
            for number, item in enumerate(value if isinstance(value, tuple) else (), start=1):
                if isinstance(item, InputSection):
                    yield from item.given(f"{prefix}{name}.{number}.")

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> Self:
        """Validate nested sections; raises InputError with one line about the first error."""
        if not isinstance(data, Mapping) or not all(isinstance(name, str) for name in data):
            raise InputError(f"{cls.__name__} = {short(data)}: should be a dictionary of sections and keys")
        return cls(**data)

    def with_defaults(self, **values: Any) -> Self:
        """Return a copy in which keys that were not given have these values; they still count as not given."""
        new = {name: value for name, value in values.items() if name not in self.model_fields_set}
        return self.model_construct(self.model_fields_set, **{**dict(self), **new})


#: what a value of another type should be, by the type of its error
_KINDS = {
    "bool_parsing": "true or false",
    "bool_type": "true or false",
    "float_parsing": "a number",
    "float_type": "a number",
    "int_parsing": "a whole number",
    "int_type": "a whole number",
    "int_from_float": "a whole number",
    "string_type": "a text",
    "tuple_type": "a list",
    "list_type": "a list",
    "dict_type": "a table",
    "model_type": "a table",
    "model_attributes_type": "a table",
}


def _one_line(error: ValidationError, section: type[InputSection]) -> str:
    """Put the first error into one line, which begins with the key, of a section."""
    fields = section.model_fields
    first = error.errors()[0]
    value, kind, message = short(first["input"]), first["type"], first["msg"]
    path = [str(part + section.first_item if isinstance(part, int) else part) for part in first["loc"]]
    key = ".".join(path)
    cause = first.get("ctx", {}).get("error")
    if isinstance(cause, InputError):  # of a section in this one, or of keys that do not fit together
        return f"{key}.{cause}" if key else str(cause)
    if kind == "extra_forbidden":
        return f"{key} = {value}: unknown key{did_you_mean(key, fields)}; allowed here: {', '.join(fields)}"
    if kind == "missing":
        return f"{key}: missing"
    if kind in ("too_short", "too_long"):
        allowed = message.partition(" after validation")[0]
        return f"{key} = {value}: {allowed.removeprefix('Tuple ').removeprefix('List ')}"
    message = message.removeprefix("Value error, ").removeprefix("Input should be ")
    message = _KINDS.get(kind, message)
    if kind == "literal_error":
        message = message.replace("'", '"')
        message += did_you_mean(first["input"], re.findall('"([^"]*)"', message), '"')
    if kind in ("less_than_equal", "greater_than_equal"):
        unit = unit_of(fields[path[0]])
        if unit is not None and unit.symbol == "rad":
            message += f' rad; for degrees write "{value} deg"'
    return f"{key} = {value}: should be {message}"
