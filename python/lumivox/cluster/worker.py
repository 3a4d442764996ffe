"""What workers do: one GPU each, volumes that stay, parts of images."""

from __future__ import annotations

import os
import platform
import tempfile
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import IO, Any

import numpy as np
import numpy.typing as npt

from lumivox import _native, rendering
from lumivox.cluster.parts import Part
from lumivox.cluster.shipping import Shared, attach
from lumivox.image import Image
from lumivox.rendering import Plan, Progress, Renderer

GPU_VARIABLE = "LUMIVOX_GPU"
"""Names this worker's GPU, by index or by a part of its name, where it is not to find one by itself."""


@dataclass(frozen=True)
class Traced:
    """The film of a part, and what it took."""

    part: Part
    sums: npt.NDArray[np.float32]
    complete: bool
    notes: tuple[str, ...]
    trace: float
    """Seconds of tracing."""
    total: float
    """Seconds in the worker, scene and film included."""
    worker: str
    """Process and device, for people."""


@dataclass(frozen=True)
class Failed:
    """What this worker could not do, and another may: its GPU was lost, its memory or its disk is full."""

    worker: str
    """Its address."""
    why: str


@dataclass(frozen=True)
class Made:
    """A whole image: its film's sums, or the bytes of a PNG."""

    index: int
    sums: npt.NDArray[np.float32] | None
    png: bytes | None
    complete: bool
    notes: tuple[str, ...]
    trace: float
    worker: str


class Claim:
    """A GPU of this machine that no other worker has; it is let go of when the process ends, however it ends."""

    def __init__(self) -> None:
        self._file: IO[bytes] | None = None
        self.gpu: int | str | None = self._take()

    def _take(self) -> int | str | None:
        named = os.environ.get(GPU_VARIABLE)
        if named:
            return int(named) if named.isdigit() else named
        usable = [gpu for gpu in rendering.gpus() if gpu.unsuitable is None]
        hardware = [gpu.index for gpu in usable if not gpu.software]
        if not hardware:
            # In software they share the machine's cores.
            return usable[0].index if usable else None
        for index in hardware:
            if self._lock(index):
                return index
        return hardware[os.getpid() % len(hardware)]

    def _lock(self, index: int) -> bool:
        try:
            import fcntl
        except ImportError:
            return False
        path = Path(tempfile.gettempdir()) / f"lumivox-{os.getuid()}-gpu-{index}.lock"
        try:
            # Everybody writes to that folder: what lies there under this name may be somebody else's, or a link to a file.
            file = os.fdopen(os.open(path, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW, 0o600), "r+b")
        except OSError:
            return False
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            file.close()
            return False
        self._file = file
        return True


_claim: Claim | None = None
_renderer: Renderer | None = None
_lock = threading.Lock()
_cancelled: set[str] = set()


def renderer() -> Renderer:
    """The renderer of this worker's GPU."""
    global _claim, _renderer
    with _lock:
        if _renderer is None:
            _claim = _claim or Claim()
            _renderer = Renderer(_claim.gpu)
        return _renderer


def describe() -> dict[str, Any]:
    """What this worker renders on."""
    gpu = renderer().gpu
    index = _claim.gpu if _claim else None
    said = {"index": index, "name": gpu.name, "software": gpu.software, "pid": os.getpid()}
    return {**said, "version": _native.__version__}


def cancel(job: str) -> None:
    """Stops what is rendered of a job here."""
    _cancelled.add(job)


def run(task: Callable[..., Any], job: str, *arguments: Any) -> Any:
    """Does a task. What is wrong with a scene is raised, for it is wrong everywhere; what is wrong here is told."""
    try:
        return task(job, *arguments)
    except (_native.RenderError, ValueError, TypeError):
        raise
    except Exception as error:
        from distributed import get_worker

        return Failed(get_worker().address, str(error) or type(error).__name__)


def run_part(job: str, plan: Plan, part: Part, *shared: Shared) -> Traced:
    """Renders a part of an image."""
    begin = time.perf_counter()
    request = replace(plan.request, window=part.window, first_sample=part.first_sample, samples=part.samples)
    image = _run(job, replace(attach(plan, shared), request=request, denoise=False))
    sums = image.film.sums()
    total = time.perf_counter() - begin
    return Traced(part, sums, image.complete, image.notes, image.seconds, total, _who())


def run_image(job: str, plan: Plan, index: int, as_png: bool, *shared: Shared) -> Made:
    """Renders a whole image: a frame of a film, a scene of a study."""
    image = _run(job, attach(plan, shared))
    png = _native.encode_png(image.pixels) if as_png else None
    sums = None if as_png else image.film.sums()
    return Made(index, sums, png, image.complete, image.notes, image.seconds, _who())


def _run(job: str, plan: Plan) -> Image:
    def watch(progress: Progress) -> bool:
        return job not in _cancelled

    opened = renderer()
    try:
        # A time limit is for one machine; here a job is cancelled.
        return opened.run(replace(plan, unbounded=False), watch)
    except _native.GpuError:
        # A GPU that was lost is not there for the next part either: it is opened anew.
        forget()
        raise


def forget() -> None:
    """Lets go of the renderer, so that the next part opens the GPU anew."""
    global _renderer
    with _lock:
        _renderer = None


def _who() -> str:
    return f"{platform.node()}:{os.getpid()} {renderer().gpu.name}"
