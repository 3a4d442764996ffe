"""Images of SimpleITK, nibabel, xarray and MONAI, in and out: places in the patient above all."""

from __future__ import annotations

import itertools
import warnings
from pathlib import Path
from types import SimpleNamespace

import nibabel
import numpy as np
import pytest
import SimpleITK as sitk
import xarray

import lumivox

CORNERS = np.array([[0, 0, 0, 1], [3, 0, 0, 1], [0, 2, 0, 1], [0, 0, 1, 1]], float).T


def oblique() -> lumivox.Volume:
    """A CT whose axes are along none of the patient's, and of which all values differ."""
    angle = np.radians(20)
    turn = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]])
    direction = turn @ np.array([[0, 0, 1], [1, 0, 0], [0, -1, 0]], float)
    values = np.arange(24, dtype=np.int16).reshape(2, 3, 4) * 100 - 1000
    return lumivox.Volume.from_array(values, (0.7, 0.8, 2.5), (-12.0, 34.0, -56.0), direction, "CT")


def same(a: lumivox.Volume, b: lumivox.Volume) -> None:
    np.testing.assert_array_equal(a.values, b.values)
    np.testing.assert_allclose(a.patient_from_voxel, b.patient_from_voxel, atol=1e-5)


def voxels(volume: lumivox.Volume) -> dict[float, np.ndarray]:
    """Where each value lies in the patient."""
    z, y, x = np.indices(volume.shape).reshape(3, -1)
    places = volume.patient_from_voxel[:3] @ np.stack([x, y, z, np.ones(x.size)])
    return dict(zip(volume.values.ravel().tolist(), places.T, strict=True))


def lie_where_they_did(part: lumivox.Volume, whole: lumivox.Volume) -> None:
    """Of values that all differ, each lies where it lay."""
    before = voxels(whole)
    for value, place in voxels(part).items():
        np.testing.assert_allclose(place, before[value], atol=1e-4)


CUTS = [slice(None), slice(None, None, -1), slice(1, None), slice(None, None, 2), slice(None, 0, -1)]
"""Along an axis: all, flipped, a part, every second, a part that is flipped."""


@pytest.mark.parametrize("cuts", list(itertools.product(CUTS, repeat=3))[::3])
def test_parts_and_flips_of_other_libraries_images_lie_where_they_did(cuts: tuple[slice, slice, slice]) -> None:
    angle = np.radians(20)
    turn = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]])
    values = np.arange(60, dtype=np.int16).reshape(3, 4, 5) * 7 - 200
    whole = lumivox.Volume.from_array(values, (0.7, 0.8, 2.5), (-12.0, 34.0, -56.0), turn, "MR")
    x, y, z = cuts
    lie_where_they_did(lumivox.Volume.from_xarray(whole.to_xarray()[z, y, x]), whole)
    if all(abs(cut.indices(9)[2]) == 1 for cut in cuts):
        lie_where_they_did(lumivox.Volume.from_sitk(whole.to_sitk()[x, y, z], "MR"), whole)
    if all(cut.indices(9)[2] > 0 for cut in cuts):
        # Of an axis that is flipped, nibabel's slicer keeps the place of the first voxel: `as_reoriented` turns them, below.
        lie_where_they_did(lumivox.Volume.from_nibabel(whole.to_nibabel().slicer[x, y, z], "MR"), whole)


def test_all_orders_and_directions_of_axes_lie_where_they_did() -> None:
    whole = oblique()
    for order, signs in itertools.product(itertools.permutations(range(3)), itertools.product((1, -1), repeat=3)):
        turned = whole.to_nibabel().as_reoriented(np.stack([order, signs], axis=1))
        lie_where_they_did(lumivox.Volume.from_nibabel(turned, "CT"), whole)
        image = sitk.Flip(sitk.PermuteAxes(whole.to_sitk(), order), [sign < 0 for sign in signs])
        lie_where_they_did(lumivox.Volume.from_sitk(image), whole)


