"""Labels: which voxels of a scan are what, on any grid."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from lumivox import _check, _native
from lumivox._check import PathLike, Rgb, Vector

if TYPE_CHECKING:
    from lumivox.volume import Volume

MOST = 255
"""Labels that are told apart; 0 belongs to none."""


@dataclass(frozen=True)
class Label:
    """What one value of :attr:`Labels.array` means."""

    value: int
    """1 to 255; 0 belongs to no label."""
    name: str
    """For people: ``lungs``."""
    color: Rgb
    """Linear RGB, each 0 to 1."""


class Labels:
    """Which voxels are what, in a grid of its own: another resolution, orientation or extent than the scan's will do.

    Made by :func:`load_labels`, :meth:`from_array`, or found in a CT: :attr:`Volume.labels`. They never change, and stay on the
    GPU between images as volumes do; how they look is up to ``label`` of :func:`render`, see :class:`LabelStyle`.
    """

    __slots__ = ("native",)

    def __init__(self, native: _native.Labels) -> None:
        if not isinstance(native, _native.Labels):
            makers = "lumivox.load_labels(path) or Labels.from_array(array)"
            raise TypeError(f"labels are not made of {_check.shown(native)}, but by {makers}")
        self.native = native

    @classmethod
    def from_array(
        cls,
        array: npt.ArrayLike,
        spacing: Vector | None = None,
        origin: Vector | None = None,
        orientation: npt.ArrayLike | None = None,
        *,
        like: Volume | None = None,
        names: Mapping[int, str] | None = None,
        colors: Mapping[int, Rgb | str] | None = None,
    ) -> Labels:
        """Labels of an array of whole numbers, 0 to 255, with the axes **z, y, x**; 0 has no label. ``True`` is 1.

        - ``like``: the scan whose grid they are on, in place of the next three.
        - ``spacing``, ``origin``, ``orientation``: as those of :meth:`Volume.from_array`.
        - ``names``: ``{1: "liver", 2: "spleen"}``; without one a label is called ``label 1``.
        - ``colors``: linear RGB or ``"#rrggbb"`` (sRGB) by value; without one a label gets one that differs from its
          neighbours'.

        Raises ``ValueError`` where the parts are none, :class:`ScanError` where they do not fit together.
        """
        values = _values(array)
        if like is None:
            matrix = _check.place(
                (1.0, 1.0, 1.0) if spacing is None else spacing, (0.0, 0.0, 0.0) if origin is None else origin, orientation
            )
        else:
            given = [
                name
                for name, value in (("spacing", spacing), ("origin", origin), ("orientation", orientation))
                if value is not None
            ]
            if given:
                raise ValueError(f"like is given, and {', '.join(given)} besides")
            if not hasattr(like, "patient_from_voxel"):
                raise TypeError(f"like must be a lumivox.Volume, not {_check.shown(like)}")
            if values.shape != like.shape:
                raise ValueError(f"labels of shape {values.shape} are not on the grid of a volume of shape {like.shape}")
            matrix = like.patient_from_voxel[:3]
        named, painted = _table("names", names), _table("colors", colors)
        there = set(numbers_in(values)) | named.keys() | painted.keys()
        entries = []
        for value in sorted(there - {0}):
            name = named.get(value, f"label {value}")
            if not isinstance(name, str):
                raise TypeError(f"names[{value}] must be a name, not {_check.shown(name)}")
            own = painted.get(value)
            entries.append((value, name, None if own is None else _check.color(f"colors[{value}]", own)))
        return cls(_native.Labels.from_array(values, matrix.tolist(), entries, True, None))

    @classmethod
    def from_volume(
        cls, volume: Volume, *, names: Mapping[int, str] | None = None, colors: Mapping[int, Rgb | str] | None = None
    ) -> Labels:
        """Labels of a volume whose values they are: ``Labels.from_volume(Volume.from_sitk(image), names=...)``."""
        if not hasattr(volume, "patient_from_voxel"):
            raise TypeError(f"volume must be a lumivox.Volume, not {_check.shown(volume)}")
        return cls.from_array(volume.values, like=volume, names=names, colors=colors)

    @property
    def array(self) -> npt.NDArray[np.uint8]:
        """(z, y, x): the value of each voxel's label. A view that keeps the labels and cannot be written to."""
        return self.native.array()

    @property
    def labels(self) -> tuple[Label, ...]:
        """What the values mean, by rising value."""
        return tuple(Label(value, name, (color[0], color[1], color[2])) for value, name, color in self.native.entries)

    @property
    def names(self) -> list[str]:
        """The labels' names, by rising value; what a lasso of the Studio's cut away has none."""
        return self.native.names

    @property
    def sure(self) -> bool:
        """Whether they are sure enough to hide anything by; those of files and arrays are."""
        return self.native.sure

    @property
    def report(self) -> dict[str, Any] | None:
        """How they were read: ``format``, ``notes`` and more; ``None`` for those that were not."""
        text = self.native.report
        return None if text is None else json.loads(text)

    @property
    def shape(self) -> tuple[int, int, int]:
        """Voxels along z, y, x, as of :attr:`array`."""
        x, y, z = self.native.dims
        return z, y, x

    @property
    def spacing(self) -> tuple[float, float, float]:
        """Millimetres between neighbouring voxel centres along x, y, z."""
        x, y, z = self.native.spacing_mm
        return x, y, z

    @property
    def patient_from_voxel(self) -> npt.NDArray[np.float64]:
        """4 x 4: LPS millimetres from voxel indices (x, y, z)."""
        return np.array([*self.native.patient_from_voxel, [0.0, 0.0, 0.0, 1.0]])

    @property
    def numbers(self) -> dict[int, list[int]]:
        """The values in :attr:`array` by the number that labels have in their file, which is another where those do not fit."""
        found: dict[int, list[int]] = {}
        for number, value in self.native.numbers:
            found.setdefault(number, []).append(value)
        return found

    def values_of(self, label: str | int) -> list[int]:
        """The values of labels by a word, as the command takes it: a name, in upper or lower case, ``"unlabelled"``, ``"*"`` for
        all, else a number of their file, of which ``"#2"`` is always one; or by a value of :attr:`array` itself, an ``int``.

        Raises ``ValueError`` where there is none.
        """
        if isinstance(label, str):
            found = self.native.values_of(label)
        else:
            known = {0, *(value for value, _, _ in self.native.entries)}
            found = [int(label)] if _check.is_number(label) and label in known else []
        if not found:
            raise ValueError(f"label {label}: there is no such label; there are {', '.join([*self.names, 'unlabelled'])} and *")
        return found

    def mask(self, label: str | int) -> npt.NDArray[np.bool_]:
        """(z, y, x): which voxels have a label, by its name or number."""
        return np.isin(self.array, self.values_of(label))

    def ml(self, label: str | int) -> float:
        """How much of the patient a label is, in millilitres."""
        counts = self.native.counts()
        voxels = sum(counts[value] for value in self.values_of(label))
        return voxels * abs(float(np.linalg.det(self.patient_from_voxel[:3, :3]))) * 1e-3

    def bounds(self, label: str | int) -> tuple[tuple[float, float, float], tuple[float, float, float]] | None:
        """The box around a label in LPS millimetres, as two corners, for :meth:`ClipShape.box` and cameras; ``None`` for none."""
        found = self.native.bounds(self.values_of(label))
        if found is None:
            return None
        corners = np.array(np.meshgrid(*zip(*found, strict=True))).reshape(3, 8)
        places = self.patient_from_voxel[:3] @ np.vstack([corners, np.ones(8)])
        (a, b, c), (d, e, f) = places.min(axis=1).tolist(), places.max(axis=1).tolist()
        return (a, b, c), (d, e, f)

    def __repr__(self) -> str:
        z, y, x = self.shape
        names = self.names
        told = ", ".join(names[:6]) + (", ..." if len(names) > 6 else "")
        count = "1 label" if len(names) == 1 else f"{len(names)} labels"
        return f"<lumivox.Labels: {x} x {y} x {z} voxels, {count}: {told}>"

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> npt.NDArray[Any]:
        """:attr:`array`, for numpy."""
        array = self.array
        kept = array if dtype is None else array.astype(dtype, copy=False)
        return kept.copy() if copy else kept

    def __eq__(self, other: object) -> bool:
        """Whether both are the same labels of the same voxels."""
        if not isinstance(other, Labels):
            return NotImplemented
        same = self.native is other.native
        return same or (self._known() == other._known() and np.array_equal(self.array, other.array))

    def __hash__(self) -> int:
        return hash(self._known())

    def _known(self) -> tuple[Any, ...]:
        """All but the voxels."""
        return self.shape, tuple(tuple(row) for row in self.native.patient_from_voxel), self.labels, self.sure

    def __copy__(self) -> Labels:
        # They never change: one is as good as two.
        return self

    def __deepcopy__(self, _: Any) -> Labels:
        return self

    def __reduce__(self) -> tuple[Any, ...]:
        native = self.native
        table = (native.entries, native.sure, native.report, native.numbers, native.cut_away)
        return _unpickle, (np.asarray(self.array), native.patient_from_voxel, *table)


