"""Scans: volumes in physical units with their place in the patient, and what of them is the patient."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Sequence
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from lumivox import _check, _native
from lumivox._check import PathLike, Vector
from lumivox.labels import Labels

StageProgress = Callable[[str, int, int], object]
"""Is told the stage, the steps done and the steps in all."""


class Volume:
    """A scalar grid in physical units (HU for CT) with its place in the patient. It never changes.

    Made by :func:`load`, :meth:`from_array`, or the ``from_...`` methods for images of other libraries.
    """

    __slots__ = ("native",)

    def __init__(self, native: _native.Volume) -> None:
        if not isinstance(native, _native.Volume):
            makers = "lumivox.load(path), Volume.from_array(array) or Volume.from_sitk(image)"
            raise TypeError(f"a volume is not made of {_check.shown(native)}, but by {makers}")
        self.native = native

    @classmethod
    def from_array(
        cls,
        array: npt.ArrayLike,
        spacing: Vector = (1.0, 1.0, 1.0),
        origin: Vector = (0.0, 0.0, 0.0),
        orientation: npt.ArrayLike | None = None,
        modality: str = "",
        *,
        unit: str | None = None,
        slope: float = 1.0,
        intercept: float = 0.0,
    ) -> Volume:
        """A volume of an array with the axes **z, y, x**, as numpy and SimpleITK have them; all else is in the order x, y, z.

        - ``spacing``: millimetres between neighbouring voxel centres along x, y, z.
        - ``origin``: the centre of voxel (0, 0, 0) in LPS millimetres.
        - ``orientation``: 3 x 3; its columns are the directions of the voxel axes x, y, z in LPS. Default: those of LPS.
        - ``modality``: ``"CT"`` (values are HU), ``"MR"``, ``"PET"`` (or DICOM's ``"PT"``), or ``"other"``, as ``""``.
        - ``unit``: what values are measured in, where it is not the modality's.
        - ``slope``, ``intercept``: ``value = array * slope + intercept``.

        Integers of 8 and 16 bits stay as they are, signed ones with an offset in :attr:`intercept`; whole numbers of more bits
        become 16 where they fit, and all else 32-bit floats. NaN and what 32 bits cannot hold become the smallest of the other
        values (0 in maps to both sides of it), infinity the largest where a few have it, as in files; a warning says how many.
        The array is copied.

        Raises :class:`ScanError` where the parts make no volume, ``ValueError`` where one of them is none.
        """
        if np.ma.is_masked(array):
            raise ValueError("a masked array has values that are not there: fill them first, with array.filled(value)")
        matrix = _check.place(spacing, origin, orientation)
        slope, intercept = _check.number("slope", slope), _check.number("intercept", intercept)
        _check.modality(modality)
        if unit is not None and not isinstance(unit, str):
            raise TypeError(f"unit must be a word, such as 'HU', not {_check.shown(unit)}")
        return cls._of(_samples(array), slope, intercept, matrix, modality, unit, "array")

    @classmethod
    def _of(
        cls,
        array: npt.NDArray[Any],
        slope: float,
        intercept: float,
        patient_from_voxel: npt.NDArray[np.float64],
        modality: str | None,
        unit: str | None,
        library: str,
    ) -> Volume:
        """A volume of any array, with the repairs that files have; ``None`` guesses the modality, as of a file."""
        stored, offset = _stored(array)
        z, y, x = stored.shape
        kind, swapped = stored.dtype.newbyteorder("="), not stored.dtype.isnative
        place = patient_from_voxel[:3].tolist()
        rescale = [slope, intercept + offset * slope]
        samples = stored.reshape(-1).view(np.uint8)
        native, repairs = _native.volume_of_samples(
            samples, [x, y, z], kind.name, swapped == (sys.byteorder == "little"), rescale, place, modality, unit, library
        )
        for note in repairs:
            _check.warn(note)
        return cls(native)

    @classmethod
    def _from_stored(
        cls,
        stored: npt.NDArray[Any],
        slope: float,
        intercept: float,
        patient_from_voxel: npt.NDArray[np.float64],
        modality: str,
        unit: str | None,
    ) -> Volume:
        rows = patient_from_voxel[:3].tolist()
        # What came over a network may lie at odd addresses.
        stored = np.require(stored, requirements=["C", "A"])
        return cls(_native.Volume.from_array(stored, slope, intercept, rows, modality, unit))

    @property
    def array(self) -> npt.NDArray[Any]:
        """Stored samples (z, y, x) of uint8, uint16 or float32; ``value = array * slope + intercept``.

        A view, nothing is copied: it keeps the volume alive and cannot be written to.
        """
        return self.native.array()

    @property
    def values(self) -> npt.NDArray[np.float32]:
        """Physical values (z, y, x), HU for CT: a copy."""
        made = np.empty(self.shape, np.float32)
        # In 64 bits, as all else computes it: 16-bit samples come out exact. A slice at a time, for all are eight times as many.
        for stored, values in zip(self.array, made, strict=True):
            values[...] = stored * np.float64(self.slope) + np.float64(self.intercept)
        return made

    @property
    def integers(self) -> npt.NDArray[np.int16] | None:
        """Physical values (z, y, x) as 16-bit integers, where all are: a copy, half as large as :attr:`values`; else ``None``."""
        if self.array.dtype.kind != "u" or self.slope % 1.0 or self.intercept % 1.0:
            return None
        low, high = self.value_range
        if low < -(1 << 15) or high >= 1 << 15:
            return None
        made = np.empty(self.shape, np.int16)
        for stored, values in zip(self.array, made, strict=True):
            values[...] = stored * np.float64(self.slope) + np.float64(self.intercept)
        return made

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> npt.NDArray[Any]:
        """:attr:`values`, for numpy."""
        if copy is False:
            raise ValueError("values are a copy; volume.array is a view of what is stored")
        values = self.values
        return values if dtype is None else values.astype(dtype, copy=False)

    def __eq__(self, other: object) -> bool:
        """Whether both are the same scan: all voxels, and where they lie."""
        if not isinstance(other, Volume):
            return NotImplemented
        return self.native.is_same(other.native) or (self._known() == other._known() and np.array_equal(self.array, other.array))

    def __hash__(self) -> int:
        return hash(self._known())

    def _known(self) -> tuple[Any, ...]:
        """All but the voxels."""
        place = tuple(tuple(row) for row in self.native.patient_from_voxel)
        kind = (self.shape, self.array.dtype.str, self.slope, self.intercept, self.value_range)
        return (*kind, place, self.modality, self.unit)

    def __copy__(self) -> Volume:
        # It never changes: one is as good as two.
        return self

    def __deepcopy__(self, _: Any) -> Volume:
        return self

    @property
    def shape(self) -> tuple[int, int, int]:
        """Voxels along z, y, x, as of :attr:`array`."""
        x, y, z = self.native.dims
        return z, y, x

    @property
    def slope(self) -> float:
        """Physical units per stored unit."""
        return self.native.slope

    @property
    def intercept(self) -> float:
        """The physical value of a stored 0."""
        return self.native.intercept

    @property
    def spacing(self) -> tuple[float, float, float]:
        """Millimetres between neighbouring voxel centres along x, y, z."""
        x, y, z = self.native.spacing_mm
        return x, y, z

    @property
    def origin(self) -> tuple[float, float, float]:
        """The centre of voxel (0, 0, 0) in LPS millimetres."""
        x, y, z = (row[3] for row in self.native.patient_from_voxel)
        return x, y, z

    @property
    def center(self) -> tuple[float, float, float]:
        """The middle of it in LPS millimetres."""
        x, y, z = self.native.center_mm
        return x, y, z

    @property
    def bounds(self) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
        """The box around it in LPS millimetres, as two corners; voxels have their full size."""
        sides = [(-0.5, count - 0.5) for count in self.native.dims]
        corners = np.array(np.meshgrid(*sides)).reshape(3, 8)
        places = self.patient_from_voxel[:3] @ np.vstack([corners, np.ones(8)])
        (a, b, c), (d, e, f) = places.min(axis=1).tolist(), places.max(axis=1).tolist()
        return (a, b, c), (d, e, f)

    @property
    def orientation(self) -> npt.NDArray[np.float64]:
        """3 x 3: its columns are the directions of the voxel axes x, y, z in LPS, of unit length."""
        matrix = self.patient_from_voxel[:3, :3]
        directions: npt.NDArray[np.float64] = matrix / np.linalg.norm(matrix, axis=0)
        return directions

    @property
    def patient_from_voxel(self) -> npt.NDArray[np.float64]:
        """4 x 4: LPS millimetres from voxel indices (x, y, z); it may shear, as a tilted gantry does."""
        return np.array([*self.native.patient_from_voxel, [0.0, 0.0, 0.0, 1.0]])

    @property
    def modality(self) -> str:
        """DICOM's word for what made it: ``"CT"``, ``"MR"``, ``"PT"``; ``""`` where that is not known."""
        return self.native.modality

    @property
    def unit(self) -> str:
        """What values are measured in, for people: ``"HU"``; ``""`` where that is not known."""
        return self.native.unit

    @property
    def value_range(self) -> tuple[float, float]:
        """Smallest and largest physical value."""
        low, high = self.native.value_range
        return low, high

    @property
    def report(self) -> dict[str, Any] | None:
        """How it was read, as ``lumivox import --json`` tells: ``series``, ``chosen``, ``notes``, ``skipped`` and more.

        ``None`` for one that was not read from files.
        """
        text = self.native.report
        return None if text is None else json.loads(text)

    @property
    def note(self) -> str | None:
        """What around the patient was hidden, or why nothing was, as a sentence; ``None`` where there was nothing to hide."""
        return self.native.note

    @property
    def labels(self) -> Labels | None:
        """Which voxels are what, where that was looked for: by :func:`load`, :meth:`patient_alone` or :meth:`segment`."""
        found = self.native.labels
        return None if found is None else Labels(found)

    def patient_alone(self, progress: StageProgress | None = None) -> Volume:
        """A CT without what lies around the patient (table, blankets, cables), which becomes air; :attr:`note` says what.

        Any other scan, and one in which the patient is not told apart for sure, comes back as it was.
        """
        return Volume(self.native.patient_alone(_check.called("progress", progress, "(stage, done, total)")))

    def segment(self, progress: StageProgress | None = None) -> Volume:
        """The same volume with :attr:`labels`: patient, lungs, airways, table, air and more."""
        return Volume(self.native.segment(_check.called("progress", progress, "(stage, done, total)")))

    def skin_depth(self, progress: StageProgress | None = None) -> Volume | None:
        """How deep below the skin each point lies, in mm, up to 63, on a grid of its own: for :class:`Peel`.

        By :attr:`labels`, of a CT; ``None`` where no skin was found for sure. It is found once, and kept.
        """
        looked = self if self.labels is not None else self.segment(progress)
        depth = looked.native.skin_depth(_check.called("progress", progress, "(stage, done, total)"))
        return None if depth is None else Volume(depth)

    def to_sitk(self) -> Any:
        """A ``SimpleITK.Image`` of the physical values."""
        from lumivox import interop

        return interop.to_sitk(self)

    def to_nibabel(self) -> Any:
        """A ``nibabel.Nifti1Image`` of the physical values, in its RAS."""
        from lumivox import interop

        return interop.to_nibabel(self)

    def to_xarray(self) -> Any:
        """An ``xarray.DataArray`` of the physical values with the dimensions z, y, x."""
        from lumivox import interop

        return interop.to_xarray(self)

    def to_monai(self) -> Any:
        """A ``monai.data.MetaTensor`` of the physical values: (channel, x, y, z), in its RAS."""
        from lumivox import interop

        return interop.to_monai(self)

    @classmethod
    def from_sitk(cls, image: Any, modality: str = "") -> Volume:
        """A volume of a ``SimpleITK.Image``, which has LPS, too."""
        from lumivox import interop

        return interop.from_sitk(image, modality)

    @classmethod
    def from_nibabel(cls, image: Any, modality: str = "") -> Volume:
        """A volume of a ``nibabel`` image, whose RAS becomes LPS."""
        from lumivox import interop

        return interop.from_nibabel(image, modality)

    @classmethod
    def from_xarray(cls, array: Any, modality: str = "") -> Volume:
        """A volume of an ``xarray.DataArray``: see :func:`lumivox.interop.from_xarray`."""
        from lumivox import interop

        return interop.from_xarray(array, modality)

    @classmethod
    def from_monai(cls, tensor: Any, modality: str = "") -> Volume:
        """A volume of a ``monai.data.MetaTensor``, (channel, x, y, z) or (x, y, z), whose RAS becomes LPS."""
        from lumivox import interop

        return interop.from_monai(tensor, modality)

    def __repr__(self) -> str:
        x, y, z = self.native.dims
        sx, sy, sz = self.spacing
        low, high = self.value_range
        kind = f"{self.modality}, " if self.modality else ""
        unit = f" {self.unit}" if self.unit else ""
        spacing = f"{sx:.4g} x {sy:.4g} x {sz:.4g} mm"
        return f"<lumivox.Volume: {kind}{x} x {y} x {z} voxels of {spacing}, {low:g} to {high:g}{unit}>"

    def __reduce__(self) -> tuple[Any, ...]:
        return _unpickle, (
            np.asarray(self.array),
            self.slope,
            self.intercept,
            self.patient_from_voxel,
            self.modality,
            self.unit,
            self.labels,
            self.note,
            self.native.report,
        )


def _unpickle(
    stored: npt.NDArray[Any],
    slope: float,
    intercept: float,
    matrix: npt.NDArray[np.float64],
    modality: str,
    unit: str,
    labels: Labels | None,
    note: str | None,
    report: str | None,
) -> Volume:
    native = Volume._from_stored(stored, slope, intercept, matrix, modality, unit).native
    if labels is not None:
        native = native.with_labels(labels.native, note)
    return Volume(native if report is None else native.with_report(report))


def _samples(array: Any) -> npt.NDArray[Any]:
    """An array of samples, if it is one."""
    if isinstance(array, str | bytes) or array is None:
        raise TypeError(f"an array with the axes z, y, x is needed, not {_check.shown(array)}; lumivox.load(path) reads files")
    try:
        return np.asarray(array)
    except ValueError:
        raise ValueError("an array with the axes z, y, x is needed, not lists of several lengths") from None


def _stored(array: npt.NDArray[Any]) -> tuple[npt.NDArray[Any], float]:
    """An array's samples in a type that files have, in order, and the value of a stored 0."""
    if array.ndim != 3:
        raise ValueError(f"an array with the axes z, y, x is needed, not one of shape {array.shape}")
    if array.dtype == np.bool_:
        return np.ascontiguousarray(array).view(np.uint8), 0.0
    if np.issubdtype(array.dtype, np.complexfloating) or not np.issubdtype(array.dtype, np.number):
        raise ValueError(f"an array of real numbers is needed, not of {array.dtype}")
    if array.dtype.kind in "iu" and array.itemsize > 2 and array.size:
        low, high = int(array.min()), int(array.max())
        if high - low < 1 << 16:
            # Here, for a float of 32 bits would round large ones.
            made = np.empty(array.shape, np.uint16)
            for given, stored in zip(array, made, strict=True):
                stored[...] = given - array.dtype.type(low)
            return made, float(low)
    if array.dtype.kind == "f" and array.itemsize not in (4, 8):
        array = array.astype(np.float32 if array.itemsize < 4 else np.float64)
    return np.ascontiguousarray(array), 0.0


def _paths(path: PathLike | Sequence[PathLike]) -> list[str]:
    if not isinstance(path, list | tuple):
        return [_check.file("path", path)]
    if not path:
        raise ValueError("path is an empty list; name a file or folder")
    return [_check.file("path", one) for one in path]


def load(
    path: PathLike | Sequence[PathLike],
    series: str | int | None = None,
    keep: Literal["patient", "everything"] = "patient",
    progress: StageProgress | None = None,
    *,
    phase: int | None = None,
    leave_gaps: bool = False,
    fill_damaged: bool = False,
    allow_outside_data: bool = False,
    raw: str | None = None,
    spacing: Vector | None = None,
    axes: str | None = None,
    layout: str | None = None,
    slope: float | None = None,
    intercept: float | None = None,
    modality: str | None = None,
    unit: str | None = None,
) -> Volume:
    """Loads a scan: a DICOM folder, archive or files, NIfTI, NRRD, MetaImage, RAW, an array of NumPy's (``.npy``), a stack of
    pictures or OME-Zarr, told by content.

    - ``series``: DICOM series to take: its place in ``report["series"]`` from 1, its UID, or a number that no other has.
    - ``keep``: ``"patient"`` makes air of what lies around the patient in a CT; ``"everything"`` keeps it as scanned.
    - ``progress``: is called with ``(stage, done, total)``; what it raises ends the load.
    - ``phase``: phase of a series with several, counted from 1. Default: the first that is whole.
    - ``leave_gaps``: leaves missing slices empty. Default: filled in from both neighbours' values.
    - ``fill_damaged``: fills in slices that are there but damaged, too.
    - ``allow_outside_data``: lets a header name data files anywhere, not only beside it or below.
    - ``raw``: layout of a RAW scan: ``"256x256x108:i16le:spacing=0.9,0.9,1.5"``.
    - ``spacing``: millimetres between voxels along x, y, z, for arrays, stacks of pictures and OME-Zarr. Default: the file's,
      else 1. ``axes``: where x, y and z of such files grow to in the patient: ``"LPS"`` (default), ``"RAS"``, ...
    - ``layout``: the axes of an array as its shape lists them: x, y, z, t for moments, c for colours. Default: ``"zyx"``, or
      ``"tzyx"`` where there are four.
    - ``slope``, ``intercept``, ``modality``, ``unit``: what values mean, in place of what the file says:
      ``intercept=-1024`` where a CT's was lost, ``unit="HU"`` where a CT's are Hounsfield units after all. ``modality`` is
      ``"CT"``, ``"MR"``, ``"PET"`` or ``"other"``.

    Ctrl-C stops it. Raises :class:`ScanError`, which names the file, what is wrong and what to do.
    """
    _check.choice("keep", keep, ("patient", "everything"))
    if series is not None and not (isinstance(series, str) or _check.is_number(series)):
        raise TypeError(f"series must be a place in the report's list, or a UID, not {_check.shown(series)}")
    chosen = None if series is None else str(series)
    phase = None if phase is None else _check.whole("phase", phase, 1, 1 << 31)
    grid = _check.grid(raw, spacing, axes, layout)
    slope = None if slope is None else _check.number("slope", slope, -1e9, 1e9)
    if slope == 0.0:
        raise ValueError("slope must not be 0")
    intercept = None if intercept is None else _check.number("intercept", intercept, -1e9, 1e9)
    if modality is not None:
        _check.modality(modality)
    if unit is not None and not isinstance(unit, str):
        raise TypeError(f"unit must be a text, not {_check.shown(unit)}")
    values = (slope, intercept, modality, unit)
    _check.called("progress", progress, "(stage, done, total)")
    alone = keep == "patient"
    native = _native.load(
        _paths(path), chosen, phase, leave_gaps, fill_damaged, allow_outside_data, grid, values, alone, progress
    )
    return Volume(native)


def scan(
    path: PathLike | Sequence[PathLike],
    progress: StageProgress | None = None,
    *,
    allow_outside_data: bool = False,
    raw: str | None = None,
    spacing: Vector | None = None,
    axes: str | None = None,
    layout: str | None = None,
) -> dict[str, Any]:
    """What could be loaded from a folder, archive or file, without loading it: the ``report`` that a load would have.

    Options are as those of :func:`load`.
    """
    _check.called("progress", progress, "(stage, done, total)")
    grid = _check.grid(raw, spacing, axes, layout)
    report: dict[str, Any] = json.loads(_native.scan(_paths(path), allow_outside_data, grid, progress))
    return report


def phantom(kind: str = "head", size: int | None = None, seed: int = 1, progress: StageProgress | None = None) -> Volume:
    """A procedural scan to try things on: ``"head"``, ``"torso"``, ``"cube"``, ``"slab"`` or ``"sphere"`` as a CT sees them,
    ``"mr-head"`` or ``"mr-brain"``, or ``"torso-pet"``, the torso as a PET sees it, in the same place.

    ``size`` is in voxels along the longest side, 8 to 1024 (256; of a PET 128); ``seed`` is that of noise and
    anatomical variation.
    """
    if not isinstance(kind, str):
        raise TypeError(f"kind must be a phantom's name, such as 'head', not {_check.shown(kind)}")
    voxels = None if size is None else _check.whole("size", size, 8, 1024)
    chosen = _check.whole("seed", seed, 0, (1 << 64) - 1)
    return Volume(_native.phantom(kind, voxels, chosen, _check.called("progress", progress, "(stage, done, total)")))


def write_dicom_series(volume: Volume, folder: PathLike, progress: StageProgress | None = None) -> int:
    """Writes a CT as a DICOM series into a new or empty folder; returns the number of files."""
    if not isinstance(volume, Volume):
        raise TypeError(f"a lumivox.Volume is needed, not {_check.shown(volume)}")
    _check.called("progress", progress, "(stage, done, total)")
    return _native.write_dicom_series(volume.native, _check.file("folder", folder), progress)
