"""What every refusal has to be."""

from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from oblique_impact import InputError


@contextmanager
def refused_in_one_line(*parts: str, start: str = "") -> Iterator[None]:
    """Expect an InputError of one line that is not too long, begins so and has all the parts."""
    with pytest.raises(InputError) as caught:
        yield
    message = str(caught.value)
    assert len(message.splitlines()) == 1, message
    assert len(message) < 400
    assert message.startswith(start), message
    for part in parts:
        assert part in message, message
