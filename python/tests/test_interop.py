"""Images of SimpleITK, nibabel, xarray and MONAI, in and out: places in the patient above all."""

from __future__ import annotations

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