def test_an_image_is_the_volume_of_its_file(tmp_path: Path) -> None:
    """Units, codes, scales, NaN and all: by a library and by the file, it is one scan."""
    rng = np.random.default_rng(1)
    values = rng.normal(0.0, 1.0, (5, 4, 3)).astype(np.float32)
    holes = values.copy()
    holes[1, 2, 0], holes[0, 0, 0], holes[4, 3, 2] = np.nan, np.inf, -np.inf
    affine = np.array([[0.0, -0.7, 0, 3], [0.8, 0, 0, -9], [0, 0, 2.5, 14], [0, 0, 0, 1]])
    cases: dict[str, nibabel.Nifti1Image] = {
        "plain": nibabel.Nifti1Image(values, affine),
        "holes": nibabel.Nifti1Image(holes, affine),
        "doubles": nibabel.Nifti1Image(np.where(holes > 2.0, 1e300, values.astype(np.float64)), affine),
        "four": nibabel.Nifti1Image(values[..., None], affine),
        "hounsfield": nibabel.Nifti1Image((values * 900).astype(np.int16) + np.int16(200), affine),
        "big": nibabel.Nifti1Image((values * 100).astype(">i4"), affine),
        "two": nibabel.Nifti2Image(values, affine),
    }
    cases["hounsfield"].dataobj[0, 0, 0] = -1024
    for unit in ("meter", "micron", "unknown"):
        cases[unit] = nibabel.Nifti1Image(values, np.diag([0.001, 0.002, 0.003, 1]) if unit == "meter" else affine)
        cases[unit].header.set_xyzt_units(unit)
    nobody = nibabel.Nifti1Image(values, None)
    nobody.header.set_zooms((0.5, 0.6, 0.7))
    nobody.set_sform(None, 0)
    nobody.set_qform(None, 0)
    cases["nobody"] = nobody
    cases["nowhere"] = nibabel.Nifti1Image(values, None)
    for name, image in cases.items():
        path = tmp_path / f"{name}.nii"
        nibabel.save(image, path)
        read = nibabel.load(path)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            ours, theirs = lumivox.load(path, keep="everything"), lumivox.Volume.from_nibabel(read)
        assert (ours.shape, ours.modality, ours.unit) == (theirs.shape, theirs.modality, theirs.unit), name
        np.testing.assert_array_equal(ours.values, theirs.values, name)
        # A NIfTI's numbers are of 32 bits, and rounded there by one of them.
        np.testing.assert_allclose(ours.patient_from_voxel, theirs.patient_from_voxel, 1e-5, 1e-5, err_msg=name)
        if name in ("holes", "doubles"):
            with pytest.warns(UserWarning, match="NaN, infinite or too large"):
                lumivox.Volume.from_nibabel(read)
        if name in ("plain", "hounsfield", "unknown", "big"):
            same(ours, lumivox.Volume.from_sitk(sitk.ReadImage(str(path))))
    assert lumivox.Volume.from_nibabel(cases["hounsfield"]).modality == "CT"
    with pytest.raises(ValueError, match=r"choose one, such as image\.slicer"):
        lumivox.Volume.from_nibabel(nibabel.Nifti1Image(np.zeros((2, 3, 4, 5), np.uint8), affine))


def test_an_image_without_a_place_is_told_as_its_file_is(tmp_path: Path) -> None:
    values = np.arange(24, dtype=np.int16).reshape(2, 3, 4)
    nowhere, sized = nibabel.Nifti1Image(values, None), nibabel.Nifti1Image(values, None)
    sized.header.set_zooms((0.5, 0.6, 0.7))
    for image in (nowhere, sized):
        nibabel.save(image, tmp_path / "nowhere.nii")
        file = lumivox.load(tmp_path / "nowhere.nii")
        assert file.report is not None
        (note,) = (note for note in file.report["notes"] if "orientation" in note)
        with pytest.warns(UserWarning) as told:
            volume = lumivox.Volume.from_nibabel(image)
        assert [str(one.message) for one in told] == [note] and told[0].filename == __file__
        same(file, volume)
    # A header that has a place is asked, where the image was not told.
    placed = nibabel.Nifti1Image(values, None)
    placed.header.set_sform(np.diag([2.0, 3.0, 4.0, 1.0]), 1)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert lumivox.Volume.from_nibabel(placed).spacing == (2.0, 3.0, 4.0)


def test_what_is_no_number_is_mended_and_told_wherever_it_comes_from() -> None:
    values = np.ones((2, 3, 4), np.float32)
    values[0, 0, 0], values[1, 1, 1] = np.nan, 5.0
    twin = values.copy()
    twin[0, 0, 0] = 1.0
    image = sitk.GetImageFromArray(values)
    makers = {
        "array": lambda: lumivox.Volume.from_array(values),
        "SimpleITK": lambda: lumivox.Volume.from_sitk(image),
        "xarray": lambda: lumivox.Volume.from_xarray(xarray.DataArray(values, dims=("z", "y", "x"))),
        "MONAI": lambda: lumivox.Volume.from_monai(Tensor(values.T, np.eye(4))),
    }
    for name, make in makers.items():
        with pytest.warns(UserWarning, match="1 of 24 samples are NaN") as told:
            volume = make()
        assert told[0].filename == __file__, "at the line that asked"
        np.testing.assert_array_equal(volume.values, twin)
        assert volume.report is not None and volume.report["format"] == name
    with pytest.raises(lumivox.ScanError, match="the array: the image data holds not one finite number"):
        lumivox.Volume.from_array(values * np.nan)


