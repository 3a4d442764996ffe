"""What `lumivox render --cluster` runs: a scene on standard input, a film's sums on standard output.

A line of JSON with the scene's document, then voxels and texels as they lie in memory; back come lines of JSON (progress, or
what went wrong), the last of them with the film's shape, then its sums. The input ends when the picture is no longer wanted.
"""

from __future__ import annotations

import json
import signal
import sys
import threading
import warnings
from typing import Any, BinaryIO

import numpy as np
import numpy.typing as npt

import lumivox
from lumivox import _document, _native, cluster
from lumivox.cluster.job import Job
from lumivox.image import Display
from lumivox.rendering import Plan, Request

LOOK = 0.25
"""Seconds between two words about progress."""


def read(source: BinaryIO) -> tuple[str, Plan]:
    """The scheduler's address, and what it is to render."""
    header: dict[str, Any] = json.loads(source.readline())
    if header["version"] != lumivox.__version__:
        raise lumivox.LumivoxError(
            f"the command is Lumivox {header['version']}, Python's is {lumivox.__version__}; install the same version of both"
        )
    volumes = [_volume(source, said) for said in header["volumes"]]
    grids = [_labels(source, said) for said in header["labels"]]
    depths = [_volume(source, said) for said in header["depths"]]
    shape = header["map"]
    environment_map = None if shape is None else _native.EnvironmentMap(_array(source, "float32", shape))
    parts: list[_document.Part] = [
        (
            volume,
            None if said["labels"] is None else grids[said["labels"]],
            None if said["depth"] is None else depths[said["depth"]],
        )
        for volume, said in zip(volumes, header["parts"], strict=True)
    ]
    words = header["scene"]
    camera = lumivox.Camera(words["camera"]["world_from_camera"], words["camera"]["fov"])
    width, height = header["size"]
    request = Request((width, height), header["samples"], seed=header["seed"], guides=header["guides"])
    return header["address"], Plan(_document.scene(words, parts, environment_map), camera, request, Display(), False, False)


def _volume(source: BinaryIO, said: dict[str, Any]) -> _native.Volume:
    return lumivox.Volume._from_stored(
        _array(source, said["type"], said["shape"]),
        said["slope"],
        said["intercept"],
        np.array(said["patient_from_voxel"]),
        said["modality"],
        said["unit"],
    ).native


def _labels(source: BinaryIO, said: dict[str, Any]) -> _native.Labels:
    values, rows = _array(source, "uint8", said["shape"]), said["patient_from_voxel"]
    entries = [(value, name, color) for value, name, color in said["entries"]]
    numbers = [(number, value) for number, value in said["numbers"]]
    return _native.Labels.from_array(values, rows, entries, True, None, numbers)


def _array(source: BinaryIO, kind: str, shape: list[int]) -> npt.NDArray[Any]:
    dtype = np.dtype(kind)
    size = int(np.prod(shape)) * dtype.itemsize
    data = source.read(size)
    if len(data) != size:
        raise EOFError("the scene ended too early")
    return np.frombuffer(data, dtype).reshape(shape)


def say(**words: Any) -> None:
    """A line for whoever reads."""
    sys.stdout.buffer.write(json.dumps(words).encode() + b"\n")
    sys.stdout.buffer.flush()


def watch(job: Job) -> None:
    """Waits for the input's end, which takes the job back."""
    sys.stdin.buffer.read()
    if not job.done:
        job.cancel()


def main() -> int:
    """Renders what comes in."""
    # Ctrl-C is for whoever reads: it ends our input.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        address, planned = read(sys.stdin.buffer)
        with warnings.catch_warnings(record=True) as told:
            warnings.simplefilter("always", UserWarning)
            job = cluster._submit(cluster.client_of(address), planned, None, None)
        for note in told:
            say(note=str(note.message))
        threading.Thread(target=watch, args=(job,), daemon=True).start()
        while not job.wait(LOOK):
            at = job.progress
            # JSON has no infinity.
            say(samples=at.samples, target=at.target, elapsed=at.elapsed, left=min(at.left, 1e9))
        try:
            image, complete = job.result(), True
        except cluster.Cancelled:
            image, complete = job.partial(), False
    except lumivox.GpuError as error:
        say(error=str(error), kind="gpu")
        return 1
    except (lumivox.LumivoxError, OSError, EOFError, ValueError) as error:
        say(error=str(error), kind="failure")
        return 1
    sums = image.film.sums()
    say(film=sums.shape[:3], complete=complete)
    sys.stdout.buffer.write(sums.tobytes())
    sys.stdout.buffer.flush()
    return 0


if __name__ == "__main__":
    # Not by returning: a thread that still reads our input would be waited for.
    import os

    from lumivox.cluster import local

    code = main()
    sys.stdout.flush()
    # Which what is registered for the end would have done.
    local.end()
    os._exit(code)
