"""How a scan is to look: transfer functions, media, presets."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from lumivox import _check, _document, _native
from lumivox._check import PathLike, Rgb, Vector
from lumivox.volume import Volume

Filter = Literal["nearest", "trilinear", "tricubic", "smooth"]

FILTERS = ("nearest", "trilinear", "tricubic", "smooth")

MOST_GRADIENTS = 32


class OpacityKnot(NamedTuple):
    """A point of the opacity curve."""

    value: float
    """Physical value, HU for CT."""
    opacity: float
    """0 to 1."""
    ease: str = "linear"
    """How the curve leaves this knot: ``"linear"`` or ``"in-out"``, slow at both ends."""


class ColorStop(NamedTuple):
    """A point of the colour curve, which is linear between stops."""

    value: float
    """Physical value, HU for CT."""
    color: Rgb
    """Linear RGB, each 0 to 1."""


class GradientFunction(NamedTuple):
    """A row of a two-dimensional transfer function: opacity and colour where values change so much."""

    per_mm: float
    """Gradient, in value units per mm; above 0."""
    transfer_function: TransferFunction
    """What is there of a value, without gradients of its own."""


@dataclass(frozen=True)
class TransferFunction:
    """Opacity and colour of physical values (HU for CT). Beyond the first and the last point, their values hold.

    ``opacity`` takes tuples ``(value, opacity)`` or ``(value, opacity, ease)``, ``color`` tuples ``(value, (r, g, b))`` or
    ``(value, "#rrggbb")``, which is sRGB. With ``gradients``, tuples ``(per_mm, transfer_function)``, it is one of value and
    gradient: what stands outside of them is for where values do not change. Between rows it is linear; beyond the last, that
    holds.
    """

    opacity: tuple[OpacityKnot, ...]
    color: tuple[ColorStop, ...]
    gradients: tuple[GradientFunction, ...] = ()

    def __init__(
        self,
        opacity: Iterable[tuple[float, float] | tuple[float, float, str]],
        color: Iterable[tuple[float, Vector | str]],
        gradients: Iterable[tuple[float, TransferFunction]] = (),
    ) -> None:
        knots = tuple(sorted((_knot(knot) for knot in _points("opacity", opacity)), key=lambda knot: knot.value))
        stops = tuple(sorted((_stop(stop) for stop in _points("color", color)), key=lambda stop: stop.value))
        rows = tuple(sorted((_row(row) for row in _points("gradients", gradients)), key=lambda row: row.per_mm))
        if len(rows) > MOST_GRADIENTS:
            raise ValueError(f"gradients are {len(rows)}, of which {MOST_GRADIENTS} can be told apart; leave some out")
        object.__setattr__(self, "opacity", knots)
        object.__setattr__(self, "color", stops)
        object.__setattr__(self, "gradients", rows)
        # Asks for no value, and finds what is wrong with the points.
        _native.transfer_function_at(self._look(), [], 0.0)

    def _look(self) -> str:
        return _document.text(_document.of_curve(self))

    def at(self, values: npt.ArrayLike, per_mm: float = 0.0) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
        """Opacity (n) and linear RGB (n, 3) at n physical values that change by ``per_mm`` units per millimetre."""
        gradient = _check.number("per_mm", per_mm, 0.0, 1e12)
        try:
            asked = np.asarray(values, dtype=np.float64).ravel().tolist()
        except (TypeError, ValueError):
            raise TypeError(f"values must be numbers, not {_check.shown(values)}") from None
        found = _native.transfer_function_at(self._look(), asked, gradient)
        opacity = np.array([opacity for opacity, _ in found])
        return opacity, np.array([color for _, color in found]).reshape(-1, 3)

    def windowed(self, shift: float = 0.0, window_scale: float = 1.0) -> TransferFunction:
        """The same, gradients too, widened by ``window_scale`` (0.01 to 100) about its centre and moved by ``shift`` in the
        scan's unit, as a window's width and level do."""
        shift = _check.number("shift", shift, -1e9, 1e9)
        scale = _check.number("window_scale", window_scale, 0.01, 100.0)
        if (shift, scale) == (0.0, 1.0):
            return self
        values = [knot.value for knot in self.opacity] + [stop.value for stop in self.color]
        centre = min(values) / 2.0 + max(values) / 2.0
        offset = centre * (1.0 - scale) + shift

        return self._remapped(scale, offset)

    def in_window(self, level: float, width: float) -> TransferFunction:
        """The same, gradients too, stretched over ``width`` of the scan's units around ``level``, as radiologists give a
        window."""
        level = _check.number("level", level, -1e9, 1e9)
        width = _check.number("width", width, 1e-9, 1e9)
        values = [knot.value for knot in self.opacity] + [stop.value for stop in self.color]
        low, high = min(values), max(values)
        if high <= low:
            return self
        scale = width / (high - low)
        return self._remapped(scale, level - scale * (low + high) / 2.0)

    def _remapped(self, scale: float, offset: float) -> TransferFunction:
        knots = [(knot.value * scale + offset, knot.opacity, knot.ease) for knot in self.opacity]
        stops = [(stop.value * scale + offset, stop.color) for stop in self.color]
        rows = [(row.per_mm, row.transfer_function._remapped(scale, offset)) for row in self.gradients]
        return TransferFunction(knots, stops, rows)

    def save(self, path: PathLike, unit: str = "HU") -> None:
        """Writes it, gradients too, as :func:`load_transfer_function`, the command and all other hosts read it."""
        name = _check.file("path", path)
        _check.writable(name)
        if not isinstance(unit, str):
            raise TypeError(f"unit must be a word, such as 'HU', not {_check.shown(unit)}")
        try:
            _native.save_transfer_function(name, self._look(), unit)
        except _native.ScanError as error:
            raise OSError(f"{name} cannot be written{str(error).removeprefix(name)}") from None


def load_transfer_function(path: PathLike, value_range: Vector = (-1024.0, 3071.0)) -> TransferFunction:
    """Reads a transfer function, of Lumivox's (with ``gradients``, too) or of UnityVolumeRendering's making.

    Old ``.tf`` files are relative to the smallest and largest value of the scan that they are for.
    """
    name = _check.file("path", path)
    try:
        low, high = (_check.number("value_range", value) for value in value_range)
    except (TypeError, ValueError):
        raise ValueError(f"value_range must be two numbers, low and high, not {_check.shown(value_range)}") from None
    return _document.curve(json.loads(_native.load_transfer_function(name, [low, high])))


@dataclass(frozen=True)
class SurfaceReflection:
    """Reflection where the value changes quickly: crisp bone and skin."""

    strength: float = 0.0
    """Largest probability of a surface event, 0 (off) to 1."""
    gradient_per_mm: float = 1.0
    """Gradient, in value units per mm, where a surface event reaches 63% of ``strength``."""
    roughness: float = 0.5
    """Width of the specular lobe, 0 to 1."""
    specular: float = 0.0
    """Reflectance seen head-on, 0 to 1; skin and bone have about 0.04."""
    metallic: float = 0.0
    """How much of the medium's colour the specular lobe has: 0 none, as of skin and bone, to 1 all, as of metal."""

    def __post_init__(self) -> None:
        _check.number("strength", self.strength, 0.0, 1.0)
        _check.number("gradient_per_mm", self.gradient_per_mm, 1e-9, 1e12)
        _check.number("roughness", self.roughness, 0.0, 1.0)
        _check.number("specular", self.specular, 0.0, 1.0)
        _check.number("metallic", self.metallic, 0.0, 1.0)