def test_coordinates_of_xarray_are_in_their_unit() -> None:
    array = oblique().to_xarray()
    metres = array.assign_coords({axis: array.coords[axis] / 1000.0 for axis in "xyz"})
    for axis in "xyz":
        metres.coords[axis].attrs["units"] = "m"
    same(oblique(), lumivox.Volume.from_xarray(metres))
    metres.coords["x"].attrs["units"] = "degrees_east"
    with pytest.raises(ValueError, match="the coordinates along x are in 'degrees_east', which is no length"):
        lumivox.Volume.from_xarray(metres)
    bare = array.drop_vars(["x", "y", "z"])
    same(oblique(), lumivox.Volume.from_xarray(bare))
    with pytest.raises(ValueError, match="patient_from_voxel must be 4 x 4 numbers"):
        lumivox.Volume.from_xarray(bare.assign_attrs(patient_from_voxel="here"))


def test_integers_go_out_as_integers() -> None:
    volume = oblique()
    assert volume.integers is not None and volume.integers.dtype == np.int16
    np.testing.assert_array_equal(volume.integers, volume.values)
    assert volume.to_sitk().GetPixelID() == sitk.sitkInt16
    assert volume.to_nibabel().get_data_dtype() == np.int16
    halves = lumivox.Volume.from_array(np.arange(8).reshape(2, 2, 2), slope=0.5)
    assert halves.integers is None and halves.to_sitk().GetPixelID() == sitk.sitkFloat32
    wide = lumivox.Volume.from_array(np.array([[[0, 65535]]], np.uint16))
    assert wide.integers is None and wide.to_sitk().GetPixel(1, 0, 0) == 65535.0


def test_simpleitk_places_voxels_where_lumivox_does() -> None:
    volume = oblique()
    image = volume.to_sitk()
    for corner in CORNERS.T[:, :3]:
        expected = volume.patient_from_voxel @ [*corner, 1]
        np.testing.assert_allclose(image.TransformContinuousIndexToPhysicalPoint(corner.tolist()), expected[:3], atol=1e-5)
    assert image.GetPixel(3, 2, 1) == volume.values[1, 2, 3]
    back = lumivox.Volume.from_sitk(image)
    same(volume, back)
    assert back.modality == "CT" and back.unit == "HU"
    signed = sitk.Cast(image, sitk.sitkInt16)
    assert lumivox.Volume.from_sitk(signed, "CT").array.dtype == np.uint16
    with pytest.raises(ValueError, match="3 dimensions and 1 component"):
        lumivox.Volume.from_sitk(sitk.Image(4, 4, sitk.sitkInt16))


def test_nibabel_places_voxels_in_ras(tmp_path) -> None:
    volume = oblique()
    image = volume.to_nibabel()
    ours, theirs = volume.patient_from_voxel @ CORNERS, image.affine @ CORNERS
    np.testing.assert_allclose(theirs, np.diag([-1, -1, 1, 1]) @ ours, atol=1e-5)
    assert image.get_fdata()[3, 2, 1] == volume.values[1, 2, 3]
    same(volume, lumivox.Volume.from_nibabel(image, "CT"))
    nibabel.save(image, tmp_path / "a.nii.gz")
    # Three readers of one file.
    same(volume, lumivox.Volume.from_nibabel(nibabel.load(tmp_path / "a.nii.gz"), "CT"))
    same(volume, lumivox.load(tmp_path / "a.nii.gz", keep="everything"))
    same(volume, lumivox.Volume.from_sitk(sitk.ReadImage(str(tmp_path / "a.nii.gz"))))


def test_nibabels_scaled_integers_stay_integers(tmp_path) -> None:
    image = nibabel.Nifti1Image(np.arange(24, dtype=np.int16).reshape(4, 3, 2), np.eye(4))
    image.header.set_slope_inter(2.0, -1000.0)
    nibabel.save(image, tmp_path / "a.nii")
    loaded = nibabel.load(tmp_path / "a.nii")
    volume = lumivox.Volume.from_nibabel(loaded)
    assert volume.array.dtype == np.uint16 and volume.slope == 2.0
    np.testing.assert_array_equal(volume.values, loaded.get_fdata().T)


