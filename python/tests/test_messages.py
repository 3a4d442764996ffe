"""What is asked wrongly is told by its name, with what it must be, before anything is loaded or traced."""

from __future__ import annotations

import os
import subprocess
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import lumivox
from lumivox import cluster, interop

SPHERE = lumivox.phantom("sphere", 16)

ONES = np.ones((2, 2, 2), np.uint8)

CURVE = lumivox.TransferFunction([(0, 1.0)], [(0, (1, 1, 1))])

OPTIONS: list[tuple[type[Exception], str, dict[str, Any]]] = [
    (TypeError, "preset must be a name, such as 'ct-bone', not 5; lumivox.presets() lists them", {"preset": 5}),
    (TypeError, "preset must be a name, such as 'ct-bone', not 5", {"preset": ["ct-bone", 5]}),
    (ValueError, "preset is given 0 times for 1 scan", {"preset": []}),
    (TypeError, "size must be width and height in pixels, such as (768, 768), not 32", {"size": 32}),
    (TypeError, "size must be width and height in pixels, such as (768, 768), not '32x32'", {"size": "32x32"}),
    (ValueError, "size must be whole numbers of pixels, not (32.5, 32)", {"size": (32.5, 32)}),
    (ValueError, "size: width and height must be 1 to 32768, not (0, 5)", {"size": (0, 5)}),
    (ValueError, "samples must be a whole number, 1 to 16777216, not 1.5", {"samples": 1.5}),
    (TypeError, "samples must be a whole number, 1 to 16777216, not 'many'", {"samples": "many"}),
    (TypeError, "samples must be a whole number, 1 to 16777216, not True", {"samples": True}),
    (ValueError, "clip must be two corners, ((x, y, z), (x, y, z))", {"clip": (0, 0, 0, 1, 1, 1)}),
    (ValueError, "clip must be fractions from 0 to 1, each low one below its high one", {"clip": ((0, 0, 0), (2, 1, 1))}),
    (TypeError, "time must be a number, 0.01 to 10000000, not 'long'", {"time": "long"}),
    (ValueError, "seed must be 0 to 4294967295, not -1", {"seed": -1}),
    (TypeError, "gpu must be an index of lumivox.gpus(), or a part of a name, not 1.5", {"gpu": 1.5}),
    (TypeError, "progress must be a function that is given a lumivox.Progress, not 5", {"progress": 5}),
    (ValueError, "pass_samples must be 1 to 16777216, not 0", {"pass_samples": 0}),
    (TypeError, "layers must be True or False, not 'albedo'", {"layers": "albedo"}),
    (TypeError, "density must be a number, 0 to 1000000000, not 'thick'", {"density": "thick"}),
    (TypeError, "window must be a level and a width, such as (40, 400), not 5", {"window": 5}),
    (ValueError, "window is given 3 times for 1 scan", {"window": [None, (40, 400), None]}),
    (ValueError, "bounces must be a whole number, 1 to 1000, not 1.5", {"bounces": 1.5}),
    (TypeError, "surface must be True, False or a lumivox.SurfaceReflection, not 'off'", {"surface": "off"}),
    (ValueError, "filter 'cubic' is not 'nearest', 'trilinear', 'tricubic' or 'smooth'", {"filter": "cubic"}),
    (ValueError, "peel must be 0 to 63, not 100", {"peel": 100}),
    (TypeError, "camera must be a lumivox.Camera, not 5; lumivox.Camera.look_at(eye, target) makes one", {"camera": 5}),
    (TypeError, "azimuth must be a number, not 'left'", {"azimuth": "left"}),
    (ValueError, "zoom must be 0.001 to 1000, not 0", {"zoom": 0}),
    (TypeError, "eye must be three numbers, x, y and z, not (1, 2)", {"eye": (1, 2)}),
    (ValueError, "environment 'sky' is not 'studio', 'uniform' or 'gradient', nor a file", {"environment": "sky"}),
    (TypeError, "environment must be 'studio'", {"environment": np.ones((2, 4, 3))}),
    (ValueError, "environment_strength must be 0 to 1000000, not -1", {"environment_strength": -1}),
    (TypeError, "light must be a lumivox.Sun, DirectionalLight, PointLight or SpotLight", {"light": "sun:40,30"}),
    (ValueError, "background must be transparent, environment or a colour such as #202428, not 'red'", {"background": "red"}),
    (ValueError, "exposure must be -32 to 32, not 1000", {"exposure": 1000}),
    (ValueError, "tone 'film' is not 'agx', 'aces' or 'plain'", {"tone": "film"}),
    (TypeError, "transfer_function must be a lumivox.TransferFunction or a file of one, not 5", {"transfer_function": 5}),
    (lumivox.ScanError, "missing.json: No such file", {"transfer_function": "missing.json"}),
]

