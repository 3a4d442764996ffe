"""Images: physics, the command's pictures, layers, devices, threads."""

from __future__ import annotations

import os
import pickle
import signal
import subprocess
import sys
import threading
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import block, white

import lumivox
from lumivox import rendering

SIZE = (32, 32)


def furnace(**options: object) -> lumivox.Image:
    scene = lumivox.Scene((lumivox.VolumeInstance(block(), white()),), lumivox.Environment("uniform"))
    return lumivox.render(scene, size=SIZE, samples=8, **options)  # type: ignore[arg-type]


def test_a_white_furnace_is_one() -> None:
    # Whatever enters comes out again: with what shines from behind, each pixel is as bright as the light.
    image = furnace()
    assert image.alpha.max() == 1.0 and 0.2 < image.alpha.mean() < 0.95
    seen = image.radiance + (1.0 - image.alpha)[..., None]
    np.testing.assert_allclose(seen, 1.0, atol=1e-5)
    half = lumivox.Environment("uniform", color=(0.5, 0.25, 1.0))
    coloured = lumivox.render(replace(image.scene, environment=half), size=SIZE, samples=8)
    np.testing.assert_allclose(coloured.radiance, image.alpha[..., None] * [0.5, 0.25, 1.0], atol=1e-5)


def test_a_slab_lets_through_what_beer_and_lambert_say() -> None:
    # 64 mm along the view, of an extinction of 0.02 per mm.
    scene = lumivox.Scene((lumivox.VolumeInstance(block(), white(0.02)),))
    camera = lumivox.Camera.look_at((0, 0, 1e5), (0, 0, 0), fov=0.02)
    image = lumivox.render(scene, camera=camera, size=SIZE, samples=16)
    inside = image.alpha[8:-8, 8:-8]
    expected, count = 1.0 - np.exp(-0.02 * 64.0), inside.size * 16
    # Five standard deviations of a fair count; the seed is fixed.
    assert abs(inside.mean() - expected) < 5 * np.sqrt(expected * (1 - expected) / count)


@pytest.mark.parametrize(
    ("arguments", "options"),
    [
        (["--preset", "ct-bone", "--azimuth", "35", "--elevation", "10"], {"preset": "ct-bone", "azimuth": 35, "elevation": 10}),
        (
            ["--keep", "everything", "--environment", "gradient", "--light", "sun:40,30", "--background", "transparent"],
            {"environment": "gradient", "light": lumivox.Sun(40, 30), "background": "transparent"},
        ),
        (
            ["--eye", "100,200,900", "--density", "0.5", "--bounces", "3", "--tone", "plain", "--background", "environment"],
            {"eye": (100, 200, 900), "density": 0.5, "bounces": 3, "tone": "plain", "background": "environment"},
        ),
        (
            ["--peel", "15", "--surface", "off", "--exposure", "0.5", "--seed", "7"],
            {"peel": 15, "surface": False, "exposure": 0.5, "seed": 7},
        ),
    ],
)
def test_a_picture_is_the_commands_to_the_last_bit(
    command: str, head_folder: Path, tmp_path: Path, arguments: list[str], options: dict[str, object]
) -> None:
    # As many samples as software traces at once: how sums are grouped then does not depend on the machine's speed.
    usual = ["--size", "48x40", "--samples", "4", "-o", str(tmp_path / "command.png"), "--quiet"]
    subprocess.run([command, "render", str(head_folder), *arguments, *usual], check=True)
    keep = "everything" if "everything" in arguments else "patient"
    scan = lumivox.load(head_folder, keep=keep)  # type: ignore[arg-type]
    image = lumivox.render(scan, size=(48, 40), samples=4, **options)  # type: ignore[arg-type]
    assert image.alpha.max() > 0.0, "something is seen"
    image.save(tmp_path / "python.png")
    assert (tmp_path / "python.png").read_bytes() == (tmp_path / "command.png").read_bytes()


