"""Images of other libraries, in and out. None of them is needed by Lumivox: each is imported when it is asked for.

Lumivox and SimpleITK have DICOM's LPS (x to the patient's left, y to the back); NIfTI, nibabel and MONAI have RAS (x to the
right, y to the front). What goes out has physical values (HU for CT) as 32-bit floats.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from lumivox import _check
from lumivox.volume import Volume

RAS_FROM_LPS = np.diag([-1.0, -1.0, 1.0, 1.0])
"""And the other way."""


def to_sitk(volume: Volume) -> Any:
    """A ``SimpleITK.Image``. A sheared grid (a tilted gantry) is an error: such an image cannot hold it."""
    import SimpleITK as sitk

    _volume(volume)
    _check_rigid(volume, "SimpleITK")
    image = sitk.GetImageFromArray(volume.values)
    image.SetSpacing(volume.spacing)
    image.SetOrigin(volume.origin)
    image.SetDirection(volume.orientation.ravel().tolist())
    if volume.modality:
        image.SetMetaData("0008|0060", volume.modality)
    return image


def from_sitk(image: Any, modality: str = "") -> Volume:
    """A volume of a ``SimpleITK.Image`` with three dimensions and one component; DICOM's modality is taken from it."""
    import SimpleITK as sitk

    _has(image, "GetPixelIDValue", "a SimpleITK.Image")
    if image.GetDimension() != 3 or image.GetNumberOfComponentsPerPixel() != 1:
        shape = f"{image.GetDimension()} dimensions, {image.GetNumberOfComponentsPerPixel()} components"
        raise ValueError(f"an image of 3 dimensions and 1 component is needed, not of {shape}")
    known = image.GetMetaData("0008|0060").strip() if image.HasMetaDataKey("0008|0060") else ""
    return Volume.from_array(
        sitk.GetArrayViewFromImage(image),
        image.GetSpacing(),
        image.GetOrigin(),
        np.array(image.GetDirection()).reshape(3, 3),
        modality or (known if known in ("CT", "MR", "PT") else ""),
    )


def to_nibabel(volume: Volume) -> Any:
    """A ``nibabel.Nifti1Image`` with the axes x, y, z and an affine to RAS; it may shear."""
    import nibabel

    _volume(volume)
    image = nibabel.Nifti1Image(np.ascontiguousarray(volume.values.T), RAS_FROM_LPS @ volume.patient_from_voxel)
    image.header.set_xyzt_units("mm")
    return image


def from_nibabel(image: Any, modality: str = "") -> Volume:
    """A volume of a ``nibabel`` image of three dimensions; its slope and intercept are kept apart from its samples."""
    _has(image, "dataobj", "a nibabel image")
    slope, intercept, samples = 1.0, 0.0, None
    proxy = image.dataobj
    if hasattr(proxy, "get_unscaled"):
        samples = np.asarray(proxy.get_unscaled())
        slope, intercept = float(proxy.slope), float(proxy.inter)
    else:
        samples = np.asarray(proxy)
    return _from_ras(samples, np.asarray(image.affine), modality, slope, intercept)


def to_xarray(volume: Volume) -> Any:
    """An ``xarray.DataArray`` with the dimensions z, y, x.

    Its coordinates are millimetres along the axes; ``patient_from_voxel`` (4 x 4, LPS from x, y, z indices), ``modality``
    and ``units`` are attributes.
    """
    import xarray

    _volume(volume)
    coordinates = {
        axis: origin + spacing * np.arange(count)
        for axis, origin, spacing, count in zip("xyz", volume.origin, volume.spacing, volume.shape[::-1], strict=True)
    }
    attributes = {
        "patient_from_voxel": volume.patient_from_voxel.tolist(),
        "modality": volume.modality,
        "units": volume.unit,
    }
    return xarray.DataArray(volume.values, coordinates, ("z", "y", "x"), "values", attributes)