@dataclass(frozen=True)
class Medium:
    """How a volume meets light: transfer function, phase function and scale factors.

    Extinction is ``opacity(value) * density`` per millimetre of the volume's own space.
    """

    transfer_function: TransferFunction
    density: float = 1.0
    """Factor on the extinction, 0 to 1e9: a microscope's scans need large ones."""
    albedo: float = 1.0
    """Fraction of light that survives a scattering, 0 to 1."""
    anisotropy: float = 0.0
    """Henyey-Greenstein mean cosine g, -0.99 to 0.99; positive scatters forward."""
    bounces: int = 100
    """Most scatterings along a path, 1 to 1000."""
    filter: Filter = "smooth"
    """How values between voxels are found."""
    surface: SurfaceReflection = field(default_factory=SurfaceReflection)
    """Reflection at surfaces."""
    extinction_space: Literal["volume", "world"] = "volume"
    """In which space a millimetre of extinction is measured."""

    def __post_init__(self) -> None:
        curve(self.transfer_function)
        _check.number("density", self.density, 0.0, 1e9)
        _check.number("albedo", self.albedo, 0.0, 1.0)
        _check.number("anisotropy", self.anisotropy, -0.99, 0.99)
        object.__setattr__(self, "bounces", _check.whole("bounces", self.bounces, 1, 1000))
        _check.choice("filter", self.filter, FILTERS)
        if not isinstance(self.surface, SurfaceReflection):
            raise TypeError(f"surface must be a lumivox.SurfaceReflection, not {_check.shown(self.surface)}")
        _check.choice("extinction_space", self.extinction_space, ("volume", "world"))


