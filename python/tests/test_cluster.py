"""The cluster: the single machine's image, whoever rendered what and whoever died meanwhile. Workers on software Vulkan."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import lumivox
from lumivox import cluster
from lumivox.cluster import shipping, worker
from lumivox.cluster.merge import Merge
from lumivox.cluster.parts import LEAST_TILE, equal_tiles, split, usual_ranges, usual_tiles
from lumivox.rendering import Gpu, Options, plan

OPTIONS: Options = {"preset": "ct-bone", "size": (48, 40), "samples": 16, "pass_samples": 4, "layers": True}


@pytest.fixture(scope="module")
def local() -> Iterator[cluster.Local]:
    """Two workers of this machine."""
    with cluster.Local(2) as workers:
        yield workers


@pytest.fixture(scope="module")
def single(head: lumivox.Volume) -> np.ndarray:
    """The sums of one machine."""
    return lumivox.render(head, **OPTIONS).film.sums()


@pytest.mark.parametrize(
    ("size", "samples", "tiles", "ranges", "passes"),
    [((7, 5), 10, 3, 2, 4), ((1, 1), 1, 9, 9, 64), ((64, 64), 512, 8, 4, 64), ((5, 3), 130, 2, 100, 64)],
)
def test_parts_hold_each_sample_of_each_pixel_once(
    size: tuple[int, int], samples: int, tiles: int, ranges: int, passes: int
) -> None:
    parts = split(size, samples, equal_tiles(size, tiles), ranges, passes)
    count = np.zeros((size[1], size[0], samples), int)
    for part in parts:
        x, y, width, height = part.window
        count[y : y + height, x : x + width, part.first_sample : part.samples] += 1
        assert part.first_sample % passes == 0
    assert (count == 1).all()
    assert [part.index for part in parts] == list(range(len(parts)))
    assert [part.range for part in parts] == sorted(part.range for part in parts), "the first samples come first"


@pytest.mark.parametrize("workers", [1, 2, 16, 1000])
@pytest.mark.parametrize("size", [(1920, 1080), (64, 64), (3, 1), (1, 3000)])
def test_tiles_get_smaller_and_keep_workers_busy(size: tuple[int, int], workers: int) -> None:
    for software in (True, False):
        heights = usual_tiles(size, workers, software)
        assert sum(heights) == size[1] and min(heights) >= 1
        if not software and size[0] * size[1] >= LEAST_TILE:
            assert min(heights) * size[0] >= LEAST_TILE / 2 - size[0]
        assert heights[0] <= max(heights[-1], size[1] / workers / 2 + 2, LEAST_TILE / size[0] * 2)
        parts = len(heights) * usual_ranges(len(heights), workers)
        assert parts >= 3 * workers or workers == 1


def test_what_is_said_of_tiles_is_so() -> None:
    assert f"of {LEAST_TILE:,} pixels at least" in (cluster.render.__doc__ or "")


def test_the_order_of_parts_changes_nothing_and_none_counts_twice() -> None:
    parts = split((4, 6), 12, [3, 1, 2], 3, 4)
    random = np.random.default_rng(1)
    films = [random.random((2, part.window[3], 4, 4), np.float32) for part in parts]
    expected = None
    for _ in range(5):
        merge = Merge((4, 6), 2, parts)
        for index in random.permutation(len(parts)):
            assert merge.add(parts[index], films[index])
            assert not merge.add(parts[index], films[index])
            sums = merge.partial()
        assert merge.done
        np.testing.assert_array_equal(sums, merge.sums)
        expected = merge.sums if expected is None else expected
        np.testing.assert_array_equal(merge.sums, expected)


@pytest.mark.parametrize(("tiles", "ranges"), [(1, 1), (5, 1), (1, 4), (3, 4), (40, 1)])
def test_the_image_is_the_single_machines_to_the_last_bit(
    local: cluster.Local, head: lumivox.Volume, single: np.ndarray, tiles: int, ranges: int
) -> None:
    # One range, or ranges of one pass each.
    image = cluster.render(head, cluster=local, tiles=tiles, ranges=ranges, **OPTIONS)
    assert image.complete and image.min_samples == 16
    np.testing.assert_array_equal(image.film.sums(), single)


def test_ranges_of_several_passes_differ_by_rounding_alone(
    local: cluster.Local, head: lumivox.Volume, single: np.ndarray
) -> None:
    sums = cluster.render(head, cluster=local, tiles=2, ranges=2, **OPTIONS).film.sums()
    np.testing.assert_allclose(sums, single, rtol=1e-5, atol=1e-5)
    np.testing.assert_array_equal(sums[1, ..., 2], single[1, ..., 2])
    # And not by who did what.
    again = cluster.render(head, cluster=local, tiles=5, ranges=2, **OPTIONS).film.sums()
    np.testing.assert_array_equal(again, sums)


def test_volumes_are_sent_once_and_known_by_what_they_hold(local: cluster.Local, head: lumivox.Volume) -> None:
    def sent(volume: lumivox.Volume) -> int:
        options: Options = {**OPTIONS, "size": (8, 8), "samples": 4}
        job = cluster.submit(volume, cluster=local, tiles=4, **options)
        job.result()
        return job.figures.volume_bytes

    other = lumivox.Volume.from_array(head.array + np.uint16(1), head.spacing, modality="CT")
    same = lumivox.Volume.from_array(head.array + np.uint16(1), head.spacing, modality="CT")
    assert sent(other) == other.array.nbytes
    assert sent(other) == 0
    assert sent(same) == 0, "another object with the same content"
    assert shipping.key_of(other) == shipping.key_of(same) != shipping.key_of(head)
    moved = lumivox.Volume.from_array(other.array, head.spacing, (1, 2, 3), modality="CT")
    assert shipping.key_of(moved) != shipping.key_of(other)


def test_labels_clip_shapes_and_depths_travel_with_the_scan_once(local: cluster.Local, head: lumivox.Volume) -> None:
    array = (head.values[::2, ::2, ::2] > 200).astype(np.uint8)
    labels = lumivox.Labels.from_array(array, tuple(2 * mm for mm in head.spacing), head.origin, names={1: "bone"})
    border = lumivox.TransferFunction([(0, 1.0)], [(0, "#ff4020")])
    curve = lumivox.TransferFunction([(-500, 0.0), (300, 0.6)], [(0, (1, 0.8, 0.6))], gradients=[(40.0, border)])
    scan = head.segment()
    options: Options = {
        "size": (24, 20),
        "samples": 8,
        "pass_samples": 2,
        "transfer_function": curve,
        "labels": labels,
        "label": {"bone": "preset:ct-bone,uncut", "unlabelled": lumivox.LabelStyle(opacity=0.5, color="#80a0ff")},
        "clip_shape": [lumivox.ClipShape.plane((0, 0, 10), (0, 0.2, -1)), lumivox.ClipShape.sphere((0, 0, 60), 40).invert()],
        "peel_mm": 4.0,
    }
    single = lumivox.render(scan, **options)
    assert 0.05 < single.alpha.mean() < 0.95
    job = cluster.submit(scan, cluster=local, tiles=5, ranges=1, **options)
    np.testing.assert_array_equal(job.result().film.sums(), single.film.sums())
    depth = scan.skin_depth()
    assert depth is not None
    assert job.figures.volume_bytes in (
        labels.array.nbytes + depth.array.nbytes,
        head.array.nbytes + labels.array.nbytes + depth.array.nbytes,
    )
    # In software long paths are put aside and taken up again: then a pass is added up in pieces, and ranges round otherwise.
    ranges = cluster.render(scan, cluster=local, tiles=2, ranges=4, **options).film.sums()
    np.testing.assert_allclose(ranges, single.film.sums(), rtol=1e-5, atol=1e-5)
    np.testing.assert_array_equal(ranges[1, ..., 2], single.film.sums()[1, ..., 2])
    # What was found in the scan has done its work, and stays here.
    _, shared = shipping.detach(plan(scan, options))
    assert [one.content.labels for one in shared if isinstance(one.content, lumivox.Volume)] == [None, None]
    # Other labels of the same content, shapes elsewhere: nothing is sent again.
    same = lumivox.Labels.from_array(array, labels.spacing, head.origin, names={1: "bone"})
    moved: Options = {**options, "labels": same, "clip_shape": lumivox.ClipShape.plane((0, 0, 20), (0, 0, -1)), "peel_mm": 9.0}
    again = cluster.submit(scan, cluster=local, tiles=2, ranges=1, **moved)
    np.testing.assert_array_equal(again.result().film.sums(), lumivox.render(scan, **moved).film.sums())
    assert again.figures.volume_bytes == 0
    named = lumivox.Labels.from_array(array, labels.spacing, head.origin, names={1: "skull"})
    assert shipping.key_of(labels) == shipping.key_of(same) != shipping.key_of(named)


def pids(local: cluster.Local) -> list[int]:
    return [one["pid"] for one in cluster.workers(local).values()]


@pytest.mark.parametrize("count", [2, 1])
def test_a_worker_that_dies_costs_its_part_alone(head: lumivox.Volume, count: int) -> None:
    # With one worker the scan dies with it, and is sent again to the one that takes its place.
    options: Options = {**OPTIONS, "samples": 32}
    expected = lumivox.render(head, **options).film.sums()
    with cluster.Local(count) as local:
        before = pids(local)
        job = cluster.submit(head, cluster=local, tiles=8, ranges=8, **options)
        deadline = time.monotonic() + 60
        while job.progress.samples < 2 and time.monotonic() < deadline:
            time.sleep(0.01)
        assert not job.done, "there is something to lose"
        # Of those that have done some.
        victim = int(next(iter(job.figures.workers)).split()[0].rpartition(":")[2])
        assert victim in before
        os.kill(victim, signal.SIGKILL)
        image = job.result()
        assert sum(job.figures.workers.values()) == 64, "each part counts once"
        # Who died had done some, and others the rest.
        assert len({name.split()[0] for name in job.figures.workers}) >= 2
        assert (job.figures.retried > 0) == (count == 1)
        local.client.wait_for_workers(count, timeout=60)
        assert victim not in pids(local)
    np.testing.assert_array_equal(image.film.sums(), expected)


def test_a_part_of_the_image_is_there_while_it_runs_and_a_cancel_ends_it(local: cluster.Local, head: lumivox.Volume) -> None:
    job = cluster.submit(head, cluster=local, tiles=1, ranges=500, **{**OPTIONS, "samples": 2000})
    deadline = time.monotonic() + 60
    while job.progress.samples < 4 and time.monotonic() < deadline:
        time.sleep(0.02)
    partial = job.partial()
    assert not partial.complete and 4 <= partial.min_samples < 2000 and partial.alpha.max() > 0
    progress = job.progress
    assert progress.target == 2000 and 0 < progress.left < 1e9
    job.cancel()
    begin = time.monotonic()
    with pytest.raises(cluster.Cancelled, match="cancelled"):
        job.result()
    assert time.monotonic() - begin < 20
    assert job.partial().min_samples >= 4
    # A long part, too, is stopped in the middle.
    job = cluster.submit(head, cluster=local, tiles=1, **{**OPTIONS, "samples": 1 << 22, "pass_samples": 4})
    time.sleep(1.0)
    job.cancel()
    with pytest.raises(cluster.Cancelled):
        job.result()
    # And the workers are there for the next.
    begin = time.monotonic()
    assert cluster.render(head, cluster=local, **{**OPTIONS, "samples": 4}).complete
    assert time.monotonic() - begin < 20


def test_progress_is_told_and_cancels(local: cluster.Local, head: lumivox.Volume) -> None:
    told: list[lumivox.Progress] = []

    def stop(progress: lumivox.Progress) -> bool:
        told.append(progress)
        return len(told) < 3

    with pytest.raises(cluster.Cancelled):
        cluster.render(head, cluster=local, tiles=1, ranges=1000, progress=stop, **{**OPTIONS, "samples": 4000})
    assert len(told) == 3


def test_a_film_is_split_by_frames(local: cluster.Local, head: lumivox.Volume, tmp_path: Path) -> None:
    scene = lumivox.Scene.of(head, preset="ct-bone")
    options: Options = {"size": (24, 24), "samples": 4, "pass_samples": 4}
    cameras = [lumivox.Camera.framing(scene, azimuth, size=(24, 24)) for azimuth in (0, 90, 180, 270)]
    frames = dict(cluster.film(scene, cameras, cluster=local, **options))
    assert sorted(frames) == [0, 1, 2, 3]
    for number, camera in enumerate(cameras):
        own = lumivox.render(scene, camera=camera, **options)
        np.testing.assert_array_equal(frames[number].film.sums(), own.film.sums())
    pattern = tmp_path / "frame-{:02d}.png"
    saved = dict(cluster.film(scene, cameras, cluster=local, save=pattern, **options))
    assert sorted(path.name for path in tmp_path.iterdir()) == [f"frame-{number:02d}.png" for number in range(4)]
    assert Path(saved[2]).read_bytes() == frames[2]._repr_png_()
    with pytest.raises(ValueError, match="a name for each frame is needed"):
        cluster.film(scene, cameras, cluster=local, save="frame.png", **options)


def test_a_study_is_split_by_scenes(local: cluster.Local, head: lumivox.Volume) -> None:
    options: Options = {"size": (24, 24), "samples": 4, "pass_samples": 4}
    scenes = [lumivox.Scene.of(head, preset="ct-bone", density=density) for density in (0.1, 0.5, 2.0)]
    study = cluster.study(scenes, cluster=local, **options)
    images = dict(study)
    for number, scene in enumerate(scenes):
        np.testing.assert_array_equal(images[number].film.sums(), lumivox.render(scene, **options).film.sums())
    means = [images[number].alpha.mean() for number in range(3)]
    assert means == sorted(means) and means[0] < means[2]
    assert study.figures.volume_bytes <= head.array.nbytes, "one scan for all"


def test_errors_come_back_in_the_words_of_all_hosts(
    local: cluster.Local, head: lumivox.Volume, monkeypatch: pytest.MonkeyPatch
) -> None:
    planned = plan(head, {**OPTIONS, "samples": 4})
    lost = replace(planned, camera=replace(planned.camera, fov=200.0))
    with pytest.raises(lumivox.RenderError, match="the field of view between 0 and 180 degrees"):
        dict(cluster.study([lost], cluster=local))
    with pytest.raises(ValueError, match="time is for one machine"):
        cluster.render(head, cluster=local, time=5.0)
    monkeypatch.setattr(cluster, "CONNECT", 1.0)
    with pytest.raises(ConnectionError, match="no Dask scheduler answers at tcp://127.0.0.1:9"):
        cluster.render(head, cluster="tcp://127.0.0.1:9", **OPTIONS)


def test_each_worker_has_a_gpu_of_its_own(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    listed = [Gpu(index, "H200", "", "Vulkan", False, None) for index in range(3)] + [Gpu(3, "soft", "", "Vulkan", True, None)]
    listed[1] = replace(listed[1], unsuitable="too old")
    monkeypatch.setattr(worker.rendering, "gpus", lambda: listed)
    monkeypatch.setattr(worker.tempfile, "gettempdir", lambda: str(tmp_path))
    monkeypatch.delenv(worker.GPU_VARIABLE, raising=False)
    claims = [worker.Claim(), worker.Claim()]
    assert [claim.gpu for claim in claims] == [0, 2]
    assert worker.Claim().gpu in (0, 2), "more workers than GPUs share them"
    del claims[0]
    assert worker.Claim().gpu == 0, "one that ended has let go of its own"
    monkeypatch.setenv(worker.GPU_VARIABLE, "2")
    assert worker.Claim().gpu == 2


def test_the_machines_own_cluster_needs_no_set_up(python: str, tmp_path: Path) -> None:
    # A script without `if __name__ == "__main__"`, which workers that were forked would run again.
    script = tmp_path / "script.py"
    script.write_text(
        "import lumivox\nfrom lumivox import cluster\n"
        "image = cluster.render(lumivox.phantom('cube', 16), preset='plain', size=(16, 16), samples=4)\n"
        "assert image.complete and image.alpha.max() > 0\n"
        "print(len(cluster.workers()))\n"
    )
    flags = ["-P"] if sys.version_info >= (3, 11) else []
    done = subprocess.run([python, *flags, str(script)], capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr
    hardware = [gpu for gpu in lumivox.gpus() if gpu.unsuitable is None and not gpu.software]
    assert int(done.stdout) == (len(hardware) or len(os.sched_getaffinity(0)))


def test_the_command_renders_on_a_cluster(
    local: cluster.Local, head_folder: Path, command: str, python: str, tmp_path: Path
) -> None:
    # `-P` and not the folder beside the tests, which is no package that is installed.
    environment = {**os.environ, **keys(local), "LUMIVOX_PYTHON": python, "PYTHONSAFEPATH": "1"}
    address = local.client.scheduler.address

    def run(name: str, *more: str, samples: int = 4, **other: str) -> subprocess.CompletedProcess[str]:
        looks = ["--preset", "ct-bone", "--environment", "gradient", "--light", "sun:40,30,1.5,2", "--background", "environment"]
        usual = ["--size", "48x40", "--samples", str(samples), "--seed", "3", "--azimuth", "20", "-o", name]
        arguments = [command, "render", str(head_folder), *looks, *usual, *more]
        return subprocess.run(
            arguments, env={**environment, **other}, cwd=tmp_path, capture_output=True, text=True, timeout=120, check=False
        )

    assert run("own.png").returncode == 0
    done = run("cluster.png", "--cluster", address)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "own.png").read_bytes() == (tmp_path / "cluster.png").read_bytes()
    assert f"tracing on the cluster at {address}" in done.stderr

    opened = ["--labels", "found", "--label", "body=color:#c04030,opacity:0.3", "--label", "air outside=hide"]
    opened += ["--clip-shape", "!plane:0,0,0,0,0.3,1"]
    assert run("own.png", *opened).returncode == 0
    done = run("cluster.png", "--cluster", address, *opened)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "own.png").read_bytes() == (tmp_path / "cluster.png").read_bytes()

    # All that scenes in files know goes along: a look that peels while it is seen, and lamps.
    lamp = {"position": [200, 300, 400], "intensity": [0.3, 0.3, 0.1], "radius": 5, "falloff": {"relative": {"range": 2000}}}
    spot = {"kind": "spot", "lamp": lamp, "direction": [-2, -3, -4], "half_angle": 30, "cone": {"inner_half_angle": 10}}
    entry = {"scan": {"files": [str(head_folder)]}, "look": {"preset": "ct-skin"}, "peel": 4}
    (tmp_path / "scene.json").write_text(json.dumps({"lumivox_scene": 1, "volumes": [entry], "lights": [spot]}))
    for name, more in (("own.png", []), ("cluster.png", ["--cluster", address])):
        asked = [command, "render", "scene.json", "--size", "48x40", "--samples", "4", "-o", name, *more]
        shown = subprocess.run(asked, env=environment, cwd=tmp_path, capture_output=True, text=True, timeout=120, check=False)
        assert shown.returncode == 0, shown.stderr
    assert (tmp_path / "own.png").read_bytes() == (tmp_path / "cluster.png").read_bytes()

    missing = run("a.png", "--cluster", address, LUMIVOX_PYTHON="no-such-python")
    assert missing.returncode == 1 and "--cluster needs Python with Lumivox" in missing.stderr
    bare = run(
        "a.png", "--cluster", address, PYTHONPATH=str(tmp_path), PYTHONNOUSERSITE="1", LUMIVOX_PYTHON=bare_python(tmp_path)
    )
    assert bare.returncode == 1 and "pip install 'lumivox[cluster]'" in bare.stderr and "No module named" in bare.stderr
    silent = run("a.png", "--cluster", "tcp://127.0.0.1:9")
    assert silent.returncode == 1 and "no Dask scheduler answers at tcp://127.0.0.1:9" in silent.stderr
    stranger = run("a.png", "--cluster", address, LUMIVOX_CREDENTIALS="")
    assert stranger.returncode == 1 and "LUMIVOX_CREDENTIALS names the folder of its key" in stranger.stderr
    both = run("a.png", "--cluster", address, "--gpu", "x")
    assert both.returncode == 2
    assert not (tmp_path / "a.png").exists()


def keys(local: cluster.Local) -> dict[str, str]:
    """What lets a program of its own in."""
    return {"LUMIVOX_CREDENTIALS": str(local.credentials)}


def bare_python(folder: Path) -> str:
    """An interpreter that has no Lumivox."""
    bare = folder / "bare-python"
    bare.write_text(f'#!/bin/sh\nexec "{sys.executable}" -I -S "$@"\n')
    bare.chmod(0o755)
    return str(bare)


def test_ctrl_c_keeps_what_the_cluster_has(
    local: cluster.Local, head_folder: Path, command: str, python: str, tmp_path: Path
) -> None:
    environment = {**os.environ, **keys(local), "LUMIVOX_PYTHON": python, "PYTHONSAFEPATH": "1"}
    arguments = ["--size", "64x200", "--samples", "2000", "-o", "part.png", "--cluster", local.client.scheduler.address]
    process = subprocess.Popen(
        [command, "render", str(head_folder), *arguments], env=environment, cwd=tmp_path, stderr=subprocess.PIPE, text=True
    )
    time.sleep(4.0)
    process.send_signal(signal.SIGINT)
    _, said = process.communicate(timeout=60)
    assert process.returncode == 130, said
    # Parts that had ended by then are in the picture, or there was none.
    assert ("What there was is in" in said) == (tmp_path / "part.png").exists(), said
