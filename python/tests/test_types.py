"""What is written is what type checkers, notebooks and pickles see."""

from __future__ import annotations

import copy
import inspect
import os
import pickle
import pydoc
import subprocess
import sys
import typing
from pathlib import Path

import numpy as np
import pytest

import lumivox
from lumivox import cluster, interop

TYPED = """
import numpy as np
import lumivox
from lumivox import Camera, ClipShape, Environment, LabelStyle, Labels, PointLight, Scene, SpotLight, Sun, Volume
from lumivox import TransferFunction

array = np.zeros((4, 4, 4), np.int16)
vector = np.array([1.0, 2.0, 3.0])
curve = TransferFunction([(0, 0.0), (100, 0.5, "in-out")], [(0, "#102030"), (50, (1, 0.5, 0.2)), (80, vector)], [])
scan = Volume.from_array(array, spacing=vector, origin=vector, orientation=np.eye(3))
labels = Labels.from_array(array, vector, vector, names={1: "a"}, colors={1: "#ff0000", 2: (1.0, 0.0, 0.0)})
camera = Camera(np.eye(4))
camera = Camera.look_at(vector, np.zeros(3), up=vector)
lamp, spot = PointLight(vector, vector, 10.0), SpotLight(vector, np.zeros(3))
style = LabelStyle(color="#ff0000")
style = LabelStyle(color=vector)
words = {"lungs": "hide", "bone": "color:#e8d8b0"}
styles = {1: LabelStyle(opacity=0.5)}
shape = ClipShape.plane(vector, vector)
scene = Scene.of(scan, clip=(vector * 0, vector), label=words, labels=labels, light=[Sun(40, 30), lamp, spot], clip_shape=shape)
image = lumivox.render(scan, transfer_function=curve, eye=vector, target=vector, label=styles, labels=labels, size=(8, 8))
image = lumivox.render([scan, scan], preset=["ct-bone", "ct-skin"], environment=Environment("uniform", color=vector))
for part in lumivox.progressive(scene, camera=camera, region=(0, 0, 4, 4)):
    picture: np.ndarray = np.asarray(part)
"""


