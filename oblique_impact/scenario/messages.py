"""Words of messages: a key, its value, what is allowed, the most similar word; numbers of things."""

from __future__ import annotations

import difflib
import json
import reprlib
import unicodedata
from collections.abc import Iterable
from typing import Any

from oblique_impact.errors import InputError


class _Toml(reprlib.Repr):
    """Values as scenario files have them."""

    def repr_tuple(self, x: tuple[Any, ...], level: int) -> str:
        return self.repr_list(list(x), level)

    def repr_str(self, x: str, level: int) -> str:
        return json.dumps(x if len(x) <= 60 else f"{x[:57]}...", ensure_ascii=False)

    def repr_dict(self, x: dict[Any, Any], level: int) -> str:
        if level <= 0:
            return "{...}"
        shown = [f"{name} = {self.repr1(x[name], level - 1)}" for name in list(x)[: self.maxdict]]
        return f"{{{', '.join(shown + ['...'] * (len(x) > self.maxdict))}}}"

    def repr_bool(self, x: bool, level: int) -> str:
        return str(x).lower()


_TOML = _Toml()
_TOML.maxother = _TOML.maxlong = 60


def short(value: Any) -> str:
    """Return a value, as scenario files have it, in at most 60 characters."""
    text = " ".join(_TOML.repr(value).split())
    return text if len(text) <= 60 else f"{text[:57]}..."


def counted(number: int, thing: str) -> str:
    """Return a number of things as text: "1 contact", "2 contacts"."""
    return f"{number} {thing}{'' if number == 1 else 's'}"


def refused(key: str, value: Any, allowed: str) -> InputError:
    """Return the error of a key whose value does not fit: "KEY = VALUE: ALLOWED"."""
    return InputError(f"{key} = {short(value)}: {allowed}")


def did_you_mean(word: Any, known: Iterable[str], quote: str = "") -> str:
    """Return "; did you mean WORD?" with the most similar of the known words, "" if none is similar."""
    close = difflib.get_close_matches(str(word)[:100], list(known), n=1)
    return f"; did you mean {quote}{close[0]}{quote}?" if close else ""


def one_of(word: Any, known: Iterable[str]) -> str:
    """Return "should be one of A, B", with the most similar of them."""
    known = list(known)
    return f"should be one of {', '.join(known)}{did_you_mean(word, known)}"


def plain_text(text: str) -> str:
    """Return a text; raises ValueError if it has control characters but tabs: XML, so SVG and XDMF, has none."""
    if any(c != "\t" and (unicodedata.category(c) in ("Cc", "Cs") or c in "\ufffe\uffff") for c in text):
        raise ValueError("a text without control characters")
    return text