@dataclass(frozen=True)
class Preset:
    """A named look for a kind of scan."""

    name: str
    """As it is typed: ``ct-bone``."""
    description: str
    """What it shows."""

    def medium(self, volume: Volume) -> Medium:
        """The look, placed for a volume."""
        return preset_medium(self.name, volume)[1]


def presets() -> list[Preset]:
    """Every preset."""
    return [Preset(name, description) for name, description in _native.presets()]


def default_preset(volume: Volume) -> str:
    """The name of the preset that suits a volume when nobody chose one."""
    return _native.default_preset(volume.native)


def preset_medium(name: str, volume: Volume) -> tuple[str, Medium]:
    """A preset's name, as it is written, and its medium for a volume, with the smooth filter that all renders begin with."""
    if not isinstance(volume, Volume):
        raise TypeError(f"a preset is placed for a lumivox.Volume, not for {_check.shown(volume)}")
    name, words = _native.preset_look(preset_name(name), volume.native)
    return name, replace(_document.medium(json.loads(words)), filter="smooth")


def preset_name(name: Any) -> str:
    """A preset's name, if it is one."""
    if isinstance(name, Preset):
        return name.name
    if not isinstance(name, str):
        raise TypeError(f"preset must be a name, such as 'ct-bone', not {_check.shown(name)}; lumivox.presets() lists them")
    return name


def with_surface(medium: Medium, surface: bool | SurfaceReflection | None) -> Medium:
    """A medium with reflection switched on or off, or its own where nothing is said."""
    if isinstance(surface, SurfaceReflection):
        return replace(medium, surface=surface)
    if surface is not None and not isinstance(surface, bool):
        raise TypeError(f"surface must be True, False or a lumivox.SurfaceReflection, not {_check.shown(surface)}")
    if surface is False:
        return replace(medium, surface=SurfaceReflection())
    if surface is True and medium.surface.strength == 0.0:
        return replace(medium, surface=replace(medium.surface, strength=1.0))
    return medium


def curve(given: Any) -> TransferFunction:
    """A transfer function that is one."""
    if not isinstance(given, TransferFunction):
        made_by = "lumivox.load_transfer_function(path) reads one"
        raise TypeError(f"transfer_function must be a lumivox.TransferFunction, not {_check.shown(given)}; {made_by}")
    return given


def _points(name: str, given: Any) -> list[Any]:
    """The points of a curve, each a sequence."""
    points = list(given) if isinstance(given, Iterable) and not isinstance(given, str) else None
    if points is None or not all(isinstance(point, Sequence | np.ndarray) for point in points):
        raise TypeError(f"{name} must be a list of points, not {_check.shown(given)}")
    return points


def _knot(point: Any) -> OpacityKnot:
    if len(point) not in (2, 3) or not all(_check.is_number(part) for part in point[:2]):
        raise ValueError(f"an opacity knot is (value, opacity) or (value, opacity, ease), not {_check.shown(point)}")
    ease = point[2] if len(point) == 3 else "linear"
    return OpacityKnot(float(point[0]), float(point[1]), _check.choice("ease", ease, ("linear", "in-out")))


def _stop(point: Any) -> ColorStop:
    if len(point) != 2 or not _check.is_number(point[0]):
        raise ValueError(f"a colour stop is (value, (red, green, blue)), not {_check.shown(point)}")
    if isinstance(point[1], str):
        return ColorStop(float(point[0]), _check.color("a colour", point[1]))
    # Which numbers a colour may have is said by those that all hosts ask.
    return ColorStop(float(point[0]), _check.vector("a colour", point[1], "linear red, green and blue"))


def _row(point: Any) -> GradientFunction:
    if len(point) != 2 or not isinstance(point[1], TransferFunction):
        raise ValueError(f"a row of gradients is (per_mm, transfer_function), not {_check.shown(point)}")
    if point[1].gradients:
        raise ValueError("a row of gradients has none of its own")
    if not (_check.is_number(point[0]) and 0.0 < point[0] < 1e12):
        raise ValueError(f"per_mm is {_check.shown(point[0])}, and not a number above 0")
    return GradientFunction(float(point[0]), point[1])
