"""Scenes in files: what Python saves the command opens to the same pixels, and the other way round."""

from __future__ import annotations

import json
import os
import pickle
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from conftest import block, white

import lumivox

SIZE = (32, 24)


def picture(command: str, scene: Path, *options: str) -> bytes:
    """The command's picture of a scene."""
    target = scene.with_suffix(".png")
    asked = [command, "render", str(scene), "--quiet", "-o", str(target), *options]
    subprocess.run(asked, check=True, timeout=200, capture_output=True)
    return target.read_bytes()


def png(image: lumivox.Image, folder: Path) -> bytes:
    target = folder / "python.png"
    image.save(target)
    return target.read_bytes()


@pytest.fixture(scope="module")
def torso_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a torso as a DICOM series, with its table."""
    folder = tmp_path_factory.mktemp("scenes")
    lumivox.write_dicom_series(lumivox.phantom("torso", 64), folder / "torso")
    return folder


def test_a_scene_of_the_command_is_rendered_to_the_last_bit(command: str, torso_file: Path) -> None:
    scene = torso_file / "of_command.json"
    options = [
        "--preset",
        "ct-bone",
        "--window",
        "300,1200",
        "--azimuth",
        "35",
        "--labels",
        "found",
        "--label",
        "lungs=opacity:0.5,color",
    ]
    options += ["--clip-shape", "plane:0,0,20,0,0,-1", "--light", "sun:40,30", "--size", "32x24", "--samples", "4"]
    options += ["--environment", "gradient", "--environment-rotation", "20", "--exposure", "0.5", "--tone", "aces", "--seed", "7"]
    saving = [command, "scene", "save", str(scene), str(torso_file / "torso"), "--quiet", *options]
    subprocess.run(saving, check=True, timeout=200, capture_output=True)
    opened = lumivox.load_scene(scene)
    assert (opened.size, opened.samples, opened.seed, opened.display.tone) == (SIZE, 4, 7, "aces")
    (instance,) = opened.scene.volumes
    assert instance.labels is not None and len(instance.clip_shapes) == 1  # type: ignore[arg-type]
    assert png(opened.render(), torso_file) == picture(command, scene)
    # Options win over what was saved.
    other = opened.render(azimuth=-60, exposure=0.0)
    assert png(other, torso_file) == picture(command, scene, "--azimuth", "-60", "--exposure", "0")


@pytest.mark.parametrize("labels", [None, {}])
def test_what_a_lasso_cut_stays_cut(command: str, torso_file: Path, tmp_path: Path, labels: dict[str, str] | None) -> None:
    square = [[-40, -40], [40, -40], [40, 40], [-40, 40]]
    from_picture = [[1, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0]]
    lasso = {"from_picture": from_picture, "parallel": True, "points": square}
    entry = {"scan": {"files": [str(torso_file / "torso")]}, "lassos": [lasso]}
    words = {"lumivox_scene": 1, "film": {"size": SIZE, "samples": 2}}
    cut, whole = tmp_path / "cut.json", tmp_path / "whole.json"
    more = {} if labels is None else {"labels": labels}
    cut.write_text(json.dumps({**words, "volumes": [{**entry, **more}]}))
    whole.write_text(json.dumps({**words, "volumes": [{"scan": entry["scan"], **more}]}))
    opened = lumivox.load_scene(cut)
    shown = png(opened.render(), tmp_path)
    assert shown == picture(command, cut) != picture(command, whole)
    # On another machine, too, and in a file of its own.
    far = pickle.loads(pickle.dumps(opened.scene))
    assert png(replace(opened, scene=far).render(), tmp_path) == shown
    (instance,) = opened.scene.volumes
    assert instance.labels is not None and "cut away" not in instance.labels.names
    assert bool(instance.labels.names) == (labels is not None)
    again = tmp_path / "again.json"
    opened.save(again)
    saved = json.loads(again.read_text())["volumes"][0]
    assert saved["lassos"][0]["points"] == square and ("labels" in saved) == (labels is not None)
    assert "cut away" not in again.read_text()
    assert picture(command, again) == shown


def test_a_scene_of_python_is_rendered_by_the_command(command: str, torso_file: Path, tmp_path: Path) -> None:
    scan = lumivox.load(torso_file / "torso")
    curve = lumivox.TransferFunction([(-300, 0.0), (100, 0.4, "in-out"), (600, 1.0)], [(0, "#aa5533"), (500, (1, 1, 0.9))], [])
    scene = lumivox.Scene.of(
        scan,
        transfer_function=curve,
        density=2.0,
        clip=((0.1, 0.0, 0.0), (1.0, 1.0, 0.9)),
        clip_shape=[
            lumivox.ClipShape.sphere((0, 0, 40), 60).invert(),
            lumivox.ClipShape.plane((0, 0, 0), (0, 1, 1), space="patient"),
        ],
        labels="found",
        label={"lungs": lumivox.LabelStyle(opacity=0.3, color="own", transfer_function=curve), "body": "uncut"},
        environment=lumivox.Environment("uniform", 0.5, color=(0.5, 0.6, 0.7)),
        light=[
            lumivox.Sun(40, 30, 2.0),
            lumivox.PointLight((300, 200, 400), (0.2, 0.1, 0.1), 20.0, decay=1.5, range=2000.0),
            lumivox.SpotLight((-300, 200, 400), (0, 0, 0), 40.0, (0.3, 0.3, 0.5), inner_half_angle=10.0),
            lumivox.PointLight((0, 500, 0), (1.0, 0.9, 0.8), decay=None, range=900.0),
            lumivox.DirectionalLight((0.1, -1.0, -0.3), (0.5, 0.4, 0.3)),
        ],
    )
    saved = tmp_path / "of_python.json"
    scene.save(saved, azimuth=20, size=SIZE, samples=4, seed=3, tone="plain", background="#ffffff")
    opened = lumivox.load_scene(saved)
    assert opened.seed == 3 and opened.display.background == "#ffffff"
    image = lumivox.render(scene, azimuth=20, size=SIZE, samples=4, seed=3, tone="plain", background="#ffffff")
    assert image.alpha.max() > 0.9
    assert png(opened.render(), tmp_path) == png(image, tmp_path) == picture(command, saved)
    # As it is: once more saved it says the same.
    again = tmp_path / "again.json"
    opened.scene.save(again, opened.camera, size=SIZE, samples=4, seed=3, tone="plain", background="#ffffff")
    assert json.loads(again.read_text()) == json.loads(saved.read_text())
    opened.save(again)
    assert json.loads(again.read_text()) == json.loads(saved.read_text())
    # What is said wins, and a view from elsewhere takes the camera's place.
    opened.save(again, azimuth=90, samples=7)
    other = lumivox.load_scene(again)
    assert (other.samples, other.seed, other.size) == (7, 3, SIZE) and other.camera.fov == opened.camera.fov
    assert other.camera == lumivox.Camera.framing(opened.scene, azimuth=90, fov=opened.camera.fov, size=SIZE)
    # All looks go along: a thinner one is another picture.
    (instance,) = opened.scene.volumes
    thin = replace(opened.scene, volumes=(replace(instance, medium=replace(instance.medium, density=0.1)),))
    assert not np.array_equal(replace(opened, scene=thin).render().pixels, image.pixels)


HOSTS = ("command", "window", "python", "godot", "unity")
WRITTEN = Path(__file__).parents[2] / "crates/lumivox-testing/scenes"
"""Scenes as each host wrote them; the suites of the other hosts open them, too."""


def test_what_every_host_saved_is_the_same_picture_saved_by_python(command: str, tmp_path: Path) -> None:
    lumivox.write_dicom_series(lumivox.phantom("head", 32), tmp_path / "scan")
    for host in HOSTS:
        shutil.copy(WRITTEN / f"{host}.lumivox", tmp_path)
    metal = lumivox.SurfaceReflection(1.0, 90.0, 0.2, 0.7, 1.0)
    scene = lumivox.Scene.of(
        lumivox.load(tmp_path / "scan"),
        preset="ct-bone",
        density=0.7,
        anisotropy=0.3,
        surface=lumivox.SurfaceReflection(0.9, 150.0, 0.3, 0.5, 0.6),
        clip_shape=lumivox.ClipShape.plane((0, 0, 30), (0, -1, 1), space="patient"),
        labels="found",
        label={"body": lumivox.LabelStyle(opacity=0.6, color="#c08040", surface=metal)},
        environment=lumivox.Environment("uniform", 0.5, color=(0.5, 0.6, 0.7)),
        light=[lumivox.PointLight((300, 200, 400), (0.2, 0.1, 0.1), 20.0), lumivox.Sun(-40, 20)],
    )
    own = tmp_path / "own.lumivox"
    scene.save(own, azimuth=-25, zoom=1.2, size=(40, 32), samples=4, seed=3, tone="agx", background="#ffffff")
    if os.environ.get("LUMIVOX_UPDATE"):
        shutil.copy(own, WRITTEN / "python.lumivox")
    assert own.read_text() == (WRITTEN / "python.lumivox").read_text(), "LUMIVOX_UPDATE=1 keeps what is written now"
    for host in HOSTS:
        written, again = tmp_path / f"{host}.lumivox", tmp_path / f"of-{host}.lumivox"
        # Warnings are errors here: none says that the scan is another.
        opened = lumivox.load_scene(written)
        opened.save(again)
        assert png(opened.render(), tmp_path) == picture(command, written) == picture(command, again), host


def test_what_was_made_in_memory_is_no_scenes(tmp_path: Path) -> None:
    scene = lumivox.Scene((lumivox.VolumeInstance(block(), white()),))
    with pytest.raises(ValueError, match="scan 1 was made in memory: write it to a file"):
        scene.save(tmp_path / "scene.json")
    assert not list(tmp_path.iterdir())
    with pytest.raises(TypeError, match="a scene keeps no option 'gpu'"):
        scene.save(tmp_path / "scene.json", gpu=0)


def test_what_is_wrong_with_a_scene_is_told_with_its_line(torso_file: Path, tmp_path: Path) -> None:
    wrong = tmp_path / "wrong.json"
    words = {"lumivox_scene": 1, "volumes": [{"scan": {"files": [str(torso_file / "torso")]}, "look": {"density": -1}}]}
    wrong.write_text(json.dumps(words, indent=1))
    with pytest.raises(lumivox.ScanError, match=r"wrong.json, line \d+, column \d+: density is -1, and must be"):
        lumivox.load_scene(wrong)
    words = {"lumivox_scene": 1, "volumes": [{"scan": {"files": ["nowhere"]}}]}
    wrong.write_text(json.dumps(words, indent=1))
    with pytest.raises(lumivox.MissingFileError, match=r"wrong.json, line 6, column \d+: .*nowhere"):
        lumivox.Scene.load(wrong)
    with pytest.raises(lumivox.MissingFileError):
        lumivox.load_scene(tmp_path / "none.json")


def test_an_image_ends_by_its_noise() -> None:
    scene = lumivox.Scene((lumivox.VolumeInstance(block(), white()),))
    image = lumivox.render(scene, size=(16, 16), noise=0.2)
    assert image.complete and image.noise is not None and image.noise <= 0.2 and image.min_samples < 512
    *_, last = lumivox.progressive(scene, size=(16, 16), noise=0.2)
    assert last.complete and last.noise is not None and last.noise <= 0.2
    with pytest.raises(ValueError, match="noise"):
        lumivox.render(scene, noise=2.0)
