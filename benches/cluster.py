#!/usr/bin/env python3
"""Times `lumivox.cluster` on this machine: strong and weak scaling, a film, what a task costs, bytes moved, a killed worker.

    python3 benches/cluster.py --gpus 2
    python3 benches/cluster.py --workers 16 --size 192x108 --samples 64 --voxels 128 --frames 16

needs the wheel with its cluster: `pip install lumivox[cluster]`. With --gpus each worker has a GPU of its own; with --workers
they are processes that share what there is, in software mostly: that shows what the machinery costs, not what GPUs gain.
The scan is like W2 of benches/README.md: a thorax of 512 x 512 x 400 voxels of 16 bits, red muscle, white light, 1920 x 1080.
"""

from __future__ import annotations

import argparse
import json
import os
import signal
import statistics
import sys
import threading
import time
from collections.abc import Callable
from typing import Any

import numpy as np

import lumivox
from lumivox import cluster
from lumivox.cluster.job import Figures


def thorax(voxels: int) -> lumivox.Volume:
    """Body, fat, lungs with vessels, spine and ribs in HU: `voxels` along x and y, 400 / 512 of that along z."""
    depth = max(8, voxels * 400 // 512)
    z, y, x = np.ogrid[-1 : 1 : depth * 1j, -1 : 1 : voxels * 1j, -1 : 1 : voxels * 1j]
    noise = np.random.default_rng(7)
    radius = (x / 0.92) ** 2 + (y / 0.66) ** 2 + 0 * z
    hu = np.full((depth, voxels, voxels), -1000, np.int16)
    hu[radius < 1.0] = -100
    hu[radius < 0.86] = 50
    for side in (-1, 1):
        lung = ((x - 0.4 * side) / 0.3) ** 2 + (y / 0.42) ** 2 + (z / 1.1) ** 2
        hu[lung < 1.0] = -850
        vessels = np.sin(17 * x + 3 * np.sin(9 * z)) * np.sin(19 * y + 2 * np.sin(7 * x)) * np.sin(15 * z)
        hu[(lung < 0.9) & (vessels > 0.55)] = 40
    ribs = (np.abs(radius - 0.78) < 0.05) & (np.sin(16 * np.pi * (z + 0.15 * y)) > 0.45)
    hu[ribs] = 700
    hu[(x / 0.1) ** 2 + ((y - 0.42) / 0.12) ** 2 + 0 * z < 1.0] = 500
    hu += noise.normal(0, 12, hu.shape).astype(np.int16)
    # 0.7 mm in the plane, 1 mm between slices, of a whole thorax however many voxels it has.
    spacing = 512 / voxels
    return lumivox.Volume.from_array(hu, (0.7 * spacing, 0.7 * spacing, 1.0 * spacing), modality="CT")


def scene_of(volume: lumivox.Volume) -> lumivox.Scene:
    """W2's look and light: translucent red muscle, an albedo of .9, up to 100 bounces, white light."""
    opacity = [(-600, 0.0), (-200, 0.004), (-50, 0.01), (0, 0.05), (150, 0.25), (400, 0.8), (1000, 1.0)]
    color = [(-200, (0.9, 0.7, 0.4)), (0, (0.75, 0.2, 0.12)), (150, (0.8, 0.25, 0.15)), (500, (0.95, 0.9, 0.8))]
    curve = lumivox.TransferFunction(opacity, color)
    medium = lumivox.Medium(curve, density=1.4, albedo=0.9, bounces=100, filter="trilinear")
    return lumivox.Scene((lumivox.VolumeInstance(volume, medium),), lumivox.Environment("uniform"))


def camera_of(volume: lumivox.Volume, degrees: float = 14.0) -> lumivox.Camera:
    """W2's camera, turned around the patient."""
    side = max(size * step for size, step in zip(volume.shape[::-1], volume.spacing, strict=True))
    turn, distance = np.radians(degrees), 1.46 * side
    eye = (distance * np.sin(turn), 0.2 * side, distance * np.cos(turn))
    return lumivox.Camera.look_at(eye, (0, 0, 0), fov=40)


def row(name: str, workers: int, seconds: float, one: float | None, figures: Figures, work: float = 1.0) -> dict[str, Any]:
    """A line of the table; `one` is what one worker took for `work` times less."""
    speed = one * work / seconds if one else None
    told = f"{speed:.2f}" if speed else ""
    megabytes = (figures.film_bytes + figures.volume_bytes * workers) / 1e6
    print(
        f"| {name} | {workers} | {seconds:.2f} | {told} | {figures.parts} | {figures.merge * 1e3:.0f} | {megabytes:.1f} |",
        flush=True,
    )
    return {"name": name, "workers": workers, "seconds": seconds, "speed": speed, "parts": figures.parts, "megabytes": megabytes}


def timed(repeats: int, work: Callable[[], Figures]) -> tuple[float, Figures]:
    """The median of the wall-clock times, and the figures of the last."""
    times = []
    for _ in range(repeats):
        begin = time.perf_counter()
        figures = work()
        times.append(time.perf_counter() - begin)
    return statistics.median(times), figures


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--gpus", type=int, help="measure with 1, 2, 4 ... up to so many GPUs, a worker each")
    parser.add_argument("--workers", type=int, help="measure with 1, 2, 4 ... up to so many workers that share what there is")
    parser.add_argument("--size", default="1920x1080", help="width and height in pixels")
    parser.add_argument("--samples", type=int, default=4096, help="samples of the image")
    parser.add_argument("--voxels", type=int, default=512, help="voxels along x and y")
    parser.add_argument("--frames", type=int, default=24, help="frames of the film")
    parser.add_argument("--frame-samples", type=int, help="samples of a frame; default: an eighth of the image's")
    parser.add_argument("--ranges", type=int, default=1, help="ranges of samples that the image is split into")
    parser.add_argument("--repeats", type=int, default=3, help="of which the median counts")
    parser.add_argument("--json", help="writes the figures there, too")
    arguments = parser.parse_args()
    most = arguments.gpus or arguments.workers or parser.error("--gpus or --workers is needed")
    hardware = [gpu for gpu in lumivox.gpus() if gpu.unsuitable is None and not gpu.software]
    if arguments.gpus and len(hardware) < arguments.gpus:
        sys.exit(f"there are {len(hardware)} GPUs, not {arguments.gpus}; --workers measures with what there is")
    width, height = (int(side) for side in arguments.size.split("x"))
    frame_samples = arguments.frame_samples or max(1, arguments.samples // 8)
    counts = [count for count in (1, 2, 4, 8, 16, 32) if count < most] + [most]

    begin = time.perf_counter()
    volume = thorax(arguments.voxels)
    print(f"{volume!r}, made in {time.perf_counter() - begin:.1f} s", file=sys.stderr)
    scene, camera = scene_of(volume), camera_of(volume)
    cameras = [camera_of(volume, 360 * i / arguments.frames) for i in range(arguments.frames)]
    usual: Any = {"camera": camera, "size": (width, height)}
    rows: list[dict[str, Any]] = []
    one: dict[str, float] = {}

    def measure(local: cluster.Local, count: int, last: bool) -> None:
        def image(samples: int, tiles: int | None = None, ranges: int = arguments.ranges) -> Figures:
            job = cluster.submit(scene, cluster=local, tiles=tiles, ranges=ranges, **{**usual, "samples": samples})
            job.result()
            return job.figures

        def film() -> Figures:
            frames = cluster.film(scene, cameras, cluster=local, size=(width, height), samples=frame_samples)
            for _ in frames:
                pass
            return frames.figures

        # Kernels are made, and the scan is sent, by an image that does not count.
        first, figures = timed(1, lambda: image(1, tiles=4 * count))
        rows.append(row("first image, 1 sample: scan sent, kernels made", count, first, None, figures))
        seconds, figures = timed(arguments.repeats, lambda: image(arguments.samples))
        one.setdefault("strong", seconds)
        rows.append(row("strong: one image", count, seconds, one["strong"], figures))
        seconds, figures = timed(arguments.repeats, lambda: image(arguments.samples * count))
        one.setdefault("weak", seconds)
        rows.append(row("weak: samples times workers", count, seconds, one["weak"], figures, count))
        seconds, figures = timed(arguments.repeats, film)
        one.setdefault("film", seconds)
        name = f"film of {arguments.frames} frames, {frame_samples} samples"
        rows.append(row(name, count, seconds, one["film"], figures))
        if not last:
            return
        tasks = min(height, 64 * count)
        seconds, figures = timed(arguments.repeats, lambda: image(1, tiles=tasks))
        rows.append(row("many small parts: 1 sample", count, seconds, None, figures))
        idle = (seconds * count - figures.trace) / figures.parts
        print(
            f"\nA part costs {idle * 1e3:.1f} ms of a worker besides its tracing, {seconds / figures.parts * 1e3:.1f} ms of the "
            f"whole, with {figures.parts} parts of {width * height // tasks} pixels."
        )
        if count > 1:
            options = {**usual, "samples": arguments.samples}
            rows.append(killed(local, lambda: cluster.submit(scene, cluster=local, tiles=8 * count, **options)))

    print(
        f"{lumivox.gpus()[0].name}, {os.cpu_count()} cores, {width} x {height}, {arguments.samples} samples, lumivox {lumivox.__version__}\n"
    )
    print("| what | workers | s | times one | parts | merge ms | MB |\n|---|---|---|---|---|---|---|")
    for count in counts:
        # Of as many workers as are measured: no others, idle, beside them.
        with cluster.Local(count) as local:
            measure(local, count, count == most)
    if arguments.json:
        with open(arguments.json, "w") as file:
            json.dump(rows, file, indent=1)


def killed(local: cluster.Local, submit: Callable[[], cluster.Job]) -> dict[str, Any]:
    """An image of which one worker is killed half way, beside one of the same parts of which none is."""
    undisturbed = submit()
    expected = undisturbed.result().film.sums()
    job = submit()
    while job.progress.samples < job.progress.target / 2 and not job.done:
        time.sleep(0.005)
    pid = int(next(iter(job.figures.workers)).split()[0].rpartition(":")[2])
    threading.Thread(target=os.kill, args=(pid, signal.SIGKILL)).start()
    same = bool((job.result().film.sums() == expected).all())
    counted = sum(job.figures.workers.values())
    print(
        f"\nA worker killed half way: {undisturbed.figures.wall:.2f} s became {job.figures.wall:.2f} s; "
        f"{counted} of {job.figures.parts} parts counted, the image {'the same to the last bit' if same else 'ANOTHER'}."
    )
    if not same or counted != job.figures.parts:
        sys.exit("something was lost or counted twice")
    return {"name": "killed", "undisturbed": undisturbed.figures.wall, "killed": job.figures.wall}


main()