CALLS: list[tuple[type[Exception], str, Callable[[], object]]] = [
    (TypeError, "path must be the name of a file or folder, not None", lambda: lumivox.load(None)),  # type: ignore[arg-type]
    (ValueError, "path is an empty list; name a file or folder", lambda: lumivox.load([])),
    (ValueError, "path is empty", lambda: lumivox.load("")),
    (TypeError, "series must be a place in the report's list", lambda: lumivox.load(".", series=[1])),  # type: ignore[arg-type]
    (ValueError, "phase must be 1 to", lambda: lumivox.load(".", phase=0)),
    (TypeError, "raw must be a layout, such as '256x256x108:i16le", lambda: lumivox.load(".", raw=5)),  # type: ignore[arg-type]
    (TypeError, "axes must be three letters, such as 'LPS', not 5", lambda: lumivox.load(".", axes=5)),  # type: ignore[arg-type]
    (TypeError, "layout must be a layout, such as 'zyx', not 5", lambda: lumivox.scan(".", layout=5)),  # type: ignore[arg-type]
    (TypeError, "spacing must be three lengths in mm", lambda: lumivox.load(".", spacing=2.0)),  # type: ignore[arg-type]
    (ValueError, "spacing '1.0,1.0,0.0': three lengths in mm", lambda: lumivox.load(".", spacing=(1, 1, 0))),
    (ValueError, "axes 'LRS': three letters are expected", lambda: lumivox.load_labels(".", axes="LRS")),
    (ValueError, "layout 'zyq': the letters of axes", lambda: lumivox.load(".", layout="zyq")),
    (ValueError, "modality 'US' is not 'CT', 'MR', 'PET' or 'other'", lambda: lumivox.load(".", modality="US")),
    (TypeError, "kind must be a phantom's name, such as 'head', not 5", lambda: lumivox.phantom(5)),  # type: ignore[arg-type]
    (ValueError, "there is no phantom 'hed'. Phantoms: head, mr-head", lambda: lumivox.phantom("hed")),
    (ValueError, "size must be 8 to 1024, not 4", lambda: lumivox.phantom("head", 4)),
    (TypeError, "a volume is not made of 'scan.nii', but by lumivox.load(path)", lambda: lumivox.Volume("scan.nii")),  # type: ignore[arg-type]
    (TypeError, "labels are not made of 5, but by lumivox.load_labels(path)", lambda: lumivox.Labels(5)),  # type: ignore[arg-type]
    (TypeError, "an array with the axes z, y, x is needed, not 'a.nii'", lambda: lumivox.Volume.from_array("a.nii")),
    (ValueError, "not lists of several lengths", lambda: lumivox.Volume.from_array([[1, 2], [3]])),  # type: ignore[list-item]
    (ValueError, "origin must be three finite numbers, not None", lambda: lumivox.Volume.from_array(ONES, origin=None)),  # type: ignore[arg-type]
    (ValueError, "orientation must be 3 x 3 numbers", lambda: lumivox.Volume.from_array(ONES, orientation=np.eye(4))),
    (
        TypeError,
        "modality must be 'CT', 'MR', 'PET' or 'other', not None",
        lambda: lumivox.Volume.from_array(ONES, modality=None),
    ),  # type: ignore[arg-type]
    (TypeError, "medium must be a lumivox.Medium, not 'ct-bone'", lambda: lumivox.VolumeInstance(SPHERE, "ct-bone")),  # type: ignore[arg-type]
    (TypeError, "a scene's volumes are lumivox.VolumeInstance", lambda: lumivox.Scene(SPHERE)),  # type: ignore[arg-type]
    (
        ValueError,
        "world_from_patient must be a transform that can be undone: this one flattens",
        lambda: lumivox.VolumeInstance(SPHERE, lumivox.Medium(CURVE), world_from_patient=np.zeros((3, 4))),  # type: ignore[arg-type]
    ),
    (TypeError, "scene must be a lumivox.Scene", lambda: lumivox.Camera.framing(SPHERE)),  # type: ignore[arg-type]
    (TypeError, "color must be three numbers, red, green and blue", lambda: lumivox.Environment(color="red")),  # type: ignore[arg-type]
    (ValueError, "environment 'sky' is not 'studio', 'uniform', 'gradient' or a map", lambda: lumivox.Environment("sky")),
    (ValueError, "target is the light's position", lambda: lumivox.SpotLight((0, 0, 0), (0, 0, 0))),
    (ValueError, "must be numbers of (rows, columns, 3)", lambda: lumivox.EnvironmentMap(np.ones((2, 2)))),
    (ValueError, "an opacity knot is (value, opacity)", lambda: lumivox.TransferFunction([(0,)], CURVE.color)),  # type: ignore[list-item]
    (TypeError, "opacity must be a list of points", lambda: lumivox.TransferFunction([0, 1], CURVE.color)),  # type: ignore[list-item]
    (TypeError, "values must be numbers, not 'bone'", lambda: CURVE.at("bone")),
    (ValueError, "a Renderer has its GPU", lambda: lumivox.Renderer().render(SPHERE, gpu=0)),
    (TypeError, "a SimpleITK.Image is needed, not 5", lambda: interop.from_sitk(5)),
    (TypeError, "a nibabel image is needed, not 5", lambda: interop.from_nibabel(5)),
    (TypeError, "an xarray.DataArray is needed, not 5", lambda: interop.from_xarray(5)),
    (TypeError, "a lumivox.Volume is needed, not 5", lambda: interop.to_sitk(5)),  # type: ignore[arg-type]
    (TypeError, "visible must be True or False, not 'yes'", lambda: lumivox.LabelStyle(visible="yes")),  # type: ignore[arg-type]
    (TypeError, "depth must be a lumivox.Volume, as volume.skin_depth() gives it", lambda: lumivox.Peel(5, 3)),  # type: ignore[arg-type]
]