def test_layers_have_their_shapes_and_meanings(head: lumivox.Volume) -> None:
    image = lumivox.render(head, preset="ct-bone", size=(24, 16), samples=4, layers=True)
    assert image.size == (24, 16) and image.radiance.shape == (16, 24, 3)
    assert image.alpha.shape == image.depth.shape == image.variance.shape == image.samples.shape == (16, 24)
    assert image.albedo is not None and image.normal is not None
    assert image.albedo.shape == image.normal.shape == (16, 24, 3)
    assert image.pixels.shape == (16, 24, 4) and image.pixels.dtype == np.uint8
    assert (image.samples == 4).all() and image.min_samples == 4 and image.complete
    met = image.alpha > 0
    assert met.any() and not met.all()
    assert np.isinf(image.depth[~met]).all()
    # The camera stands in front of a head of some 300 mm.
    assert 300 < image.depth[met].min() < image.depth[met].max() < 1500
    # What is seen of a face looks towards the viewer.
    assert image.normal[met][:, 2].mean() > 0.2
    assert image.albedo[met].max() <= 1.0
    plain = lumivox.render(head, preset="ct-bone", size=(24, 16), samples=4)
    assert plain.albedo is None and plain.normal is None
    np.testing.assert_array_equal(plain.alpha, image.alpha)


def test_seeds_differ_and_repeat(head: lumivox.Volume) -> None:
    def film(seed: int) -> np.ndarray:
        return lumivox.render(head, size=(16, 16), samples=4, seed=seed).film.sums()

    np.testing.assert_array_equal(film(1), film(1))
    assert (film(1) != film(2)).any()


def test_windows_and_ranges_of_samples_are_the_images_own(head: lumivox.Volume) -> None:
    planned = rendering.plan(head, {"size": (24, 20), "samples": 12, "pass_samples": 4, "layers": True, "preset": "ct-bone"})
    render = rendering.renderer()

    def sums(**change: object) -> np.ndarray:
        request = replace(planned.request, **change)  # type: ignore[arg-type]
        return render.run(replace(planned, request=request)).film.sums()

    whole = sums()
    for x, y, width, height in ((0, 0, 10, 7), (10, 7, 14, 13), (23, 19, 1, 1)):
        part = sums(window=(x, y, width, height))
        np.testing.assert_array_equal(part, whole[:, y : y + height, x : x + width])
    # One pass each: added in order they are the same to the last bit.
    passes = [sums(samples=end, first_sample=end - 4) for end in (4, 8, 12)]
    assert all((part[1, ..., 2] == 4).all() for part in passes)
    np.testing.assert_array_equal((passes[0] + passes[1]) + passes[2], whole)
    # Two passes in one are rounded otherwise, and no more than that.
    two = sums(samples=8)
    last = sums(samples=12, first_sample=4)
    np.testing.assert_allclose(passes[0] + last, whole, rtol=1e-5, atol=1e-6)
    np.testing.assert_array_equal(two + passes[2], whole)


def test_an_image_does_not_depend_on_those_before_it(head: lumivox.Volume) -> None:
    options = {"size": (32, 32), "samples": 4, "environment": "gradient", "light": lumivox.Sun(40, 30)}
    fresh = lumivox.Renderer().render(head, **options).film.sums()  # type: ignore[arg-type]
    for other in (block(), lumivox.phantom("cube", 40), block(7)):
        lumivox.render(other, preset="plain", size=(8, 8), samples=1)
        np.testing.assert_array_equal(lumivox.render(head, **options).film.sums(), fresh)  # type: ignore[arg-type]


def test_progressive_images_converge_to_the_whole(head: lumivox.Volume) -> None:
    images = list(lumivox.progressive(head, preset="ct-bone", size=(16, 16), samples=6))
    assert [image.min_samples for image in images] == [1, 2, 4, 6]
    assert [image.complete for image in images] == [False, False, False, True]
    whole = lumivox.render(head, preset="ct-bone", size=(16, 16), samples=6)
    np.testing.assert_allclose(images[-1].radiance, whole.radiance, rtol=1e-5, atol=1e-6)
    for image in lumivox.progressive(head, size=(16, 16)):
        if image.min_samples >= 2:
            break
    assert not image.complete


def test_an_image_out_of_time_is_not_complete(head: lumivox.Volume) -> None:
    size = (16, 16)
    image = lumivox.render(head, size=size, samples=1 << 22, time=0.2)
    assert not image.complete and 1 <= image.min_samples < 1 << 22
    assert image.notes == (f"the time was over at {image.min_samples} of the {1 << 22} samples per pixel",)
    *_, last = lumivox.progressive(head, size=size, samples=1 << 22, time=0.2)
    assert not last.complete and "the time was over" in last.notes[0]
    # What there is time for was asked for, and no number.
    image = lumivox.render(head, size=size, time=0.2)
    assert image.complete and not image.notes
    assert lumivox.render(head, size=size, samples=2, time=60.0).complete


