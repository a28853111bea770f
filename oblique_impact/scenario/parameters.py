"""Numbers of parts of one's own: the section `parameters` of a scenario, and the parts built from it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any

from pydantic import PlainSerializer, PlainValidator
from pydantic_core import PydanticCustomError

from oblique_impact.scenario.messages import short

_LARGEST = 1e30
_MOST = 100

#: kept as pairs sorted by name, so that a scenario stays hashable; a table in files and in Python
Pairs = tuple[tuple[str, float], ...]


def _validate(value: Any) -> Pairs:
    if isinstance(value, tuple):
        value = dict(value)
    if not isinstance(value, Mapping) or len(value) > _MOST:
        raise _fault(f"a table of at most {_MOST} numbers by name")
    pairs = []
    for name, number in value.items():
        if not (isinstance(name, str) and name.isidentifier()):
            raise _fault(f"a table whose names are made of letters, digits and underscores, not {short(name)}")
        if isinstance(number, bool) or not isinstance(number, (int, float)) or not abs(number) <= _LARGEST:
            raise _fault(f"a table of finite numbers; {name} is {short(number)}")
        pairs.append((name, float(number)))
    return tuple(sorted(pairs))


def _fault(allowed: str) -> PydanticCustomError:
    return PydanticCustomError("parameters", "{allowed}", {"allowed": allowed})


Parameters = Annotated[Pairs, PlainValidator(_validate), PlainSerializer(dict, return_type=dict[str, float])]
