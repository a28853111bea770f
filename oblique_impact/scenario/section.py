"""What every section of an input file is: frozen, strict, and refused with an InputError of one line."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Self

from pydantic import BaseModel, ConfigDict, ValidationError

from oblique_impact.errors import InputError
from oblique_impact.scenario.messages import one_line, short


class Section(BaseModel):
    """Base of all sections: frozen, strict, no unknown keys, no NaN or infinity.

    Numbers with a dimension declare their unit, ``Annotated[float, Unit("m")]``; those without one have none.  The
    documentation reads their meaning from the comments: behind a key, or "#: meaning" above it.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, allow_inf_nan=False)

    if not TYPE_CHECKING:  # type checkers know the keys as arguments

        def __init__(self, /, **data: Any) -> None:
            try:
                super().__init__(**data)
            except ValidationError as error:
                raise InputError(one_line(error, type(self))) from None

        # validation of a whole file makes its sections itself, and tells where in it a fault is
        __init__.__pydantic_base_init__ = True

        def __setattr__(self, name: str, value: Any) -> None:
            raise InputError(
                f"{name} = {short(value)}: scenarios are frozen; Scenario.replace returns a changed one"
            )

    @classmethod
    def model_validate(cls, obj: Any, **options: Any) -> Self:
        """Validate plain data; raises InputError with one line about the first fault."""
        try:
            return super().model_validate(obj, **options)
        except ValidationError as error:
            raise InputError(one_line(error, cls)) from None

    @classmethod
    def from_dict(cls, data: dict[str, Any]) -> Self:
        """Validate nested sections; raises InputError with one line about the first fault."""
        return cls.model_validate(data)