def test_where_nothing_is_seen_it_is_said(head: lumivox.Volume) -> None:
    away = lumivox.Camera.look_at((0, 0, 500), (0, 0, 900))
    assert "no ray met the scan" in lumivox.render(head, camera=away, size=(8, 8), samples=1).notes[0]
    assert "no ray met the scan" in next(iter(lumivox.progressive(head, camera=away, size=(8, 8)))).notes[0]


def test_what_is_wrong_with_a_progressive_image_is_said_at_once(head: lumivox.Volume) -> None:
    with pytest.raises(TypeError, match="there is no option 'azimut'"):
        lumivox.progressive(head, azimut=3)  # type: ignore[call-arg]


@pytest.mark.parametrize("modality", ["CT", "MR", "PT", ""])
def test_a_volume_of_one_value_has_a_look(modality: str) -> None:
    flat = lumivox.Volume.from_array(np.zeros((8, 8, 8), np.uint8), modality=modality)
    for preset in (None, *(one.name for one in lumivox.presets())):
        lumivox.Scene.of(flat, preset=preset)


def test_other_threads_run_meanwhile(head: lumivox.Volume) -> None:
    turns, done = 0, threading.Event()

    def count() -> None:
        nonlocal turns
        while not done.wait(0.001):
            turns += 1

    thread = threading.Thread(target=count)
    thread.start()
    begin = time.monotonic()
    lumivox.render(head, size=(64, 64), samples=8)
    took = time.monotonic() - begin
    done.set()
    thread.join()
    assert turns > 20 * took, f"{turns} turns in {took:.2f} s"


def test_progress_is_told_and_stops(head: lumivox.Volume) -> None:
    told: list[lumivox.Progress] = []

    def stop(progress: lumivox.Progress) -> bool:
        told.append(progress)
        return progress.samples < 2

    image = lumivox.render(head, size=(32, 32), samples=100_000, progress=stop)
    assert told and told[-1].target == 100_000
    assert not image.complete and 1 <= image.min_samples < 100_000


@pytest.mark.parametrize("options", [{}, {"eye": (0, -90, 30)}, {"elevation": 20, "azimuth": 5}])
def test_a_single_slice_looks_as_the_commands(options: dict[str, Any], command: str, tmp_path: Path) -> None:
    rows, columns = np.mgrid[:24, :32]
    np.save(tmp_path / "slice.npy", (100.0 + 50.0 * np.sin(rows / 3.0) * np.cos(columns / 4.0)).astype(np.float32)[None])
    said = [f"--{name}={','.join(map(str, np.ravel(value)))}" for name, value in options.items()]
    usual = ["--size", "48x40", "--samples", "4", "-o", "slice.png", "--quiet"]
    subprocess.run([command, "render", "slice.npy", *said, *usual], cwd=tmp_path, check=True)
    image = lumivox.render(lumivox.load(tmp_path / "slice.npy"), size=(48, 40), samples=4, **options)
    assert image._repr_png_() == (tmp_path / "slice.png").read_bytes() and image.alpha.max() > 0.3


@pytest.mark.skipif(sys.platform == "win32", reason="what os.kill sends there ends the process")
def test_ctrl_c_stops_a_render(head: lumivox.Volume) -> None:
    timer = threading.Timer(1.0, os.kill, (os.getpid(), signal.SIGINT))
    timer.start()
    begin = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        lumivox.render(head, size=(32, 32), samples=1 << 24)
    timer.join()
    assert time.monotonic() - begin < 20.0
    # And the next one is as usual.
    assert lumivox.render(head, size=(8, 8), samples=1).complete