def test_documented_forms_are_right_to_type_checkers(tmp_path: Path) -> None:
    file = tmp_path / "forms.py"
    file.write_text(TYPED)
    arguments = ["--strict", "--follow-imports=silent", "--no-incremental", str(file)]
    done = subprocess.run([sys.executable, "-m", "mypy", *arguments], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout
    wrong = file.with_name("wrong.py")
    wrong.write_text("import lumivox\nlumivox.render(lumivox.phantom(), samples='many', azimut=3)\n")
    done = subprocess.run(
        [sys.executable, "-m", "mypy", *arguments[:-1], str(wrong)], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert "azimut" in done.stdout and '"samples"' in done.stdout, "options have their types"


def test_types_can_be_asked_for() -> None:
    asked = [getattr(lumivox, name) for name in lumivox.__all__] + [getattr(cluster, name) for name in cluster.__all__]
    asked += [value for name, value in vars(interop).items() if name.startswith(("to_", "from_"))]
    functions = 0
    for thing in asked:
        members = [thing, *vars(thing).values()] if inspect.isclass(thing) else [thing]
        for member in members:
            inner = getattr(member, "__func__", getattr(member, "fget", member))
            if inspect.isfunction(inner) or inspect.isclass(inner):
                typing.get_type_hints(inner)
                functions += 1
    assert functions > 100


def test_options_are_completed() -> None:
    for function in (lumivox.render, lumivox.progressive, lumivox.Renderer.render, cluster.render, cluster.film):
        given = inspect.signature(function).parameters
        assert {"preset", "azimuth", "samples", "clip_shape"} <= given.keys()
        assert given["preset"].kind is inspect.Parameter.KEYWORD_ONLY


def test_signatures_are_read_by_people() -> None:
    for function in (lumivox.render, lumivox.progressive, lumivox.Renderer.render, cluster.render, cluster.film):
        words = str(inspect.signature(function))
        assert "ForwardRef" not in words and "Ellipsis" not in words and "..." not in words, words
        for part in ("preset=None", "azimuth=None", "zoom=1.0", "size=(768, 768)", "gamma=1.0", "background='#14171c'"):
            assert part in words, words
    first = pydoc.plain(pydoc.render_doc(lumivox.render)).split("Renders a scan")[0]
    assert "render(scan, *, preset=None, transfer_function=None, shift=0.0" in " ".join(first.split()) and len(first) < 1600


def test_what_is_pickled_is_the_same(head: lumivox.Volume, head_folder: Path) -> None:
    scan = lumivox.load(head_folder)
    labels = lumivox.Labels.from_volume(lumivox.Volume.from_array((head.values > 200).astype(np.uint8)), names={1: "bone"})
    light = lumivox.EnvironmentMap(np.ones((2, 4, 3)))
    scene = lumivox.Scene.of(scan, preset="ct-bone", labels=labels, label={"bone": "hide"}, environment=light, peel_mm=2.0)
    for thing in (scan, labels, light, scene, lumivox.Camera.framing(scene)):
        twin = pickle.loads(pickle.dumps(thing))
        assert twin == thing and hash(twin) == hash(thing), type(thing)
        assert copy.deepcopy(thing) == thing
    twin = pickle.loads(pickle.dumps(scan))
    assert twin.report == scan.report is not None
    assert copy.copy(scan) is scan and copy.deepcopy(scan) is scan, "no voxels are copied"
    other = lumivox.Volume.from_array(scan.array + np.uint16(1), scan.spacing, scan.origin, modality="CT")
    assert other != scan and scan != "scan"
    assert lumivox.Volume.from_array(scan.array, scan.spacing, (1, 2, 3), modality="CT") != scan


def test_numpy_sees_numbers(head: lumivox.Volume) -> None:
    assert np.asarray(head).dtype == np.float32 and np.array_equal(np.asarray(head), head.values)
    assert np.asarray(head, dtype=np.int16).dtype == np.int16
    image = lumivox.render(head, size=(8, 6), samples=2)
    assert np.asarray(image).shape == (6, 8, 4)
    labels = head.segment().labels
    assert labels is not None and np.asarray(labels).shape == head.shape
    assert "8 x 6 pixels, 2 samples" in repr(image)
    tiny = lumivox.Volume.from_array(np.zeros((2, 2, 2), np.uint8), (2e-3, 2e-3, 5e-3))
    assert "0.002 x 0.002 x 0.005 mm" in repr(tiny)


def test_modules_are_there_when_they_are_asked_for(python: str) -> None:
    code = "import lumivox; lumivox.cluster.render; lumivox.interop.to_sitk; lumivox.nothing"
    flags = ["-P"] if sys.version_info >= (3, 11) else []
    done = subprocess.run([python, *flags, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 1 and "module 'lumivox' has no attribute 'nothing'" in done.stderr


@pytest.mark.parametrize(
    "load",
    [
        lumivox.load,
        lumivox.scan,
        lumivox.load_labels,
        lumivox.load_transfer_function,
        lumivox.EnvironmentMap.load,
    ],
)
def test_a_missing_file_is_the_systems_error_too(load: typing.Callable[[str], object], tmp_path: Path) -> None:
    missing = str(tmp_path / "nothing.exr")
    with pytest.raises(FileNotFoundError, match="nothing") as caught:
        load(missing)
    error = caught.value
    assert isinstance(error, lumivox.MissingFileError) and isinstance(error, lumivox.ScanError)
    assert os.fspath(error.filename) == missing and "Errno" not in str(error)
    assert str(pickle.loads(pickle.dumps(error))) == str(error)
    (tmp_path / "text.exr").write_text("nothing of ours")
    with pytest.raises(lumivox.ScanError) as caught:
        load(str(tmp_path / "text.exr"))
    assert not isinstance(caught.value, OSError), "it is there"
