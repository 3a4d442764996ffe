"""Volumes from arrays and files: places, units, views, cancel, errors."""

from __future__ import annotations

import gc
import json
import os
import pickle
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest

import lumivox


@pytest.mark.parametrize("dtype", ["u1", "i1", "u2", "i2", "i4", "i8", "f4", "f8", ">i2", ">f4", "?"])
def test_values_survive_any_type(dtype: str) -> None:
    array = np.arange(24).reshape(2, 3, 4) % 2 if dtype == "?" else np.arange(24).reshape(2, 3, 4) - 12
    array = array.astype(dtype)
    volume = lumivox.Volume.from_array(array)
    assert volume.shape == (2, 3, 4)
    np.testing.assert_array_equal(volume.values, array.astype(np.float32))


def test_integers_of_any_width_are_stored_in_16_bits_where_they_fit() -> None:
    def stored(array: np.ndarray) -> np.dtype:
        return lumivox.Volume.from_array(array.reshape(1, 1, -1)).array.dtype

    assert stored(np.array([-1024, 3071], np.int32)) == np.uint16
    assert stored(np.array([1 << 20, (1 << 20) + 65535], np.int64)) == np.uint16
    assert stored(np.array([0, 65536], np.int32)) == np.float32
    assert stored(np.array([-32768, 32767], np.int16)) == np.uint16


def test_axes_are_z_y_x_and_all_else_x_y_z() -> None:
    array = np.zeros((4, 3, 2), np.int16)
    array[3, 0, 1] = 7
    direction = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    volume = lumivox.Volume.from_array(array, (0.5, 2.0, 3.0), (10.0, 20.0, 30.0), direction, "CT")
    assert volume.array.shape == (4, 3, 2) and volume.values[3, 0, 1] == 7
    assert volume.spacing == (0.5, 2.0, 3.0) and volume.origin == (10.0, 20.0, 30.0)
    np.testing.assert_allclose(volume.orientation, direction)
    # Voxel (x 1, y 0, z 3): x runs along the patient's y, z along its x.
    place = volume.patient_from_voxel @ [1.0, 0.0, 3.0, 1.0]
    np.testing.assert_allclose(place, [10.0 + 9.0, 20.0 + 0.5, 30.0, 1.0])
    assert (volume.modality, volume.unit) == ("CT", "HU")
    assert lumivox.Volume.from_array(array, modality="CT", unit="mg/ml").unit == "mg/ml"


def test_the_array_is_a_view_that_keeps_the_volume_and_cannot_be_written() -> None:
    volume = lumivox.Volume.from_array(np.arange(64, dtype=np.uint16).reshape(4, 4, 4))
    first, second = volume.array, volume.array
    assert first.__array_interface__["data"][0] == second.__array_interface__["data"][0], "no copy"
    assert not first.flags.writeable and not first.flags.owndata
    with pytest.raises(ValueError):
        first[0, 0, 0] = 1
    with pytest.raises(ValueError):
        first.flags.writeable = True
    del volume, second
    gc.collect()
    # Whoever takes the memory now would be seen.
    _others = [np.full((4, 4, 4), 9, np.uint16) for _ in range(100)]
    np.testing.assert_array_equal(first, np.arange(64).reshape(4, 4, 4))


MEMORY = """
import numpy as np
import lumivox

def peak():
    # Of this program alone; what getrusage says begins with the parent's.
    with open("/proc/self/status") as file:
        return next(int(line.split()[1]) for line in file if line.startswith("VmHWM")) / 1024

given = np.full((128, 512, 512), -1000, np.int16)
given[0, 0, 0] = 3000
before = peak()
volume = lumivox.Volume.from_array(given, modality="CT")
made = peak()
values = volume.values
print(made - before, peak() - made)
"""


def test_arrays_and_values_take_the_memory_of_one_copy(python: str) -> None:
    flags = ["-P"] if sys.version_info >= (3, 11) else []
    done = subprocess.run([python, *flags, "-c", MEMORY], capture_output=True, text=True, check=True)
    made, values = map(float, done.stdout.split())
    # The array is 64 MiB, its values 128.
    assert made < 90 and values < 150, done.stdout


