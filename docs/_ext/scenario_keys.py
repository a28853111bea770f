"""The reference of the scenario's keys, from the pydantic models and their comments: nothing is written by hand.

A model tells types, units, ranges and defaults; its source tells meanings in the comments of the keys; the
validators tell which keys exclude each other, in the words of their errors.
"""

from __future__ import annotations

import ast
import inspect
import io
import math
import re
import tokenize
from collections.abc import Iterator
from dataclasses import dataclass
from importlib.metadata import entry_points
from typing import Any, Literal, get_args, get_origin

from docutils import nodes
from pydantic import BaseModel
from pydantic.fields import FieldInfo
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

from oblique_impact.errors import InputError
from oblique_impact.scenario import rules as rules_of_keys
from oblique_impact.scenario import scenario
from oblique_impact.scenario import sections as sections_of_keys
from oblique_impact.scenario.scenario import Scenario
from oblique_impact.scenario.section import Section
from oblique_impact.scenario.tables import Pairs, Table
from oblique_impact.scenario.units import unit_of
from oblique_impact.scenario.user_defined import Choice

_LARGEST = 1e30  # a bound that only keeps infinity out
_SIGNS = {"gt": ">", "ge": "≥", "lt": "<", "le": "≤"}


@dataclass(frozen=True)
class Key:
    """One key: where it stands, its type, what is allowed, its default, unit and meaning."""

    section: str
    name: str
    kind: str
    allowed: str
    default: str
    unit: str
    meaning: str

    @property
    def path(self) -> str:
        """`section.key`, as ``--set`` takes it."""
        return f"{self.section}.{self.name}" if self.section else self.name


def sections() -> list[tuple[str, type[BaseModel]]]:
    """Return the models of the scenario file in its order; the keys without a section are called ""."""
    inner = [(name, f.annotation) for name, f in Scenario.model_fields.items() if _is_section(f)]
    return [("", Scenario), *inner]  # type: ignore[list-item]


def every_key() -> list[Key]:
    """Return every key of the scenario file, in its order."""
    found = []
    for section, model in sections():
        comments = read_comments(model)
        for name, field in model.model_fields.items():
            if not _is_section(field):
                allowed, default = _allowed(model, name, field), _default(section, name, field)
                found.append(Key(section, name, _kind(field), allowed, default, _unit(field), comments[name]))
    return found


def read_comments(model: type[BaseModel]) -> dict[str, str]:
    """Return the meaning of each key from the comments in the source of a model."""
    source = inspect.getsource(sections_of_keys.ScenarioKeys if model is Scenario else model)
    behind, above = {}, {}
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        if token.type == tokenize.COMMENT:
            text = token.string.lstrip("#:").strip()
            (above if token.line.lstrip().startswith("#:") else behind)[token.start[0]] = text
    found = {}
    (body,) = ast.parse(source).body
    assert isinstance(body, ast.ClassDef)
    for node in body.body:
        if isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name):
            lines, line = [behind[node.end_lineno]] if node.end_lineno in behind else [], node.lineno - 1
            while line in above:
                lines.insert(0, above[line])
                line -= 1
            found[node.target.id] = " ".join(lines)
    return found


def rules() -> list[tuple[str, str]]:
    """Return (key, what is refused) of the checks that look at several keys, from their own messages."""
    found = set()
    for function in ast.walk(ast.parse(inspect.getsource(rules_of_keys))):
        if isinstance(function, ast.FunctionDef) and function.name.startswith("_check_"):
            texts = {n: v.value for n, v in _assigned(function) if isinstance(v, ast.Constant)}
            for pair, names in _refusals(function, texts):
                found.add((_words(pair.elts[0], names), _words(pair.elts[1], names)))
    return sorted(found, key=lambda row: (_place(row[0]), row[1]))


def _assigned(function: ast.FunctionDef) -> Iterator[tuple[str, ast.expr]]:
    """Yield names that a function gives to expressions, also several at once."""
    for node in ast.walk(function):
        if isinstance(node, ast.Assign):
            target = node.targets[0]
            names = target.elts if isinstance(target, ast.Tuple) else [target]
            values = node.value.elts if isinstance(node.value, ast.Tuple) else [node.value]
            if len(names) == len(values):
                yield from ((n.id, v) for n, v in zip(names, values, strict=True) if isinstance(n, ast.Name))


