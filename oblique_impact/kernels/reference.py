"""Named tuples by reference: kernels hand on one address in place of all that a tuple holds.

numba hands tuples on by value, and an array alone is seven values: the functions of a march would mostly copy, and
take an order of magnitude longer.  A reference lasts as long as the call of the function that made it.  The arrays
in it are owned by the caller of the kernel, so that numba need not count references to them.  All this is numba's
interface for extensions (`numba.extending`) and that of llvmlite.
"""

from __future__ import annotations

import hashlib
from typing import Any, TypeVar

from llvmlite import ir
from numba import types
from numba.core.typing.templates import AttributeTemplate
from numba.extending import (
    infer_getattr,
    lower_builtin,
    lower_getattr_generic,
    models,
    register_model,
    type_callable,
)

T = TypeVar("T")


def by_reference(value: T) -> T:
    """Return a named tuple, in compiled source as a reference to a copy of it; a reference stays what it is.

    Fields are read as before, those that are named tuples by reference too.  An array stays as it is but that it
    does not own its memory.
    """
    return value


class Reference(types.Type):
    """The compiler's type of a reference to a named tuple of the type `of`."""

    def __init__(self, of: types.BaseNamedTuple) -> None:
        self.of = of
        # short, as the names of compiled functions have it in them; one for each type, lest a kernel from the
        # cache and another one of this process have functions of the same name for different layouts
        layout = hashlib.sha256(str(of).encode()).hexdigest()[:16]
        super().__init__(name=f"reference({of.instance_class.__name__}-{layout})")

    @property
    def key(self) -> Any:
        """Return what two references are compared by: the type of their tuples."""
        return self.of

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
    """What the compiler asks for the types of fields."""

    key = Reference

    def generic_resolve(self, kind: Reference, name: str) -> Any:
        if name not in kind.of.fields:
            return None
        _, found = kind.field(name)
        return Reference(found) if isinstance(found, types.BaseNamedTuple) else found


@lower_getattr_generic(Reference)
def _read(context: Any, builder: Any, kind: Reference, value: Any, name: str) -> Any:
    index, found = kind.field(name)
    place = builder.gep(value, [ir.IntType(32)(0), ir.IntType(32)(index)], inbounds=True)
    if isinstance(found, types.BaseNamedTuple):
        return place
    return _unowned(context, builder, found, builder.load(place))


def _unowned(context: Any, builder: Any, kind: Any, value: Any) -> Any:
    """Return an array without its memory's owner, anything else as it is."""
    if not isinstance(kind, types.Array):
        return value
    array = context.make_helper(builder, kind, value=value)
    array.meminfo = array.meminfo.type(None)
    array.parent = array.parent.type(None)
    return array._getvalue()


@type_callable(by_reference)
def _type_of_reference(context: Any) -> Any:
    def typer(value: Any) -> Any:
        return Reference(value) if isinstance(value, types.BaseNamedTuple) else value

    return typer


@lower_builtin(by_reference, types.BaseNamedTuple)
def _copy_to_stack(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    with builder.goto_entry_block():
        place = builder.alloca(arguments[0].type)
    builder.store(arguments[0], place)
    return place


@lower_builtin(by_reference, Reference)
def _keep(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    return arguments[0]


@lower_builtin(by_reference, types.Array)
def _disown(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    return _unowned(context, builder, signature.args[0], arguments[0])
