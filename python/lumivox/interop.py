"""Images of other libraries, in and out. None of them is needed by Lumivox: each is imported when it is asked for.

Lumivox and SimpleITK have DICOM's LPS (x to the patient's left, y to the back); NIfTI, nibabel and MONAI have RAS (x to the
right, y to the front). What goes out has physical values (HU for CT), as 16-bit integers for SimpleITK and nibabel where all
are, else as 32-bit floats.

What comes in goes the way of files: lengths become millimetres, NaN is mended with a warning, and without a ``modality`` what
looks like Hounsfield units is taken for CT, which :attr:`Volume.report` says.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from lumivox import _check
from lumivox.volume import Volume

RAS_FROM_LPS = np.diag([-1.0, -1.0, 1.0, 1.0])
"""And the other way."""

NO_ORIENTATION = "no orientation is given: axes are taken for right, anterior, superior"
"""What is said of an image without a place, as of its file."""

MM: dict[str, float] = {
    **dict.fromkeys(("", "mm", "millimeter", "millimeters", "millimetre", "millimetres", "unknown"), 1.0),
    **dict.fromkeys(("m", "meter", "meters", "metre", "metres"), 1e3),
    **dict.fromkeys(("cm", "centimeter", "centimeters", "centimetre", "centimetres"), 10.0),
    **dict.fromkeys(("um", "µm", "μm", "micron", "microns", "micrometer", "micrometers", "micrometre", "micrometres"), 1e-3),
    **dict.fromkeys(("nm", "nanometer", "nanometers", "nanometre", "nanometres"), 1e-6),
}
"""Millimetres in units of length by their names; without one they are millimetres."""


def to_sitk(volume: Volume) -> Any:
    """A ``SimpleITK.Image``. A sheared grid (a tilted gantry) is an error: such an image cannot hold it."""
    import SimpleITK as sitk

    _volume(volume)
    _check_rigid(volume, "SimpleITK")
    image = sitk.GetImageFromArray(_out(volume))
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
    matrix = np.eye(4)
    matrix[:3, :3] = np.array(image.GetDirection()).reshape(3, 3) * np.array(image.GetSpacing())
    matrix[:3, 3] = image.GetOrigin()
    known = known if known in ("CT", "MR", "PT") else ""
    return _placed("SimpleITK", sitk.GetArrayViewFromImage(image), matrix, modality or known)


def to_nibabel(volume: Volume) -> Any:
    """A ``nibabel.Nifti1Image`` with the axes x, y, z and an affine to RAS; it may shear."""
    import nibabel

    _volume(volume)
    image = nibabel.Nifti1Image(_out(volume).T, RAS_FROM_LPS @ volume.patient_from_voxel)
    image.header.set_xyzt_units("mm")
    return image


def from_nibabel(image: Any, modality: str = "") -> Volume:
    """A volume of a ``nibabel`` image of three dimensions; its slope and intercept are kept apart from its samples.

    Its place is its ``affine`` in the unit of its header. One that nobody gave (NIfTI's sform and qform are of code 0) is
    taken as :func:`lumivox.load` takes such a file: right, anterior, superior from the first voxel, which a warning says.
    """
    _has(image, "dataobj", "a nibabel image")
    slope, intercept, proxy = 1.0, 0.0, image.dataobj
    if hasattr(proxy, "get_unscaled"):
        samples = np.asarray(proxy.get_unscaled())
        slope, intercept = float(proxy.slope), float(proxy.inter)
    else:
        samples = np.asarray(proxy)
    affine, header = _ras_from_voxel(image), image.header
    unit = header.get_xyzt_units()[0] if hasattr(header, "get_xyzt_units") else "mm"
    return _from_ras("nibabel", samples, affine, modality, MM.get(unit, 1.0), slope, intercept)


def _ras_from_voxel(image: Any) -> npt.NDArray[np.float64]:
    """The place of a ``nibabel`` image in the unit of its header, as its file has it."""
    given, header = image.affine, image.header
    is_nifti = hasattr(header, "get_qform")
    has_place = is_nifti and any(int(header[name]) for name in ("sform_code", "qform_code"))
    if given is None and has_place:
        given = header.get_best_affine()
    # Where nobody said anything, nibabel's own is that of the header's base.
    if given is not None and (has_place or not is_nifti or not np.array_equal(given, header.get_base_affine())):
        return np.asarray(given, dtype=np.float64)
    _check.warn(NO_ORIENTATION)
    sizes = (abs(float(size)) for size in header.get_zooms()[:3])
    # An axis of one voxel needs no size in a file.
    return np.diag([*(size or float(count == 1) for size, count in zip(sizes, image.shape, strict=False)), 1.0])


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

    Its place is that of its coordinates, evenly spaced and in millimetres (or in the unit that they have as ``units``): also
    of a part, flipped or thinned out, which the attribute ``patient_from_voxel`` (4 x 4, LPS) knows nothing of. That gives the
    directions of the axes, else they are LPS; and the place where there are no coordinates. Without either it is at the origin,
    with a spacing of 1 mm.
    """
    _has(array, "dims", "an xarray.DataArray")
    if set(array.dims) != {"x", "y", "z"}:
        raise ValueError(f"the dimensions x, y and z are needed, not {', '.join(map(str, array.dims))}")
    array = array.transpose("z", "y", "x")
    matrix = np.eye(4)
    if "patient_from_voxel" in array.attrs:
        try:
            matrix = np.asarray(array.attrs["patient_from_voxel"], dtype=np.float64).reshape(4, 4)
        except (TypeError, ValueError):
            raise ValueError("the attribute patient_from_voxel must be 4 x 4 numbers") from None
    # Where coordinates lie on the axes of the whole: they are those of `to_xarray`, the origin's own part and steps along.
    part = np.eye(4)
    for i, axis in enumerate("xyz"):
        if axis in array.coords:
            step, first = _step(array.coords[axis], axis)
            spacing = float(np.linalg.norm(matrix[:3, i]))
            part[i, i], part[i, 3] = (1.0 if step is None else step / spacing), (first - matrix[i, 3]) / spacing
    if not np.allclose(part, np.eye(4), rtol=0.0, atol=1e-6):
        matrix = matrix @ part
    modality = modality or str(array.attrs.get("modality", ""))
    unit = array.attrs.get("units")
    return _placed("xarray", np.asarray(array.values), matrix, modality, unit=str(unit) if unit else None)


def to_monai(volume: Volume) -> Any:
    """A ``monai.data.MetaTensor``, (1, x, y, z), with an affine to RAS."""
    import torch
    from monai.data import MetaTensor

    _volume(volume)
    values = torch.from_numpy(np.ascontiguousarray(volume.values.T)[None])
    return MetaTensor(values, affine=torch.from_numpy(RAS_FROM_LPS @ volume.patient_from_voxel))


def from_monai(tensor: Any, modality: str = "") -> Volume:
    """A volume of a ``monai.data.MetaTensor``, or of anything with ``affine`` and values (x, y, z) or (1, x, y, z).

    The affine is to RAS, or to what ``meta["space"]`` says, as MONAI's readers do: RAS or LPS.
    """
    _has(tensor, "affine", "a MONAI MetaTensor, which has an affine,")
    samples, affine = (_numpy(part) for part in (tensor, tensor.affine))
    if samples.ndim == 4 and samples.shape[0] == 1:
        samples = samples[0]
    affine = np.asarray(affine, dtype=np.float64)
    meta = getattr(tensor, "meta", None) or {}
    space = meta.get("space") or "RAS"
    # One of MONAI's words is an enumeration of strings.
    space = str(getattr(space, "value", space)).upper()
    if space not in ("RAS", "LPS"):
        raise ValueError(f"meta['space'] must be RAS or LPS, not {_check.shown(space)}: transform the affine to one of them")
    return _from_ras("MONAI", samples, affine if space == "RAS" else RAS_FROM_LPS @ affine, modality)


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


def _out(volume: Volume) -> npt.NDArray[Any]:
    """Physical values as they go out: 16-bit integers where all are."""
    integers = volume.integers
    return volume.values if integers is None else integers


def _from_ras(
    library: str,
    samples: npt.NDArray[Any],
    affine: npt.NDArray[np.float64],
    modality: str,
    mm: float = 1.0,
    slope: float = 1.0,
    intercept: float = 0.0,
) -> Volume:
    if samples.ndim > 3 and set(samples.shape[3:]) == {1}:
        samples = samples.reshape(samples.shape[:3], order="F" if samples.flags.f_contiguous else "C")
    if samples.ndim != 3:
        several = "; choose one, such as image.slicer[..., 0]" if samples.ndim == 4 else ""
        raise ValueError(f"an image of 3 dimensions is needed, not of shape {samples.shape}{several}")
    return _placed(library, samples.T, np.diag([mm, mm, mm, 1.0]) @ RAS_FROM_LPS @ affine, modality, slope, intercept)


def _placed(
    library: str,
    array: npt.NDArray[Any],
    patient_from_voxel: npt.NDArray[np.float64],
    modality: str,
    slope: float = 1.0,
    intercept: float = 0.0,
    unit: str | None = None,
) -> Volume:
    if patient_from_voxel.shape != (4, 4) or not np.isfinite(patient_from_voxel).all():
        raise ValueError("the image's place is no transform of 4 x 4 finite numbers")
    return Volume._of(array, slope, intercept, patient_from_voxel, modality or None, unit, library)


def _check_rigid(volume: Volume, library: str) -> None:
    directions = volume.orientation
    if not np.allclose(directions.T @ directions, np.eye(3), atol=1e-5):
        raise ValueError(f"the grid is sheared (a tilted gantry), which an image of {library} cannot be")


def _step(coordinate: Any, axis: str) -> tuple[float | None, float]:
    """Millimetres between coordinates along an axis, if there are several, and the first."""
    unit = str(coordinate.attrs.get("units", ""))
    if unit.lower() not in MM:
        raise ValueError(f"the coordinates along {axis} are in {unit!r}, which is no length that is known here; give them in mm")
    places = np.asarray(coordinate, dtype=np.float64) * MM[unit.lower()]
    if not np.isfinite(places).all():
        raise ValueError(f"the coordinates along {axis} are not all numbers")
    if len(places) < 2:
        return None, float(places[0])
    step = (places[-1] - places[0]) / (len(places) - 1)
    if step == 0.0 or not np.allclose(np.diff(places), step, rtol=1e-4, atol=0.0):
        raise ValueError(f"the coordinates along {axis} are not evenly spaced")
    return float(step), float(places[0])
