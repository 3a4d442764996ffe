"""Writes the licence texts of all that is in the wheel: `python licenses.py`, before it is built.

Those of Lumivox are copied beside pyproject.toml, and those of the crates that are linked into it, C and C++ among them,
are collected from their sources in THIRD-PARTY-LICENSES.txt.
"""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

HERE = Path(__file__).parent
OWN = ("LICENSE-APACHE", "LICENSE-MIT")
TARGET = HERE / "THIRD-PARTY-LICENSES.txt"
TEXTS = re.compile(r"(LICEN[CS]E|COPYING|NOTICE|COPYRIGHT|UNLICENSE)([-._].*)?", re.IGNORECASE)
CODE = (".rs", ".c", ".cpp", ".h", ".py", ".toml")


def system() -> str:
    """What the library is built for: this system, or CARGO_BUILD_TARGET."""
    host = re.search(r"^host: (\S+)", subprocess.check_output(["rustc", "-vV"], text=True), re.MULTILINE)
    assert host is not None, "rustc names its host"
    return os.environ.get("CARGO_BUILD_TARGET") or host[1]


def metadata(target: str) -> dict[str, Any]:
    """What cargo knows of the packages, as they are built for a system."""
    arguments = ["cargo", "metadata", "--format-version", "1", "--locked", "--filter-platform", target]
    found: dict[str, Any] = json.loads(subprocess.check_output([*arguments, "--manifest-path", HERE / "Cargo.toml"]))
    return found


def linked(found: dict[str, Any], root: str) -> list[dict[str, Any]]:
    """The packages that are linked into one of the workspace's, its own left out."""
    packages = {one["id"]: one for one in found["packages"]}
    nodes = {one["id"]: one for one in found["resolve"]["nodes"]}
    waiting = [one["id"] for one in found["packages"] if one["name"] == root]
    seen = set(waiting)
    while waiting:
        for link in nodes[waiting.pop()]["deps"]:
            # Neither what builds it, nor what tests it.
            if link["pkg"] not in seen and any(kind["kind"] is None for kind in link["dep_kinds"]):
                seen.add(link["pkg"])
                waiting.append(link["pkg"])
    return [packages[one] for one in seen if packages[one]["source"] is not None]


def works() -> list[dict[str, Any]]:
    """All that is in the wheel, each once: of the library, and of the program for browsers where that is there."""
    found = linked(metadata(system()), "lumivox-python")
    if (HERE / "lumivox" / "web").is_dir():
        found += linked(metadata("wasm32-unknown-unknown"), "lumivox-js")
    by_name = {(one["name"], one["version"]): one for one in found}
    return [by_name[name] for name in sorted(by_name)]


def texts(package: dict[str, Any]) -> list[str]:
    """Licence texts in a package's sources, each once; those of C sources lie in folders of their own."""
    folder = Path(package["manifest_path"]).parent
    files = [file for file in sorted(folder.rglob("*")) if TEXTS.fullmatch(file.name) and file.suffix not in CODE]
    read = (file.read_text(encoding="utf-8", errors="replace").strip() for file in files if file.is_file())
    return list(dict.fromkeys(text for text in read if text))


def main() -> int:
    """Writes them."""
    for name in OWN:
        shutil.copyfile(HERE.parent / name, HERE / name)
    parts, users = [], {}
    for package in works():
        title = f"{package['name']} {package['version']}: {package['license'] or 'see below'}"
        authors = ", ".join(re.sub(r"\s*<[^>]*>", "", author) for author in package["authors"])
        where = package["repository"] or package["homepage"] or ""
        parts.append("\n".join(line for line in (title, authors, where) if line))
        for text in texts(package):
            users.setdefault(text, []).append(f"{package['name']} {package['version']}")
    head = "What is compiled in this package has parts of these works.\n\n" + "\n\n".join(parts)
    rule = "\n\n" + "=" * 80 + "\n"
    bodies = [f"{rule}{', '.join(names)}\n\n{text}" for text, names in users.items()]
    TARGET.write_text(head + "".join(bodies) + "\n", encoding="utf-8")
    print(f"{len(parts)} works, {len(users)} texts: {TARGET.name}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
