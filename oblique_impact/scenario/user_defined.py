"""User-defined parts, found by name: laws, base motions, integrators, discretizations; none is imported here.

A part is announced by an installed package through an entry point of its kind's group, or registered by a
program before it makes a scenario:

    @register("friction_laws", "stribeck")
    @dataclass(frozen=True)
    class Stribeck(FrictionLaw): ...

A scenario names it where a built-in one would stand (`contact.friction = "stribeck"`) and gives its numbers
in the section `parameters`.  Processes of a sweep or a cluster know installed parts only.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, TypeVar

from pydantic import GetCoreSchemaHandler
from pydantic_core import CoreSchema, PydanticCustomError, core_schema

from oblique_impact import installed
from oblique_impact.errors import InputError
from oblique_impact.scenario.messages import one_of

T = TypeVar("T")

#: kinds of parts and the class of each part, as "module:class"; a discretization is a module with
#: ``build_operators(scenario) -> BeamOperators`` and ``spectrum(scenario) -> SpinningBeam``, or, with mechanics of
#: its own, ``simulate(scenario, on_progress) -> History`` in place of the first
KINDS = {
    "friction_laws": "oblique_impact.contact.friction:FrictionLaw",
    "contact_laws": "oblique_impact.contact.stops:ContactLaw",
    "impact_laws": "oblique_impact.contact.impacts:ImpactLaw",
    "base_motions": "oblique_impact.beam.base_motion:BaseMotion",
    "integrators": "oblique_impact.marching.scheme:Scheme",
    "discretizations": "",
}

#: what `register` has added in this process
_REGISTERED: dict[tuple[str, str], Any] = {}


def register(kind: str, name: str) -> Callable[[T], T]:
    """Return a decorator that makes a class (or module) known by `name` in this process; the last one counts.

    Raises InputError for a kind that is none of `KINDS`, or a name not made of letters, digits and hyphens.
    """
    if kind not in KINDS:
        raise InputError(f"register: {kind!r}: {one_of(kind, KINDS)}")
    if not name.replace("-", "").isalnum():
        raise InputError(f"register: {name!r}: should be made of letters, digits and hyphens")

    def add(part: T) -> T:
        _REGISTERED[kind, name] = part
        return part

    return add


def names(kind: str) -> list[str]:
    """Return the names of the installed and registered parts of a kind."""
    return sorted({*installed.installed(kind), *(name for of, name in _REGISTERED if of == kind)})


def load(kind: str, name: str) -> Any:
    """Load what stands behind a name; raises KeyError for an unknown one, InputError if it cannot be imported."""
    if (kind, name) in _REGISTERED:
        return _REGISTERED[kind, name]
    return installed.load(installed.installed(kind)[name])


def build(kind: str, name: str, parameters: Mapping[str, float], *arguments: Any) -> Any:
    """Build a user-defined part from the numbers of a scenario: ``part(*arguments, **parameters)``.

    Raises InputError if it does not take these numbers, or is not what its kind has to be.
    """
    part = load(kind, name)
    try:
        built = part(*arguments, **parameters)
    except (TypeError, ValueError) as error:
        raise InputError(f"{name}: {installed.reason(error)}") from None
    module, _, base = KINDS[kind].partition(":")
    # compared by name: this package must not import from those that use it
    if (module, base) not in {(parent.__module__, parent.__name__) for parent in type(built).__mro__}:
        raise InputError(f"{name}: is a {type(built).__name__}, should be a {base} ({module})")
    return built


def discretization(name: str) -> Any:
    """Load the module of an installed discretization; raises KeyError for an unknown name."""
    return load("discretizations", name)


@dataclass(frozen=True)
class Choice:
    """What a key of the scenario may name: a built-in part, or one of a kind; for pydantic's ``Annotated``."""

    kind: str
    built_in: tuple[str, ...] = ()

    @property
    def known(self) -> list[str]:
        """All names that are known here, the built-in ones first."""
        return [*self.built_in, *(name for name in names(self.kind) if name not in self.built_in)]

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_after_validator_function(self._check, handler(source))

    def _check(self, name: str) -> str:
        known = self.known
        if name not in known:
            words = " or ".join(", ".join(map(repr, known)).rsplit(", ", 1))
            words = words or "an installed one, but none is installed (run: make install)"
            raise PydanticCustomError("choice", "{allowed}", {"allowed": words})
        return name
