"""The words of an error: which key, what value, what is allowed, and what may have been meant."""

from __future__ import annotations

import difflib
import reprlib
from collections.abc import Iterable
from typing import Any

from pydantic_core import PydanticCustomError

_REPR = reprlib.Repr()
_REPR.maxstring = _REPR.maxother = _REPR.maxlong = 60


def short(value: Any) -> str:
    """Return a value in at most 60 characters."""
    try:
        text = " ".join(_REPR.repr(value).split())
    except ValueError:
        text = "an integer of thousands of digits"
    return text if len(text) <= 60 else f"{text[:57]}..."


def did_you_mean(word: Any, known: Iterable[str], quote: str = "") -> str:
    """Return "; did you mean WORD?" with the most similar of the known words, or nothing if none is similar."""
    close = difflib.get_close_matches(str(word)[:100], list(known), n=1)
    return f"; did you mean {quote}{close[0]}{quote}?" if close else ""


def one_of(word: Any, known: Iterable[str]) -> str:
    """Return "should be one of A, B", and which of them may have been meant."""
    known = list(known)
    return f"should be one of {', '.join(known)}{did_you_mean(word, known)}"


def not_allowed(allowed: str) -> PydanticCustomError:
    """Return the error of a validator whose value should be `allowed`."""
    # without a context the message is taken as it is, braces and all
    return PydanticCustomError("not_allowed", allowed)