def from_xarray(array: Any, modality: str = "") -> Volume:
    """A volume of an ``xarray.DataArray`` with the dimensions x, y and z in any order.

    The place is its attribute ``patient_from_voxel`` (4 x 4, LPS), else that of its coordinates, which are millimetres,
    evenly spaced, along LPS axes; without either it is at the origin, with a spacing of 1 mm.
    """
    _has(array, "dims", "an xarray.DataArray")
    if set(array.dims) != {"x", "y", "z"}:
        raise ValueError(f"the dimensions x, y and z are needed, not {', '.join(map(str, array.dims))}")
    array = array.transpose("z", "y", "x")
    matrix = np.eye(4)
    if "patient_from_voxel" in array.attrs:
        matrix = np.asarray(array.attrs["patient_from_voxel"], dtype=np.float64).reshape(4, 4)
    else:
        for i, axis in enumerate("xyz"):
            if axis in array.coords:
                matrix[i, i], matrix[i, 3] = _step(np.asarray(array.coords[axis], dtype=np.float64), axis)
    modality = modality or str(array.attrs.get("modality", ""))
    unit = array.attrs.get("units")
    return _placed(np.asarray(array.values), matrix, modality, unit=str(unit) if unit else None)


def to_monai(volume: Volume) -> Any:
    """A ``monai.data.MetaTensor``, (1, x, y, z), with an affine to RAS."""
    import torch
    from monai.data import MetaTensor

    _volume(volume)
    values = torch.from_numpy(np.ascontiguousarray(volume.values.T)[None])
    return MetaTensor(values, affine=torch.from_numpy(RAS_FROM_LPS @ volume.patient_from_voxel))


def from_monai(tensor: Any, modality: str = "") -> Volume:
    """A volume of a ``monai.data.MetaTensor``, or of anything with ``affine`` (RAS) and values (x, y, z) or (1, x, y, z)."""
    _has(tensor, "affine", "a MONAI MetaTensor, which has an affine,")
    samples, affine = (_numpy(part) for part in (tensor, tensor.affine))
    if samples.ndim == 4 and samples.shape[0] == 1:
        samples = samples[0]
    return _from_ras(samples, affine, modality)


def _volume(volume: Volume) -> None:
    if not isinstance(volume, Volume):
        raise TypeError(f"a lumivox.Volume is needed, not {_check.shown(volume)}")


def _has(image: Any, attribute: str, what: str) -> None:
    if not hasattr(image, attribute):
        raise TypeError(f"{what} is needed, not {_check.shown(image)}")


def _numpy(tensor: Any) -> npt.NDArray[Any]:
    if hasattr(tensor, "detach"):
        tensor = tensor.detach().cpu()
    return tensor.numpy() if hasattr(tensor, "numpy") else np.asarray(tensor)


def _from_ras(
    samples: npt.NDArray[Any], affine: npt.NDArray[Any], modality: str, slope: float = 1.0, intercept: float = 0.0
) -> Volume:
    if samples.ndim != 3:
        raise ValueError(f"an image of 3 dimensions is needed, not of shape {samples.shape}")
    matrix = RAS_FROM_LPS @ np.asarray(affine, dtype=np.float64)
    return _placed(samples.T, matrix, modality, slope, intercept)


def _placed(
    array: npt.NDArray[Any],
    patient_from_voxel: npt.NDArray[np.float64],
    modality: str,
    slope: float = 1.0,
    intercept: float = 0.0,
    unit: str | None = None,
) -> Volume:
    matrix = patient_from_voxel[:3, :3]
    # Its columns are directions times spacing, a shear among them.
    return Volume.from_array(
        array,
        (1.0, 1.0, 1.0),
        patient_from_voxel[:3, 3].tolist(),
        matrix,
        modality,
        slope=slope,
        intercept=intercept,
        unit=unit,
    )


def _check_rigid(volume: Volume, library: str) -> None:
    directions = volume.orientation
    if not np.allclose(directions.T @ directions, np.eye(3), atol=1e-5):
        raise ValueError(f"the grid is sheared (a tilted gantry), which an image of {library} cannot be")


def _step(places: npt.NDArray[np.float64], axis: str) -> tuple[float, float]:
    if len(places) < 2:
        return 1.0, float(places[0])
    step = (places[-1] - places[0]) / (len(places) - 1)
    if step == 0.0 or not np.allclose(np.diff(places), step, rtol=1e-4, atol=0.0):
        raise ValueError(f"the coordinates along {axis} are not evenly spaced")
    return float(step), float(places[0])