@pytest.mark.parametrize(("kind", "words", "options"), OPTIONS, ids=[words[:40] for _, words, _ in OPTIONS])
def test_options_are_told_by_their_names(kind: type[Exception], words: str, options: dict[str, Any]) -> None:
    with pytest.raises(kind) as told:
        lumivox.render(SPHERE, **{"size": (8, 8), "samples": 1, **options})
    assert words in str(told.value)


@pytest.mark.parametrize(("kind", "words", "call"), CALLS, ids=[words[:40] for _, words, _ in CALLS])
def test_arguments_are_told_by_their_names(kind: type[Exception], words: str, call: Callable[[], object]) -> None:
    with pytest.raises(kind) as told:
        call()
    assert words in str(told.value)


def test_whole_numbers_may_be_numpys_or_round() -> None:
    image = lumivox.render(SPHERE, size=np.array([8, 6]), samples=2.0, seed=np.int64(3))  # type: ignore[arg-type]
    assert image.size == (8, 6) and image.min_samples == 2


def test_files_that_cannot_be_written_are_told_by_their_names(tmp_path: Path) -> None:
    image = lumivox.render(SPHERE, size=(8, 8), samples=1)
    for save in (image.save, CURVE.save):
        with pytest.raises(FileNotFoundError, match=rf"missing/a.png cannot be written: there is no folder {tmp_path}"):
            save(tmp_path / "missing" / "a.png")
        with pytest.raises(IsADirectoryError, match="cannot be written: it is a folder; name a file in it"):
            save(tmp_path)
        with pytest.raises(OSError, match="^/proc/a.png cannot be written: "):
            save("/proc/a.png")
        with pytest.raises(TypeError, match="path must be the name of a file or folder, not None"):
            save(None)  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="there is no option 'exposur'; there are background, exposure, tone, gamma"):
        image.shown(exposur=1.0)
    assert list(tmp_path.iterdir()) == []


def test_what_is_no_cluster_is_told_and_leaves_nothing_open(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cluster, "CONNECT", 1.0)
    before = set(threading.enumerate())
    for given, kind, words in (
        (5, TypeError, "cluster must be the address of a Dask scheduler, such as tls://HOST:8786"),
        ("nonsense", ValueError, "cluster 'nonsense' is not the address of a Dask scheduler, such as tls://HOST:8786"),
        ("tcp://127.0.0.1:9", ConnectionError, "no Dask scheduler answers at tcp://127.0.0.1:9"),
        ("http://127.0.0.1:9", ConnectionError, "no Dask scheduler answers at http://127.0.0.1:9: unknown address scheme"),
    ):
        with pytest.raises(kind, match=words):
            cluster.render(SPHERE, cluster=given, size=(8, 8), samples=1)
    assert set(threading.enumerate()) <= before
    scene = lumivox.Scene.of(SPHERE)
    for words, call in (
        ("gpu is for one machine", lambda: cluster.render(SPHERE, gpu=0)),
        ("cameras must be lumivox.Camera, one for each frame, not 5", lambda: cluster.film(scene, [5])),  # type: ignore[list-item]
        ("scenes must be several lumivox.Scene", lambda: cluster.study(scene)),  # type: ignore[arg-type]
        ("workers must be 1 to 1000, not 0", lambda: cluster.Local(0)),
    ):
        with pytest.raises((TypeError, ValueError), match=words):
            call()


def test_without_a_gpu_it_is_said_what_to_install(python: str, tmp_path: Path) -> None:
    environment = {**os.environ, "VK_DRIVER_FILES": str(tmp_path / "none.json"), "PYTHONSAFEPATH": "1"}

    def run(*arguments: str) -> subprocess.CompletedProcess[str]:
        return subprocess.run([python, *arguments], env=environment, capture_output=True, text=True, timeout=60, check=False)

    failed = run("-c", "import lumivox; lumivox.render(lumivox.phantom('cube', 8))")
    assert "GpuError: no GPU and no software Vulkan was found. 'python -m lumivox doctor' says what to install" in failed.stderr
    doctor = run("-m", "lumivox", "doctor")
    assert doctor.returncode == 1 and "VK_DRIVER_FILES is set" in doctor.stderr and lumivox.__version__ in doctor.stdout
    del environment["VK_DRIVER_FILES"]
    doctor = run("-m", "lumivox", "doctor")
    assert doctor.returncode == 0 and lumivox.gpus()[0].name in doctor.stdout