def test_xarray_keeps_the_place() -> None:
    volume = oblique()
    array = volume.to_xarray()
    assert isinstance(array, xarray.DataArray) and array.dims == ("z", "y", "x")
    same(volume, lumivox.Volume.from_xarray(array.transpose("x", "z", "y")))
    assert lumivox.Volume.from_xarray(array).unit == "HU"
    plain = xarray.DataArray(
        np.zeros((2, 3, 4)), {"x": [5.0, 6.5, 8.0, 9.5], "y": [0.0, -2.0, -4.0], "z": [1.0, 4.0]}, ("z", "y", "x")
    )
    placed = lumivox.Volume.from_xarray(plain)
    np.testing.assert_allclose(placed.patient_from_voxel @ [3, 2, 1, 1], [9.5, -4.0, 4.0, 1.0])
    with pytest.raises(ValueError, match="along x are not evenly spaced"):
        lumivox.Volume.from_xarray(plain.assign_coords(x=[0.0, 1.0, 2.0, 9.0]))
    with pytest.raises(ValueError, match="dimensions x, y and z are needed, not t, y, x"):
        lumivox.Volume.from_xarray(plain.rename(z="t"))


class Tensor:
    """What Lumivox asks of a tensor of MONAI's, which needs torch: too large for these tests. A stand-in."""

    def __init__(self, values: np.ndarray, affine: np.ndarray | None = None) -> None:
        self.values, self._affine = values, affine

    @property
    def affine(self) -> Tensor:
        assert self._affine is not None
        return Tensor(self._affine)

    def detach(self) -> Tensor:
        return self

    def cpu(self) -> Tensor:
        return self

    def numpy(self) -> np.ndarray:
        return self.values


def test_monais_tensors_are_in_ras() -> None:
    volume = oblique()
    twin = volume.to_nibabel()
    tensor = Tensor(np.asarray(twin.dataobj)[None], twin.affine)
    same(volume, lumivox.Volume.from_monai(tensor, "CT"))
    same(volume, lumivox.Volume.from_monai(Tensor(np.asarray(twin.dataobj), twin.affine), "CT"))
    # MONAI's readers say which space an affine is to; without the turn it is LPS.
    for space in ("LPS", SimpleNamespace(value="LPS"), "lps"):
        other = Tensor(np.asarray(twin.dataobj), np.diag([-1.0, -1.0, 1.0, 1.0]) @ twin.affine)
        other.meta = {"space": space}
        same(volume, lumivox.Volume.from_monai(other, "CT"))
    other.meta = {"space": "screen"}
    with pytest.raises(ValueError, match="must be RAS or LPS, not 'SCREEN'"):
        lumivox.Volume.from_monai(other, "CT")
    with pytest.raises(ValueError, match="3 dimensions"):
        lumivox.Volume.from_monai(Tensor(np.zeros((2, 3, 4, 5)), twin.affine))


def test_monais_tensors_are_made_in_ras(monkeypatch: pytest.MonkeyPatch) -> None:
    # MONAI and torch as far as they are asked: what reaches them is checked.
    def made(values: np.ndarray, affine: np.ndarray) -> SimpleNamespace:
        return SimpleNamespace(values=values, affine=affine)

    monkeypatch.setitem(__import__("sys").modules, "torch", SimpleNamespace(from_numpy=lambda array: array))
    monkeypatch.setitem(__import__("sys").modules, "monai", SimpleNamespace())
    monkeypatch.setitem(__import__("sys").modules, "monai.data", SimpleNamespace(MetaTensor=made))
    volume = oblique()
    tensor = volume.to_monai()
    assert tensor.values.shape == (1, 4, 3, 2)
    np.testing.assert_array_equal(tensor.values[0], np.asarray(volume.to_nibabel().dataobj))
    np.testing.assert_allclose(tensor.affine, volume.to_nibabel().affine)


def test_a_tilted_gantry_stays_tilted_where_it_can() -> None:
    shear = np.eye(4)
    shear[1, 2] = 0.3
    image = nibabel.Nifti1Image(np.zeros((2, 2, 2), np.float32), shear)
    volume = lumivox.Volume.from_nibabel(image)
    np.testing.assert_allclose(volume.to_nibabel().affine, shear)
    np.testing.assert_allclose(lumivox.Volume.from_xarray(volume.to_xarray()).patient_from_voxel, volume.patient_from_voxel)
    with pytest.raises(ValueError, match="sheared"):
        volume.to_sitk()