def test_devices_are_listed_and_chosen() -> None:
    devices = lumivox.gpus()
    assert devices and [device.index for device in devices] == list(range(len(devices)))
    usable = next(device for device in devices if device.unsuitable is None)
    assert lumivox.Renderer(usable.index).gpu.name == usable.name
    assert lumivox.Renderer(usable.name[:6].upper()).gpu.name.lower().startswith(usable.name[:6].lower())
    with pytest.raises(lumivox.GpuError, match="no GPU's name contains 'GeForce 9999'. There are: "):
        lumivox.Renderer("GeForce 9999")
    with pytest.raises(lumivox.GpuError, match="there is no GPU 99. There are: 0 "):
        lumivox.Renderer(99)


def test_options_that_make_no_sense_are_told(head: lumivox.Volume) -> None:
    with pytest.raises(TypeError, match="there is no option 'azimut'; did you mean 'azimuth'?"):
        lumivox.render(head, azimut=3)  # type: ignore[call-arg]
    with pytest.raises(ValueError, match="samples must be 1 to 16777216"):
        lumivox.render(head, samples=0)
    with pytest.raises(ValueError, match="width and height must be 1 to 32768"):
        lumivox.render(head, size=(0, 5))
    with pytest.raises(ValueError, match="background must be transparent, environment or a colour"):
        lumivox.render(head, size=(8, 8), samples=1, background="red").pixels  # noqa: B018
    with pytest.raises(ValueError, match="filter 'cubic' is not"):
        lumivox.render(head, filter="cubic")  # type: ignore[arg-type]
    scene = lumivox.Scene.of(head)
    with pytest.raises(ValueError, match="a scene has its look and light: preset cannot be given besides"):
        lumivox.render(scene, preset="ct-bone")
    with pytest.raises(ValueError, match="eye is the point looked at; move it, or give another target"):
        lumivox.render(head, eye=(0, 0, 0), target=(0, 0, 0))


def test_files_hold_what_was_rendered(head: lumivox.Volume, tmp_path: Path) -> None:
    image = lumivox.render(head, preset="ct-bone", size=(32, 16), samples=2, layers=True, background="transparent")
    image.save(tmp_path / "a.png")
    assert image._repr_png_() == (tmp_path / "a.png").read_bytes()
    assert image._repr_png_().startswith(b"\x89PNG\r\n\x1a\n")
    image.save(tmp_path / "a.exr")
    # Our own reader of light takes red, green and blue.
    np.testing.assert_array_equal(lumivox.EnvironmentMap.load(tmp_path / "a.exr").array, image.radiance)
    for name in (b"albedo.R", b"normal.Z", b"variance"):
        assert name in (tmp_path / "a.exr").read_bytes()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.exr", "a.png"]
    with pytest.raises(ValueError, match="the output must end in .png or .exr"):
        image.save(tmp_path / "a.jpg")


def test_images_are_shown_otherwise_without_rendering_again(head: lumivox.Volume) -> None:
    image = lumivox.render(head, preset="ct-bone", size=(16, 16), samples=2)
    brighter = image.shown(exposure=2.0, background="#ffffff")
    assert brighter.pixels.astype(int).sum() > image.pixels.astype(int).sum()
    np.testing.assert_array_equal(brighter.radiance, image.radiance)
    copy = pickle.loads(pickle.dumps(image))
    np.testing.assert_array_equal(copy.pixels, image.pixels)
    denoised = image.denoised()
    assert denoised.noise is None and denoised.smoothed, "what is left is not known"
    assert denoised.denoised() is denoised


def test_several_scans_share_the_patients_space(head: lumivox.Volume) -> None:
    one = lumivox.render(head, preset="ct-bone", size=(16, 16), samples=4)
    two = lumivox.render([head, head], preset=["ct-bone", "ct-bone"], size=(16, 16), samples=4)
    assert two.alpha.mean() > one.alpha.mean()
    with pytest.raises(ValueError, match="preset is given 3 times for 2 scans; give it once for all, or once for each"):
        lumivox.Scene.of([head, head], preset=["ct-bone"] * 3)


def test_a_map_lights_as_the_light_it_was_made_of() -> None:
    texels = np.ones((8, 16, 3), np.float32) * [0.5, 0.25, 1.0]
    scene = lumivox.Scene((lumivox.VolumeInstance(block(), white()),), lumivox.Environment(lumivox.EnvironmentMap(texels)))
    image = lumivox.render(scene, size=SIZE, samples=4)
    np.testing.assert_allclose(image.radiance, image.alpha[..., None] * [0.5, 0.25, 1.0], atol=1e-5)
