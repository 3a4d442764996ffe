"""The manual: examples run and leave what they say, the reference is what docstrings say."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

FOLDER = Path(__file__).parent.parent
EXAMPLES = sorted((FOLDER / "examples").glob("*.py"))
# Others show that examples run.
SLOW = {"light", "noise", "opened", "turntable"}
LEFT = {
    "hello": ["hello.png"],
    "arrays": ["arrays.exr"],
    "light": ["light-lamp.png", "light-studio.png", "light-sun.png"],
    "turntable": [f"turntable-{number:03d}.png" for number in range(12)],
    "labels": ["patient.png"],
    "opened": [f"opened-{number}.png" for number in range(3)],
}


def run(program: Path, *arguments: str, folder: Path) -> subprocess.CompletedProcess[str]:
    environment = {**os.environ, "PYTHONSAFEPATH": "1"}
    command = [sys.executable, str(program), *arguments]
    return subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, timeout=300, check=False)


MARKED = [pytest.param(path, id=path.stem, marks=[pytest.mark.slow] if path.stem in SLOW else []) for path in EXAMPLES]


@pytest.mark.parametrize("example", MARKED)
def test_an_example_runs(example: Path, tmp_path: Path) -> None:
    first = example.read_text().splitlines()[0]
    assert first.startswith('"""') and first.endswith('."""'), "each starts with one line that says what it is"
    done = run(example, folder=tmp_path)
    assert done.returncode == 0, done.stderr
    assert sorted(path.name for path in tmp_path.iterdir()) == LEFT.get(example.stem, [])


def test_every_example_is_there() -> None:
    assert {"hello", "arrays", "turntable", "study", "opened"} <= {path.stem for path in EXAMPLES}
    assert LEFT.keys() | SLOW <= {path.stem for path in EXAMPLES}


def test_the_reference_is_what_docstrings_say(tmp_path: Path) -> None:
    done = run(FOLDER / "reference.py", "--check", folder=tmp_path)
    assert done.returncode == 0, f"python/reference.py writes it anew\n{done.stderr}"
