"""What the tests share: small scans, and the command that pictures are compared with."""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

import lumivox


@pytest.fixture(scope="session", autouse=True)
def hears_ctrl_c() -> Iterator[None]:
    """A shell starts what runs in its background deaf to Ctrl-C, and tests of it would wait forever."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.fixture(scope="session")
def head() -> lumivox.Volume:
    """A head as a CT sees it, 48 voxels along each side."""
    return lumivox.phantom("head", 48)


@pytest.fixture(scope="session")
def head_folder(head: lumivox.Volume, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The head as a DICOM series."""
    folder = tmp_path_factory.mktemp("scans") / "head"
    assert lumivox.write_dicom_series(head, folder) == 48
    return folder


@pytest.fixture(scope="session")
def command() -> str:
    """The command `lumivox`, which `script/python` builds."""
    return os.environ["LUMIVOX_COMMAND"]


@pytest.fixture(scope="session")
def python() -> str:
    """The interpreter of these tests, for processes of their own."""
    return sys.executable


def white(density: float = 0.05, **medium: object) -> lumivox.Medium:
    """A medium that scatters all light, the same for all values."""
    curve = lumivox.TransferFunction([(0.0, 1.0)], [(0.0, (1.0, 1.0, 1.0))])
    return lumivox.Medium(curve, density, bounces=1000, **medium)  # type: ignore[arg-type]


def block(n: int = 16) -> lumivox.Volume:
    """A homogeneous cube of n voxels of 4 mm."""
    return lumivox.Volume.from_array(np.full((n, n, n), 100, np.uint8), spacing=(4.0, 4.0, 4.0))