def _refusals(function: ast.FunctionDef, texts: dict[str, Any]) -> Iterator[tuple[ast.Tuple, dict[str, Any]]]:
    """Yield what is yielded, each with the words that stand behind the names in it; loops are run through."""
    tables = {n: ast.literal_eval(v) for n, v in _assigned(function) if isinstance(v, ast.Dict)}
    looped = set()
    for loop in (node for node in ast.walk(function) if isinstance(node, ast.For)):
        inside = list(_yielded(loop))
        looped.update(map(id, inside))
        for names in _turns(loop, tables):
            yield from ((pair, texts | names) for pair in inside)
    yield from ((pair, texts) for pair in _yielded(function) if id(pair) not in looped)


def _turns(loop: ast.For, tables: dict[str, Any]) -> Iterator[dict[str, Any]]:
    """Yield values of a loop's names in each turn, over a literal tuple or over the items of a literal table."""
    if isinstance(loop.target, ast.Name):
        yield from ({loop.target.id: value} for value in ast.literal_eval(loop.iter))
        return
    assert isinstance(loop.target, ast.Tuple)
    assert isinstance(loop.iter, ast.Call)
    first, second = (ast.unparse(name) for name in loop.target.elts)
    table = tables[ast.unparse(loop.iter.func).removesuffix(".items")]
    yield from ({first: name, second: value} for name, value in table.items())


def _yielded(node: ast.AST) -> Iterator[ast.Tuple]:
    """Yield the pairs (key, what is allowed) that a rule yields."""
    for inner in ast.walk(node):
        if isinstance(inner, ast.Yield) and isinstance(inner.value, ast.Tuple):
            yield inner.value


def _words(node: ast.expr, names: dict[str, Any]) -> str:
    """Text of a message; what is not known before a run becomes an ellipsis."""
    if isinstance(node, ast.Constant):
        return str(node.value)
    assert isinstance(node, ast.JoinedStr), ast.dump(node)
    parts = (v.value if isinstance(v, ast.Constant) else _known(v, names) for v in node.values)
    return "".join(str(part) for part in parts)


def _known(part: ast.expr, names: dict[str, Any]) -> Any:
    assert isinstance(part, ast.FormattedValue)
    name = ast.unparse(part.value)
    return names.get(name, getattr(rules_of_keys, name, "…"))


def _place(path: str) -> int:
    return [key.path for key in every_key()].index(path)


def _is_section(field: FieldInfo) -> bool:
    return isinstance(field.annotation, type) and issubclass(field.annotation, Section)


def _unit(field: FieldInfo) -> str:
    """Return the declared unit; numbers without one have the unit 1, words and switches have none."""
    unit = unit_of(field)
    if unit is not None:
        return unit.shown
    return "1" if field.annotation in (float, int) else ""


def _kind(field: FieldInfo) -> str:
    annotation = field.annotation
    if annotation == Pairs:
        return ""
    if get_origin(annotation) is Literal:
        return "one of"
    if get_origin(annotation) is tuple:
        return "two numbers"
    names = {float: "number", int: "whole number", bool: "", str: "one of", float | Table: ""}
    return names[annotation]  # type: ignore[arg-type]


def _allowed(model: type[BaseModel], name: str, field: FieldInfo) -> str:
    annotation = field.annotation
    if get_origin(annotation) is Literal:
        return ", ".join(f'``"{value}"``' for value in get_args(annotation))
    if annotation is bool:
        return "``true``, ``false``"
    choice = next((entry for entry in field.metadata if isinstance(entry, Choice)), None)
    if choice is not None:
        return ", ".join(f'``"{value}"``' for value in _installed(choice))
    if annotation == Pairs:
        return "a table of numbers by name"
    bounds = _bounds(field.metadata)
    if get_origin(annotation) is tuple:
        bounds = _bounds([part for item in get_args(annotation) for part in get_args(item)[1:]])
        return " and ".join(bounds)
    if annotation == float | Table:
        return _refusal(model, name)
    return " and ".join(bounds)


