"""Named tuples by reference: kernels hand on one address in place of all that a tuple holds.

A reference lasts as long as the call of the function that made it.  numba's public ways cost more: structures on
the heap (`numba.experimental.structref`) are counted at every access, and tuples by value make marching take 1.7
to 2.4 times as long.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from numba import types
from numba.core import cgutils
from numba.core.typing.templates import AttributeTemplate, infer_getattr
from numba.extending import lower_builtin, lower_getattr_generic, models, register_model, type_callable


class Reference(types.Type):
    """The compiler's type of a reference to a named tuple of the type `of`."""

    def __init__(self, of: types.BaseNamedTuple) -> None:
        self.of = of
        super().__init__(name=f"reference({of})")

    @property
    def instance_class(self) -> type:
        """Class of the named tuple."""
        found: type = self.of.instance_class
        return found

    def field(self, name: str) -> tuple[int, Any]:
        """Return a field's index and type."""
        index = self.of.fields.index(name)
        return index, self.of.types[index]


@register_model(Reference)
class _ReferenceModel(models.PrimitiveModel):
    def __init__(self, manager: Any, kind: Reference) -> None:
        super().__init__(manager, kind, manager.lookup(kind.of).get_value_type().as_pointer())


@infer_getattr
class _Fields(AttributeTemplate):
    key = Reference

    def generic_resolve(self, kind: Reference, name: str) -> Any:
        if name not in kind.of.fields:
            return None
        _, found = kind.field(name)
        return Reference(found) if isinstance(found, types.BaseNamedTuple) else found


@lower_getattr_generic(Reference)
def _read(context: Any, builder: Any, kind: Reference, value: Any, name: str) -> Any:
    index, found = kind.field(name)
    place = cgutils.gep_inbounds(builder, value, 0, index)
    return place if isinstance(found, types.BaseNamedTuple) else builder.load(place)


def compile_references(by_reference: Callable[..., Any]) -> None:
    """Make the compiler take calls of the function `by_reference` for references to named tuples."""

    @type_callable(by_reference)
    def type_of_reference(context: Any) -> Any:
        def typer(value: Any) -> Any:
            return Reference(value) if isinstance(value, types.BaseNamedTuple) else value

        return typer

    @lower_builtin(by_reference, types.BaseNamedTuple)
    def copy_to_stack(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return cgutils.alloca_once_value(builder, arguments[0])

    @lower_builtin(by_reference, Reference)
    def keep(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return arguments[0]
