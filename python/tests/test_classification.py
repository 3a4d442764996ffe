"""Labels, clip shapes, peeling and functions of value and gradient: the command's pictures, and physics that is known."""

from __future__ import annotations

import pickle
import subprocess
import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import SimpleITK as sitk
from conftest import block, white

import lumivox
from lumivox import classification, rendering

SIZE = (32, 32)


@pytest.fixture(scope="module")
def torso() -> lumivox.Volume:
    """A torso as a CT sees it, with what is found in it."""
    return lumivox.phantom("torso", 64).patient_alone()


@pytest.fixture(scope="module")
def torso_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The torso as a DICOM series, with its table."""
    folder = tmp_path_factory.mktemp("scans") / "torso"
    lumivox.write_dicom_series(lumivox.phantom("torso", 96), folder)
    return folder


def halves(volume: lumivox.Volume) -> lumivox.Labels:
    """Left and right of a block."""
    array = np.ones(volume.shape, np.uint8)
    array[..., volume.shape[2] // 2 :] = 2
    return lumivox.Labels.from_array(array, like=volume, names={1: "Right", 2: "left"}, colors={2: "#ff0000"})


def seen(instance: lumivox.VolumeInstance, samples: int = 4) -> lumivox.Image:
    """A block from the front, as if from far away."""
    scene = lumivox.Scene((instance,), lumivox.Environment("uniform"))
    camera = lumivox.Camera.look_at((0, 0, 1e5), (0, 0, 0), fov=0.05)
    return lumivox.render(scene, camera=camera, size=SIZE, samples=samples)


def test_labels_are_hidden_coloured_and_thinned_where_they_are() -> None:
    # x runs to the right of the picture, which is the patient's left.
    volume = block()
    labels = halves(volume)
    # Beyond their grid, which ends where the block does, nothing has a label: the faces are of it in part.
    beyond = {"unlabelled": "hide"}
    whole = seen(lumivox.VolumeInstance(volume, white(1.0)))
    hidden = seen(lumivox.VolumeInstance(volume, white(1.0), labels=labels, label_styles={**beyond, "right": "hide"}))
    assert whole.alpha[16, 8] == 1.0 and hidden.alpha[16, 8] == 0.0 and hidden.alpha[16, 24] == 1.0
    red = seen(lumivox.VolumeInstance(volume, white(1.0), labels=labels, label_styles={**beyond, "left": "color"}))
    assert red.radiance[16, 24, 0] > 0.5 and red.radiance[16, 24, 1] == 0.0
    # The white half has all of the red, and of the rest what did not meet the red half.
    np.testing.assert_allclose(red.radiance[16, 8, 0], 1.0, atol=1e-3)
    assert red.radiance[11:21, 6:10, 1].mean() > 0.6
    thin = lumivox.LabelStyle(opacity=0.5, density=0.02)
    thinned = seen(lumivox.VolumeInstance(volume, white(1.0), labels=labels, label_styles={**beyond, 2: thin}), 64)
    # 64 mm of an extinction of 0.01 per mm; a mean over 50 pixels of 64 samples.
    expected, found = 1.0 - np.exp(-0.64), thinned.alpha[11:21, 22:27]
    assert abs(found.mean() - expected) < 5 * np.sqrt(expected * (1 - expected) / (found.size * 64))


def test_clip_shapes_keep_what_they_say_in_either_space() -> None:
    volume = block()
    cut = lumivox.ClipShape

    def alpha(*shapes: lumivox.ClipShape, **other: object) -> np.ndarray:
        return seen(lumivox.VolumeInstance(volume, white(1.0), clip_shapes=shapes, **other)).alpha  # type: ignore[arg-type]

    right_gone = alpha(cut.plane((0, 0, 0), (1, 0, 0)))
    assert right_gone[16, 8] == 0.0 and right_gone[16, 24] == 1.0
    np.testing.assert_array_equal(
        alpha(cut.plane((0, 0, 0), (1, 0, 0)).invert()) > 0.5, alpha(cut.plane((0, 0, 0), (-1, 0, 0))) > 0.5
    )
    corner = alpha(cut.box((0, 0, -99), (99, 99, 99)))
    assert corner[8, 24] == 1.0 and corner[24, 24] == 0.0 and corner[8, 8] == 0.0
    ball = alpha(cut.sphere((0, 0, 0), 10.0))
    assert ball[16, 16] == 1.0 and ball[8, 8] == 0.0 and 0.02 < ball.mean() < 0.2
    # Of the patient's millimetres, in which the block's corner voxel is the origin: its middle is at 30.
    np.testing.assert_array_equal(alpha(cut.sphere((30, 30, 30), 10.0, space="patient")), ball)
    # Two shapes keep what both keep, and labels may be spared.
    both = alpha(cut.plane((0, 0, 0), (1, 0, 0)), cut.plane((0, 0, 0), (-1, 0, 0)).invert())
    assert both[16, 8] == 0.0 and both[16, 24] == 1.0
    spared = alpha(cut.plane((0, 0, 99), (0, 0, 1)), labels=halves(volume), label_styles={"left": "uncut"})
    assert spared[16, 24] == 1.0 and spared[16, 8] == 0.0


@pytest.mark.parametrize(
    ("arguments", "options"),
    [
        (
            ["--labels", "found", "--label", "*=opacity:0.1", "--label", "lungs=show,opacity:1,color", "--preset", "ct-muscle"],
            {"labels": "found", "label": {"*": "opacity:0.1", "lungs": "show,opacity:1,color"}, "preset": "ct-muscle"},
        ),
        (
            ["--labels", "found", "--label", "lungs=hide", "--label", "2=color:#c04030", "--label", "body=preset:ct-bone,matte"],
            {"labels": "found", "label": {"lungs": "hide", 2: "color:#c04030", "body": "preset:ct-bone,matte"}},
        ),
        (
            ["--clip-shape", "plane:0,0,20,0,0,-1", "--clip-shape", "!sphere:30,0,0,60", "--preset", "ct-skin"],
            {
                "clip_shape": [
                    lumivox.ClipShape.plane((0, 0, 20), (0, 0, -1)),
                    lumivox.ClipShape.sphere((30, 0, 0), 60).invert(),
                ],
                "preset": "ct-skin",
            },
        ),
        (["--preset", "ct-airways"], {"preset": "ct-airways"}),
    ],
)
def test_a_picture_is_the_commands_to_the_last_bit(
    command: str, torso_folder: Path, tmp_path: Path, arguments: list[str], options: dict[str, object]
) -> None:
    usual = ["--size", "48x40", "--samples", "4", "-o", str(tmp_path / "command.png"), "--quiet"]
    subprocess.run([command, "render", str(torso_folder), *arguments, *usual], check=True)
    image = lumivox.render(lumivox.load(torso_folder), size=(48, 40), samples=4, **options)  # type: ignore[arg-type]
    assert image.alpha.max() > 0.0, "something is seen"
    image.save(tmp_path / "python.png")
    assert (tmp_path / "python.png").read_bytes() == (tmp_path / "command.png").read_bytes()


def test_labels_of_files_are_the_commands(command: str, torso_folder: Path, tmp_path: Path) -> None:
    scan = lumivox.load(torso_folder)
    bone = sitk.GetImageFromArray((scan.values > 250).astype(np.uint8) * 7)
    bone.SetSpacing(scan.spacing)
    bone.SetOrigin(scan.origin)
    sitk.WriteImage(bone, tmp_path / "bone.nrrd")
    (tmp_path / "bone.txt").write_text("7 skeleton 200 30 30 255\n")
    labels = lumivox.load_labels(tmp_path / "bone.nrrd")
    assert labels.names == ["skeleton"] and labels.labels[0].value == 7 and labels.sure
    assert labels.report is not None and labels.report["format"] == "NRRD"
    np.testing.assert_array_equal(labels.mask("skeleton"), scan.values > 250)
    arguments = ["--labels", str(tmp_path / "bone.nrrd"), "--label", "unlabelled=opacity:0.02", "--label", "skeleton=color"]
    usual = ["--size", "48x40", "--samples", "4", "-o", str(tmp_path / "command.png"), "--quiet"]
    subprocess.run([command, "render", str(torso_folder), *arguments, *usual], check=True)
    styles = {"unlabelled": lumivox.LabelStyle(opacity=0.02), "skeleton": lumivox.LabelStyle(color="own")}
    for given in (labels, tmp_path / "bone.nrrd"):
        image = lumivox.render(scan, labels=given, label=styles, size=(48, 40), samples=4)
        assert image._repr_png_() == (tmp_path / "command.png").read_bytes()
    with pytest.raises(lumivox.ScanError, match="a DICOM series of images, no segmentation"):
        lumivox.load_labels(torso_folder / sorted(path.name for path in torso_folder.iterdir())[0])


def test_labels_go_by_the_numbers_of_their_file(tmp_path: Path) -> None:
    values = np.zeros((4, 4, 4), np.uint16)
    values[0], values[1] = 1000, 2
    sitk.WriteImage(sitk.GetImageFromArray(values), tmp_path / "atlas.nrrd")
    (tmp_path / "atlas.txt").write_text("2 vein 30 30 200 255\n1000 aorta 200 30 30 255\n")
    atlas = lumivox.load_labels(tmp_path / "atlas.nrrd")
    assert atlas.numbers.keys() == {2, 1000}
    (vein,), (aorta,) = atlas.numbers[2], atlas.numbers[1000]
    np.testing.assert_array_equal(np.asarray(atlas.array) == aorta, values == 1000)
    # A word is a name or a number of the file, an int a value of the array.
    assert atlas.values_of("2") == [vein] and atlas.values_of("#1000") == atlas.values_of("aorta") == [aorta]
    assert atlas.values_of(aorta) == [aorta] and sorted(atlas.values_of("*")) == [0, *sorted((vein, aorta))]
    copy = pickle.loads(pickle.dumps(atlas))
    assert copy.numbers == atlas.numbers and copy.values_of("#1000") == [aorta]
    for unknown in (1000, "7", "#aorta", True):
        with pytest.raises(ValueError, match="there is no such label; there are"):
            atlas.values_of(unknown)


def test_labels_lie_where_they_say_on_any_grid(torso: lumivox.Volume) -> None:
    found = torso.labels
    assert found is not None and found.shape == torso.shape
    # The lungs of half the resolution are where the lungs are.
    coarse = found.mask("lungs")[::2, ::2, ::2]
    spacing = tuple(2 * mm for mm in torso.spacing)
    half = lumivox.Labels.from_array(coarse, spacing, torso.origin, torso.orientation, names={1: "lungs"})
    assert abs(half.ml("lungs") / found.ml("lungs") - 1.0) < 0.05
    low, high = half.bounds("LUNGS") or pytest.fail("there are lungs")
    for own, other in zip(found.bounds("lungs") or (), (low, high), strict=True):
        np.testing.assert_allclose(own, other, atol=2.1 * max(torso.spacing))
    centre = torso.patient_from_voxel @ [*((np.array(torso.shape[::-1]) - 1) / 2), 1.0]
    assert np.all(np.array(low) < centre[:3]) and np.all(np.array(high) > centre[:3])
    assert half.bounds(1) == (low, high) and half.bounds("unlabelled") is not None
    copy = pickle.loads(pickle.dumps(half))
    np.testing.assert_array_equal(copy.array, half.array)
    assert copy.labels == half.labels and copy.names == ["lungs"] and (copy.patient_from_voxel == half.patient_from_voxel).all()
    assert not half.array.flags.writeable and half.array.base is not None
    again = lumivox.Labels.from_volume(lumivox.Volume.from_sitk(torso.to_sitk()[::2, ::2, ::2] > 400), names={1: "metal"})
    assert again.names == ["metal"]


def test_sliding_a_shape_or_peeling_sends_no_voxels_again(torso: lumivox.Volume) -> None:
    renderer = lumivox.Renderer()
    labels = halves(torso)
    options: rendering.Options = {"size": (16, 16), "samples": 1}
    scene = lumivox.Scene.of(torso, labels=labels, label={"left": "opacity:0.5"}, peel_mm=3.0, preset="ct-skin")
    first = renderer.render(scene, **options)
    # Scan, labels and depth.
    depth = torso.skin_depth()
    assert depth is not None
    assert renderer.uploaded > torso.array.nbytes + labels.array.nbytes + depth.array.nbytes
    for step in range(1, 5):
        instance = scene.volumes[0]
        shape = lumivox.ClipShape.plane((0, 0, 10.0 * step), (0, 0, -1))
        assert instance.peel is not None
        moved = replace(instance, clip_shapes=shape, peel=replace(instance.peel, mm=3.0 + step))
        image = renderer.render(replace(scene, volumes=(moved,)), camera=first.camera, **options)
        # The first time there is a shape at all, tables are written anew, which are none of voxels.
        most = 500_000 if step == 1 else 20_000
        assert renderer.uploaded < most, f"step {step} brought {renderer.uploaded} bytes"
    assert (image.film.sums() != first.film.sums()).any()
    styled = replace(scene.volumes[0], label_styles={"left": "hide"})
    renderer.render(replace(scene, volumes=(styled,)), camera=first.camera, **options)
    assert renderer.uploaded < torso.array.nbytes
    # And what was rendered before changes nothing.
    np.testing.assert_array_equal(renderer.render(scene, **options).film.sums(), first.film.sums())
    plain = lumivox.Scene.of(torso, preset="ct-skin")
    with_labels = renderer.render(scene, **options).film.sums()
    fresh = lumivox.Renderer().render(plain, **options).film.sums()
    np.testing.assert_array_equal(renderer.render(plain, **options).film.sums(), fresh)
    np.testing.assert_array_equal(renderer.render(scene, **options).film.sums(), with_labels)


def test_peeling_while_looking_takes_the_skin_off(torso: lumivox.Volume) -> None:
    options: rendering.Options = {"preset": "ct-skin", "size": (32, 32), "samples": 4}
    whole = lumivox.render(torso, **options)
    peeled = lumivox.render(torso, peel_mm=20.0, camera=whole.camera, **options)
    baked = lumivox.render(torso, peel=20.0, camera=whole.camera, **options)
    met = (whole.alpha > 0.9) & (peeled.alpha > 0.9) & (baked.alpha > 0.9)
    assert met.sum() > 50
    deeper = np.median(peeled.depth[met] - whole.depth[met])
    assert 15.0 < deeper < 60.0, deeper
    # Two ways to the same: voxels that are air, and a kernel that looks the depth up.
    assert abs(np.median(peeled.depth[met] - baked.depth[met])) < 2.0 * max(torso.spacing)
    with pytest.warns(UserWarning, match="nothing is peeled: no skin was found"):
        lumivox.render(block(), peel_mm=5.0, preset="plain", size=(8, 8), samples=1)
    with pytest.warns(UserWarning, match="no lungs with airways were found: all is shown"):
        lumivox.render(block(), preset="ct-airways", size=(8, 8), samples=1)


def test_labels_that_are_shown_and_not_seen_are_told(torso: lumivox.Volume) -> None:
    def told(preset: str, label: classification.Labelled) -> list[str]:
        with warnings.catch_warnings(record=True) as noted:
            warnings.simplefilter("always")
            lumivox.Scene.of(torso, preset=preset, labels="found", label=label)
        assert all(one.filename == __file__ for one in noted), "at the line that asked"
        return [str(one.message) for one in noted]

    (note,) = told("ct-muscle", {"*": "hide", "lungs": "show,color,opacity:1"})
    assert note.startswith("label 'lungs': hardly anything is seen of it") and "preset:NAME" in note
    assert len(told("ct-muscle", {"lungs": lumivox.LabelStyle(color="own")})) == 1
    assert told("ct-muscle", {"body": "color", "*": "opacity:0.5"}) == []
    assert told("ct-muscle", {"lungs": "hide"}) == []
    assert told("ct-muscle", {"lungs": "preset:ct-lung"}) == []
    assert told("ct-lung", {"lungs": "color"}) == []


def test_it_is_told_by_values_wherever_the_grid_of_labels_lies() -> None:
    volume = lumivox.Volume.from_array(np.repeat(np.uint8([10, 200]), 8)[None, None].repeat(16, 0).repeat(16, 1), (2.0, 2.0, 2.0))
    coarse = np.ones((8, 8, 8), np.uint8)
    coarse[..., 4:] = 2
    labels = lumivox.Labels.from_array(coarse, (4.0, 4.0, 4.0), (1.0, 1.0, 1.0), names={1: "thin", 2: "thick"})
    curve = lumivox.TransferFunction([(100, 0.0), (150, 1.0)], [(0, (1, 1, 1))])
    both = {"thin": "color", "thick": "color"}
    with pytest.warns(UserWarning, match="^label 'thin': hardly") as told:
        lumivox.Scene.of(volume, transfer_function=curve, labels=labels, label=both)
    assert len(told) == 1
    # Where gradients show it, it is seen.
    border = lumivox.TransferFunction([(0, 0.5)], [(0, (1, 1, 1))])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        steep = lumivox.TransferFunction(curve.opacity, curve.color, [(40.0, border)])
        lumivox.Scene.of(volume, transfer_function=steep, labels=labels, label=both)


def test_functions_of_value_and_gradient_are_read_built_and_saved(command: str, torso_folder: Path, tmp_path: Path) -> None:
    flat = lumivox.TransferFunction([(-1000, 0.0)], [(0, (1, 1, 1))])
    steep = lumivox.TransferFunction([(-200, 0.0), (200, 0.8, "in-out")], [(0, "#ff8040"), (300, (0.9, 0.8, 0.7))])
    curve = lumivox.TransferFunction(flat.opacity, flat.color, gradients=[(120.0, steep)])
    opacity, color = curve.at([200.0], per_mm=60.0)
    np.testing.assert_allclose(opacity, [0.4])
    np.testing.assert_allclose(color, (np.array(flat.at([200.0])[1]) + steep.at([200.0])[1]) / 2)
    np.testing.assert_array_equal(curve.at([200.0], 1e6)[0], steep.at([200.0])[0])
    path = tmp_path / "borders.json"
    curve.save(path)
    assert lumivox.load_transfer_function(path) == curve and pickle.loads(pickle.dumps(curve)) == curve
    usual = ["--size", "48x40", "--samples", "4", "-o", str(tmp_path / "command.png"), "--quiet"]
    subprocess.run([command, "render", str(torso_folder), "--transfer-function", str(path), *usual], check=True)
    scan = lumivox.load(torso_folder)
    for given in (curve, path):
        image = lumivox.render(scan, transfer_function=given, size=(48, 40), samples=4)
        assert image._repr_png_() == (tmp_path / "command.png").read_bytes()
    # Inside of what is the same everywhere nothing is left: 6 voxels deep, values do not change.
    assert 0.1 < image.alpha.max() <= 1.0
    with pytest.raises(ValueError, match="per_mm is 0, and not a number above 0"):
        lumivox.TransferFunction(flat.opacity, flat.color, [(0, steep)])
    with pytest.raises(ValueError, match="gradients are 33, of which 32 can be told apart"):
        lumivox.TransferFunction(flat.opacity, flat.color, [(i + 1.0, steep) for i in range(33)])
    with pytest.raises(ValueError, match="a row of gradients has none of its own"):
        lumivox.TransferFunction(flat.opacity, flat.color, [(1.0, curve)])
    with pytest.raises(ValueError, match="a label's transfer function has no gradients"):
        lumivox.LabelStyle(transfer_function=curve)


def test_what_makes_no_sense_of_labels_and_shapes_is_told(torso: lumivox.Volume) -> None:
    def fails(kind: type[Exception], words: str, **options: object) -> None:
        with pytest.raises(kind, match=words):
            lumivox.render(torso, size=(8, 8), samples=1, **options)  # type: ignore[arg-type]

    labels = halves(torso)
    fails(TypeError, "there is no option 'clip_shapes'; did you mean 'clip_shape'?", clip_shapes=[])
    fails(TypeError, "there is no option 'label_style'; did you mean 'label'?", label_style={})
    fails(ValueError, "label says how labels look, and there are none", label={"left": "hide"})
    fails(
        ValueError,
        "label liver: there is no such label; there are Right, left, unlabelled",
        labels=labels,
        label={"liver": "hide"},
    )
    fails(ValueError, "'hidden' is none of hide, show, color", labels=labels, label={"left": "hidden"})
    fails(ValueError, "'opacity' wants a number from 0 to 1", labels=labels, label={"left": "opacity:2"})
    fails(ValueError, "'red' is no colour", labels=labels, label={"left": "color:red"})
    fails(ValueError, "there is no preset 'x'", labels=labels, label={"left": "preset:x"})
    fails(TypeError, "label must be a dict of styles", labels=labels, label="left=hide")
    fails(TypeError, "the style of label left must be a lumivox.LabelStyle, or words", labels=labels, label={"left": 3})
    fails(TypeError, "labels must be lumivox.Labels, a file or 'found', not an array", labels=labels.array)
    fails(lumivox.ScanError, "No such file", labels="segmentation.nii")
    fails(
        TypeError, "clip_shape must be a lumivox.ClipShape, or several, not 'plane:0,0,0,1,0,0'", clip_shape="plane:0,0,0,1,0,0"
    )
    fails(ValueError, "clip_shape is given 1025 times, of which 1024", clip_shape=[lumivox.ClipShape.sphere((0, 0, 0), 5)] * 1025)
    fails(ValueError, "peel and peel_mm exclude each other", peel=1, peel_mm=2)
    fails(ValueError, "peel_mm must be 0 to 63, not 70", peel_mm=70)
    elsewhere = lumivox.Labels.from_array(np.ones((4, 4, 4), np.uint8), origin=(5000.0, 0.0, 0.0))
    fails(ValueError, "none of its labels lies in the scan", labels=elsewhere)
    for words, make in {
        "the plane's normal must not be zero": lambda: lumivox.ClipShape.plane((0, 0, 0), (0, 0, 0)),
        "the sphere's radius must be above 0": lambda: lumivox.ClipShape.sphere((0, 0, 0), -1),
        "the box has no inside": lambda: lumivox.ClipShape.box((0, 0, 0), (1, 1, 0)),
        "point must be within 1 km": lambda: lumivox.ClipShape.plane((1e300, 0, 0), (1, 0, 0)),
        "label_styles are of labels": lambda: lumivox.VolumeInstance(torso, white(), label_styles={"a": "hide"}),
        "labels must be 0 to 255, not 0 to 300": lambda: lumivox.Labels.from_array(np.full((2, 2, 2), 300) * [[[0, 1]]]),
        "it holds fractions": lambda: lumivox.Labels.from_array(np.full((2, 2, 2), 0.5)),
        "are not on the grid of a volume of shape": lambda: lumivox.Labels.from_array(np.ones((2, 2, 2), int), like=torso),
        "like is given, and spacing besides": lambda: lumivox.Labels.from_array(np.ones(torso.shape, int), (1, 1, 1), like=torso),
    }.items():
        with pytest.raises(ValueError, match=words):
            make()
    # Half of what is labelled lies beyond the scan.
    x, y, z = torso.origin
    beside = (x + 0.7 * torso.shape[2] * torso.spacing[0], y, z)
    layers, rows, columns = torso.shape
    for shape, words in (
        ((layers - 2, rows, columns), "[67][0-9]% of what is labelled lies beyond the scan"),
        (torso.shape, "as many voxels as the scan along each axis, but lie elsewhere"),
    ):
        shifted = lumivox.Labels.from_array(np.ones(shape, np.uint8), torso.spacing, beside, torso.orientation)
        with pytest.warns(UserWarning, match=words) as told:
            lumivox.render(torso, labels=shifted, size=(8, 8), samples=1)
        assert told[0].filename == __file__, "at the line that asked"


def test_passes_lose_no_light_where_drivers_count_the_turns_of_loops() -> None:
    # Software Vulkan ends loops without a word; what kernels may take has to leave room for the turns they do not count.
    border = lumivox.TransferFunction([(-500, 0.2), (300, 0.9)], [(0, (1, 0.5, 0.3))])
    curve = lumivox.TransferFunction([(-500, 0.0), (300, 0.6)], [(0, (1, 0.8, 0.6))], gradients=[(40.0, border)])
    at_once, one_by_one = (
        lumivox.render(
            lumivox.phantom("head", size=48),
            size=(32, 24),
            samples=16,
            labels="found",
            label={"air outside": "hide"},
            transfer_function=curve,
            pass_samples=passes,
        )
        for passes in (16, 1)
    )
    np.testing.assert_array_equal(at_once.alpha, one_by_one.alpha)
    np.testing.assert_allclose(at_once.radiance, one_by_one.radiance, rtol=1e-4, atol=1e-6)


def test_a_window_moves_all_functions_alike() -> None:
    row = lumivox.TransferFunction([(150, 0.0), (350, 1.0, "in-out")], [(150, "#ff0000")])
    curve = lumivox.TransferFunction([(100, 0.0), (300, 1.0)], [(100, "#ffffff")], gradients=[(10.0, row)])
    wide = curve.windowed(50.0, 2.0)
    assert [knot.value for knot in wide.opacity] == [50.0, 450.0]
    assert [knot.value for knot in wide.gradients[0].transfer_function.opacity] == [150.0, 550.0]
    assert wide.gradients[0].transfer_function.opacity[1].ease == row.opacity[1].ease
    assert curve.windowed() is curve
    head = lumivox.phantom("head", size=32)
    shown = lumivox.render(head, preset="ct-bone", size=(16, 16), samples=4)
    assert shown.alpha.max() > 0.5
    assert lumivox.render(head, preset="ct-bone", size=(16, 16), samples=4, shift=5000).alpha.max() == 0.0
    with pytest.raises(ValueError, match="window_scale"):
        lumivox.render(head, window_scale=0, size=(8, 8), samples=1)