def _installed(choice: Choice) -> list[str]:
    """Return the parts that come with the program, not those that an example registers during the build."""
    points = entry_points(group=f"oblique_impact.{choice.kind}")
    ours = sorted({point.name for point in points if point.dist and point.dist.name == "oblique-impact"})
    return [*choice.built_in, *(name for name in ours if name not in choice.built_in)]


def _bounds(metadata: list[Any]) -> list[str]:
    """Bounds in the order of the model, without those that only keep infinity out."""
    found = []
    for entry in metadata:
        parts = getattr(entry, "metadata", [entry])
        for part in parts:
            for sign, symbol in _SIGNS.items():
                value = getattr(part, sign, None)
                if value is not None and abs(value) < _LARGEST:
                    found.append(f"{symbol} {_number(value)}")
    return list(dict.fromkeys(found))


def _refusal(model: type[BaseModel], name: str) -> str:
    """Ask the model itself what it wants, by a value that nothing accepts."""
    try:
        model.model_validate({name: object()})
    except InputError as error:
        return str(error).partition(": should be ")[2]
    raise AssertionError(f"{name} takes anything")


def _default(section: str, name: str, field: FieldInfo) -> str:
    value = field.default
    if isinstance(value, float) and math.isnan(value):
        return "not given"
    if isinstance(value, bool):
        return f"``{str(value).lower()}``"
    if isinstance(value, str):
        return f'``"{value}"``'
    if value == ():
        return "``{}``" if field.annotation == Pairs else "``[]``"
    if isinstance(value, tuple):
        return f"``[{', '.join(_number(v) for v in value)}]``"
    return f"``{_number(value)}``"


def _number(value: float) -> str:
    """Return a number as a scenario file would have it; large round ones with an exponent."""
    text = f"{value:.10g}"
    stripped = text.rstrip("0")
    zeros = len(text) - len(stripped)
    return f"{stripped}e{zeros}" if zeros > 4 and "e" not in text and "." not in text else text


def reference() -> str:
    """Return the reference as reStructuredText: a table for each section, and the rules between keys."""
    lines: list[str] = []
    every = every_key()
    for section, model in sections():
        title = f"``[{section}]``" if section else "Without a section"
        docs = (inspect.getdoc(model) or "").split("\n")[0]
        lines += [title, "-" * len(title), "", _plain(docs) if section else "These stand first in the file.", ""]
        lines += [".. list-table::", "   :header-rows: 1", "   :widths: 22 10 24 18 36", "   :class: keys", ""]
        lines += _row(["key", "unit", "allowed", "default", "meaning"])
        for key in every:
            if key.section == section:
                name = f"``{key.name}``"
                allowed = ": ".join(part for part in (key.kind, key.allowed) if part)
                lines += _row([name, key.unit or "–", allowed, key.default, _plain(key.meaning)])
        lines.append("")
    lines += ["Rules between keys", "-" * 18, "", "What is refused, in the words of the error (… is a value).", ""]
    lines += [".. list-table::", "   :header-rows: 1", "   :widths: 28 72", "   :class: keys", ""]
    lines += _row(["key", "what is allowed"])
    for path, message in rules():
        lines += _row([f"``{path}``", _plain(message)])
    return "\n".join(lines) + "\n"


def _plain(text: str) -> str:
    """Escape what reStructuredText would take for markup; single backticks are code."""
    parts = text.split("`")
    return "".join(f"``{p}``" if n % 2 else re.sub(r"([*|_\\])", r"\\\1", p) for n, p in enumerate(parts))


def _row(cells: list[str]) -> list[str]:
    return [f"   {'* -' if n == 0 else '  -'} {cell}" for n, cell in enumerate(cells)]


class ScenarioKeys(SphinxDirective):
    """Puts the reference into a page."""

    def run(self) -> list[nodes.Node]:
        """Return the tables."""
        for module in (scenario, sections_of_keys, rules_of_keys):
            self.env.note_dependency(inspect.getsourcefile(module) or "")
        return self.parse_text_to_nodes(reference(), allow_section_headings=True)


def setup(app: Sphinx) -> dict[str, Any]:
    """Register the directive."""
    app.add_directive("scenario-keys", ScenarioKeys)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}