def _unpickle(array: npt.NDArray[np.uint8], rows: Any, *table: Any) -> Labels:
    # What came over a network may lie at odd addresses.
    array = np.require(array, requirements=["C", "A"])
    return Labels(_native.Labels.from_array(array, rows, *table))


def _values(array: npt.ArrayLike) -> npt.NDArray[np.uint8]:
    """An array's whole numbers as labels are stored."""
    if np.ma.is_masked(array):
        raise ValueError("a masked array has values that are not there: fill them first, with array.filled(0)")
    given = np.asarray(array)
    if given.ndim != 3:
        raise ValueError(f"an array with the axes z, y, x is needed, not one of shape {given.shape}")
    if given.dtype.kind not in "biuf":
        raise ValueError(f"an array of whole numbers is needed, not of {given.dtype}")
    if given.size and given.dtype.kind != "b":
        low, high = given.min(), given.max()
        if given.dtype.kind == "f" and not (np.isfinite([low, high]).all() and (np.floor(given) == given).all()):
            raise ValueError("no label map: it holds fractions, and labels are whole numbers")
        if low < 0 or high > MOST:
            raise ValueError(
                f"labels must be 0 to {MOST}, not {low:.10g} to {high:.10g}; "
                "np.unique(array, return_inverse=True) numbers them anew"
            )
    return np.ascontiguousarray(given, dtype=np.uint8)