def test_parts_that_make_no_volume_are_told_in_the_words_of_all_hosts() -> None:
    with pytest.raises(lumivox.ScanError, match="a volume needs at least one voxel along each axis"):
        lumivox.Volume.from_array(np.zeros((0, 1, 1)))
    with pytest.raises(lumivox.ScanError, match="patient_from_voxel is not an invertible, finite transform"):
        lumivox.Volume.from_array(np.zeros((1, 1, 1)), orientation=np.zeros((3, 3)))
    for spacing in [(0.0, 1.0, 1.0), (-1.0, 1.0, 1.0), (1.0, 1.0), (np.inf, 1.0, 1.0)]:
        with pytest.raises(ValueError, match="spacing must be three numbers above 0"):
            lumivox.Volume.from_array(np.zeros((1, 1, 1)), spacing=spacing)
    with pytest.raises(ValueError, match="a masked array has values that are not there"):
        lumivox.Volume.from_array(np.ma.masked_less(np.full((2, 2, 2), -1.0), 0.0))
    for none in ["scan.nii", np.zeros((2, 2, 2)), None]:
        with pytest.raises(TypeError, match=r"a lumivox.Volume is needed, not .* makes one"):
            lumivox.render(none)  # type: ignore[arg-type]
    with pytest.raises(lumivox.ScanError, match="the array: the image data holds not one finite number"):
        lumivox.Volume.from_array(np.full((1, 1, 1), np.nan))
    with pytest.raises(ValueError, match="axes z, y, x"):
        lumivox.Volume.from_array(np.zeros((2, 2)))
    with pytest.raises(ValueError, match="real numbers"):
        lumivox.Volume.from_array(np.zeros((2, 2, 2), complex))
    with pytest.raises(ValueError, match="modality 'XY' is not"):
        lumivox.Volume.from_array(np.zeros((2, 2, 2)), modality="XY")


def test_a_series_is_loaded_with_its_report(head: lumivox.Volume, head_folder: Path) -> None:
    stages: list[str] = []
    loaded = lumivox.load(head_folder, keep="everything", progress=lambda stage, done, total: stages.append(stage))
    np.testing.assert_array_equal(loaded.values, head.values)
    np.testing.assert_allclose(loaded.patient_from_voxel, head.patient_from_voxel, atol=1e-3)
    assert loaded.modality == "CT" and loaded.unit == "HU"
    assert "decoding slices" in stages
    report = loaded.report
    assert report is not None and report["format"] == "DICOM" and report["series"][0]["dims"] == [48, 48, 48]
    assert lumivox.scan(head_folder)["series"] == report["series"]
    assert loaded.labels is None


def test_the_patient_alone_is_what_a_load_keeps(head_folder: Path, command: str) -> None:
    kept = lumivox.load(head_folder)
    everything = lumivox.load(head_folder, keep="everything")
    assert kept.note is not None and kept.note.startswith("hidden: ")
    changed = kept.values != everything.values
    assert 0 < changed.sum() < changed.size / 10
    labels = kept.labels
    assert labels is not None and labels.sure and labels.array.shape == (48, 48, 48)
    assert {"body", "air outside"} <= {label.name for label in labels.labels}
    np.testing.assert_array_equal(everything.segment().labels.array, labels.array)  # type: ignore[union-attr]
    info = subprocess.run([command, "import", str(head_folder), "--json"], capture_output=True, check=True)
    assert json.loads(info.stdout)["scans"][0]["series"] == kept.report["series"]  # type: ignore[index]


def test_series_are_chosen_and_missing_ones_named(head_folder: Path) -> None:
    uid = lumivox.scan(head_folder)["series"][0]["uid"]
    by_place = lumivox.load(head_folder, series=1, keep="everything")
    np.testing.assert_array_equal(lumivox.load(head_folder, series=uid, keep="everything").array, by_place.array)
    with pytest.raises(lumivox.ScanError, match="there is no series '7'. It has: "):
        lumivox.load(head_folder, series=7)
    with pytest.raises(lumivox.ScanError, match=r"missing: .*os error 2"):
        lumivox.load(head_folder / "missing")
    with pytest.raises(ValueError, match="keep 'all' is not"):
        lumivox.load(head_folder, keep="all")  # type: ignore[arg-type]


