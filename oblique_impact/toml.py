"""TOML from anybody: read in bounded time, faults in one line."""

from __future__ import annotations

import re
import tomllib
from typing import Any

from oblique_impact.errors import InputError

_MOST_PARTS = 20
_PART = r"""(?:"(?:[^"\\\n]|\\.)*+"|'[^'\n]*+'|[\w-]++)"""
#: tomllib takes time with the square of the parts of a key
_LONG_KEY = re.compile(rf"(?:^|[{{,\[])[ \t]*+{_PART}(?:[ \t]*+\.[ \t]*+{_PART}){{{_MOST_PARTS}}}", re.MULTILINE)


def parse_toml(text: str, what: str) -> dict[str, Any]:
    """Parse a file's text; `what` it is begins the one line of an InputError."""
    if _LONG_KEY.search(text):
        raise InputError(f"{what}: a key of more than {_MOST_PARTS} parts; keys have two")
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"{what}: not valid TOML: {error}") from None
    except RecursionError:
        raise InputError(f"{what}: nested too deeply; sections have one level") from None
    except ValueError as error:  # integers of thousands of digits
        raise InputError(f"{what}: {error}") from None