def numbers_in(array: npt.NDArray[Any]) -> list[int]:
    """The whole numbers that an array has, rising: without sorting all of them, where they are not too large."""
    low, high = (int(array.min()), int(array.max())) if array.size else (0, 0)
    if not 0 <= low <= high < 1 << 24 or array.dtype.kind not in "iu":
        return [int(number) for number in np.unique(array)]
    there = np.zeros(high + 1, np.bool_)
    for part in array:
        there[part] = True
    return [int(number) for number in np.flatnonzero(there)] if array.size else []


def _table(name: str, given: Mapping[int, Any] | None) -> dict[int, Any]:
    if given is None:
        return {}
    if not isinstance(given, Mapping):
        raise TypeError(f"{name} must be a dict by value, such as {{1: ...}}, not {_check.shown(given)}")
    return {_check.whole(f"a value in {name}", value, 1, MOST): meaning for value, meaning in given.items()}


def load_labels(
    path: PathLike,
    *,
    table: PathLike | None = None,
    series: str | int | None = None,
    phase: int | None = None,
    allow_outside_data: bool = False,
    raw: str | None = None,
    spacing: Vector | None = None,
    axes: str | None = None,
    layout: str | None = None,
    progress: Callable[[str, int, int], object] | None = None,
) -> Labels:
    """Loads a segmentation: a DICOM SEG, NIfTI, NRRD (3D Slicer's, too), MetaImage or RAW file, or a folder with a DICOM SEG.

    - ``table``: names and colours: ITK-SNAP's label descriptions, a colour table of FreeSurfer's or 3D Slicer's, FSLeyes'
      look-up table, or columns ``index``, ``name`` and ``color``. Default: one of the same name beside the file.
    - ``series``, ``phase``, ``allow_outside_data``, ``raw``, ``spacing``, ``axes``, ``layout``, ``progress``: as those of
      :func:`load`.

    Numbers are exact: those of 1 to 255 are kept, others numbered anew, which :attr:`Labels.report` says. Ctrl-C stops it.
    Raises :class:`ScanError`, which names the file, what is wrong and what to do: also where it is a scan.
    """
    name = _check.file("path", path)
    beside = None if table is None else _check.file("table", table)
    chosen = None if series is None else str(series)
    first = None if phase is None else _check.whole("phase", phase, 1, 1 << 31)
    _check.called("progress", progress, "(stage, done, total)")
    grid = _check.grid(raw, spacing, axes, layout)
    return Labels(_native.load_labels(name, beside, chosen, first, allow_outside_data, grid, progress))