def test_arrays_that_do_not_say_where_they_lie_are_told(tmp_path: Path) -> None:
    array = np.arange(5 * 6 * 7, dtype=np.float32).reshape(5, 6, 7)
    np.save(tmp_path / "a.npy", array)
    bare = lumivox.load(tmp_path / "a.npy")
    assert bare.report is not None and bare.spacing == (1.0, 1.0, 1.0)
    assert any("the option spacing" in note for note in bare.report["notes"]), bare.report["notes"]
    assert not any("--" in note for note in bare.report["notes"]), "options have Python's names"
    told = lumivox.load(tmp_path / "a.npy", spacing=np.array([0.5, 0.6, 2.0]), axes="RAS", layout="xyz")
    assert told.report is not None and told.report["notes"] == ["an array of 7 x 6 x 5, taken as xyz"]
    # Voxels stay where they are in memory: the last axis of the shape is z here, and the first one grows to the right.
    np.testing.assert_array_equal(told.values, array)
    np.testing.assert_allclose(told.patient_from_voxel[:3, :3], [[0, 0, -0.5], [0, -0.6, 0], [2, 0, 0]], atol=1e-9)
    assert lumivox.scan(tmp_path / "a.npy", spacing=(1, 1, 2))["series"][0]["dims"] == [7, 6, 5]
    np.save(tmp_path / "labels.npy", (array > 100).astype(np.uint8))
    labels = lumivox.load_labels(tmp_path / "labels.npy", spacing=(1, 1, 2), axes="LPS")
    assert labels.spacing == (1.0, 1.0, 2.0)


@pytest.mark.parametrize(
    ("word", "known"),
    [("CT", "CT"), ("mr", "MR"), ("PET", "PT"), ("PT", "PT"), ("other", "")],
)
def test_modalities_have_the_same_words_everywhere(word: str, known: str, tmp_path: Path) -> None:
    array = np.arange(24, dtype=np.int16).reshape(2, 3, 4)
    np.save(tmp_path / "a.npy", array)
    made = lumivox.Volume.from_array(array, modality=word)
    assert made.modality == lumivox.load(tmp_path / "a.npy", modality=word).modality == known
    assert lumivox.Volume.from_xarray(made.to_xarray(), word).modality == known


def test_a_pet_lies_where_its_torso_does() -> None:
    pet, torso = lumivox.phantom("torso-pet", 24), lumivox.phantom("torso", 24)
    assert (pet.modality, pet.shape) == ("PT", torso.shape) and pet.value_range[0] >= 0.0
    np.testing.assert_allclose(pet.patient_from_voxel, torso.patient_from_voxel)


def test_what_progress_raises_ends_the_load(head_folder: Path) -> None:
    class Enough(Exception):
        pass

    def stop(stage: str, done: int, total: int) -> None:
        raise Enough(stage)

    with pytest.raises(Enough):
        lumivox.load(head_folder, progress=stop)


def test_ctrl_c_stops_long_work() -> None:
    begin = time.monotonic()
    timer = threading.Timer(0.5, os.kill, (os.getpid(), signal.SIGINT))
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        # Minutes, if nothing stopped it.
        lumivox.phantom("torso", 700)
    timer.join()
    assert time.monotonic() - begin < 20.0


def test_volumes_are_pickled_with_their_labels(head_folder: Path) -> None:
    volume = lumivox.load(head_folder)
    copy = pickle.loads(pickle.dumps(volume, protocol=5))
    np.testing.assert_array_equal(copy.array, volume.array)
    np.testing.assert_array_equal(copy.patient_from_voxel, volume.patient_from_voxel)
    assert (copy.modality, copy.unit, copy.note) == (volume.modality, volume.unit, volume.note)
    assert copy.labels is not None and volume.labels is not None and copy.labels.labels == volume.labels.labels
    np.testing.assert_array_equal(copy.labels.array, volume.labels.array)


def test_presets_and_transfer_functions_are_those_of_the_command(command: str, tmp_path: Path, head: lumivox.Volume) -> None:
    listed = subprocess.run([command, "presets"], capture_output=True, check=True, text=True).stdout
    assert [line.split()[0] for line in listed.splitlines()] == [preset.name for preset in lumivox.presets()]
    with pytest.raises(ValueError, match="there is no preset 'ct-bon'; did you mean 'ct-bone'?"):
        lumivox.render(head, preset="ct-bon")
    curve = lumivox.TransferFunction([(300, 1.0), (100, 0.0, "in-out")], [(0, (1, 0.5, 0))])
    opacity, color = curve.at([100, 200, 300, 999])
    np.testing.assert_allclose(opacity, [0.0, 0.5, 1.0, 1.0])
    np.testing.assert_allclose(color, [[1, 0.5, 0]] * 4)
    curve.save(tmp_path / "a.json")
    assert lumivox.load_transfer_function(tmp_path / "a.json") == curve
    with pytest.raises(ValueError, match="the opacity at 0 is 1.5, and must be 0 to 1"):
        lumivox.TransferFunction([(0, 1.5)], [(0, (0, 0, 0))])
    with pytest.raises(ValueError, match="albedo must be 0 to 1"):
        lumivox.Medium(curve, albedo=1.5)
