"""Writes docs/python.md, the reference of the package, from its docstrings: `python reference.py [--check]`."""

from __future__ import annotations

import ast
import dataclasses
import difflib
import inspect
import re
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import lumivox
from lumivox import cluster, interop, widget

TARGET = Path(__file__).parent.parent / "docs" / "python.md"

MODULES: list[tuple[ModuleType, list[str]]] = [
    (lumivox, [name for name in lumivox.__all__ if name != "__version__"]),
    (cluster, cluster.__all__),
    (widget, ["View"]),
    (interop, ["from_sitk", "to_sitk", "from_nibabel", "to_nibabel", "from_xarray", "to_xarray", "from_monai", "to_monai"]),
]


def words(thing: Any, where: str) -> str:
    """A docstring as Markdown; none is a mistake."""
    text = inspect.getdoc(thing)
    if not text:
        raise SystemExit(f"{where} has no docstring")
    return clean(text)


def clean(text: str | None) -> str:
    """Words of a docstring as Markdown."""
    return re.sub(r":\w+:`~?([^`]+)`", r"`\1`", text or "").replace("``", "`")


def attributes(kind: type) -> dict[str, str]:
    """What is written below the fields of a dataclass."""
    source = inspect.getsource(kind)
    return dict(re.findall(r'^    (\w+): [^\n]*\n    """(.*?)"""', source, re.MULTILINE | re.DOTALL))


def signature(thing: Any) -> str:
    """Its arguments, without where types live."""
    try:
        # Options are listed once, in words.
        text = str(getattr(thing, "plain_signature", None) or inspect.signature(thing))
    except (TypeError, ValueError):
        return ""
    # Of a default that is an object, where it lies in memory says nothing.
    return re.sub(r"\b(?:npt|np|lumivox\.\w+|typing)\.", "", text).replace("'", "").replace("<factory>", "...")


def members(kind: type) -> list[tuple[str, Any]]:
    """Its own public methods and properties, in the order of the source."""
    return [
        (name, member)
        for name, member in vars(kind).items()
        if not name.startswith("_") and (callable(member) or isinstance(member, property | classmethod | staticmethod))
    ]


def entry(module: ModuleType, name: str) -> list[str]:
    """The reference of one name."""
    thing = getattr(module, name)
    where = f"{module.__name__}.{name}"
    if not inspect.isclass(thing):
        return [f"### `{where}{signature(thing)}`", words(thing, where)]
    if issubclass(thing, BaseException):
        return [f"### `{where}`", words(thing, where)]
    shown = signature(thing) if dataclasses.is_dataclass(thing) else ""
    lines = [f"### `{where}{shown}`", words(thing, where)]
    if told := attributes(thing):
        lines.append("\n".join(f"- `{field}`: {' '.join(text.split())}" for field, text in told.items()).replace("``", "`"))
    for member_name, member in members(thing):
        inner = member.fget if isinstance(member, property) else getattr(member, "__func__", member)
        arguments = "" if isinstance(member, property) else signature(inner)
        lines += [f"#### `{member_name}{arguments}`", words(inner, f"{where}.{member_name}")]
    return lines


def of_source(path: Path, name: str) -> list[str]:
    """The reference of a module that needs what is not there, as its source says it: the module's words and a class's."""
    tree = ast.parse(path.read_text())
    found = next(node for node in tree.body if isinstance(node, ast.ClassDef) and node.name == name)
    module = f"lumivox.{path.stem}"
    lines = [f"## {module}", clean(ast.get_docstring(tree)), f"### `{module}.{name}`", clean(ast.get_docstring(found))]
    for node in found.body:
        if isinstance(node, ast.FunctionDef) and not node.name.startswith("_") and node.name.islower():
            arguments = ast.unparse(node.args)
            lines += [f"#### `{node.name}({arguments}) -> {ast.unparse(node.returns or ast.Constant(None))}`"]
            lines += [clean(ast.get_docstring(node))]
    return lines


def reference() -> str:
    """All of it."""
    lines = ["# Lumivox for Python: reference", "Made from the docstrings by `python/reference.py`. " + words(lumivox, "lumivox")]
    for module, names in MODULES:
        lines.append(f"## {module.__name__}")
        if module is not lumivox:
            lines.append(words(module, module.__name__))
        for name in names:
            lines += entry(module, name)
    lines += of_source(Path(lumivox.__file__).with_name("napari.py"), "View")
    return "\n\n".join(lines) + "\n"


def main() -> int:
    """Writes it, or fails where it is not what would be written."""
    made = reference()
    if "--check" not in sys.argv:
        TARGET.write_text(made)
        return 0
    there = TARGET.read_text() if TARGET.exists() else ""
    sys.stderr.writelines(
        list(difflib.unified_diff(there.splitlines(True), made.splitlines(True), "docs/python.md", "made"))[:40]
    )
    return int(there != made)


if __name__ == "__main__":
    sys.exit(main())
