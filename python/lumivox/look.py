"""How a scan is to look: transfer functions, media, presets."""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from typing import Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from lumivox import _native
from lumivox.volume import PathLike, Volume

Rgb = tuple[float, float, float]
Filter = Literal["nearest", "trilinear", "tricubic", "smooth"]


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


@dataclass(frozen=True)
class TransferFunction:
    """Opacity and colour of physical values (HU for CT). Beyond the first and the last point, their values hold.

    ``opacity`` takes tuples ``(value, opacity)`` or ``(value, opacity, ease)``, ``color`` tuples ``(value, (r, g, b))``.
    """

    opacity: tuple[OpacityKnot, ...]
    color: tuple[ColorStop, ...]

    def __init__(
        self,
        opacity: Iterable[tuple[float, float] | tuple[float, float, str]],
        color: Iterable[tuple[float, Sequence[float]]],
    ) -> None:
        knots = tuple(sorted((OpacityKnot(*knot) for knot in opacity), key=lambda knot: knot.value))
        stops = tuple(sorted((ColorStop(value, _rgb(rgb)) for value, rgb in color), key=lambda stop: stop.value))
        object.__setattr__(self, "opacity", knots)
        object.__setattr__(self, "color", stops)
        # Asks for no value, and finds what is wrong with the points.
        _native.transfer_function_at(self, [])

    def at(self, values: npt.ArrayLike) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
        """Opacity (n) and linear RGB (n, 3) at n physical values."""
        found = _native.transfer_function_at(self, np.asarray(values, dtype=np.float64).ravel().tolist())
        opacity = np.array([opacity for opacity, _ in found])
        return opacity, np.array([color for _, color in found]).reshape(-1, 3)

    def save(self, path: PathLike, unit: str = "HU") -> None:
        """Writes it as :func:`load_transfer_function`, the command and all other hosts read it."""
        _native.save_transfer_function(os.fspath(path), self, unit)


def load_transfer_function(path: PathLike, value_range: tuple[float, float] = (-1024.0, 3071.0)) -> TransferFunction:
    """Reads a transfer function, of Lumivox's or of UnityVolumeRendering's making.

    Old ``.tf`` files are relative to the smallest and largest value of the scan that they are for.
    """
    opacity, color = _native.load_transfer_function(os.fspath(path), list(value_range))
    return TransferFunction(opacity, color)


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

    def __post_init__(self) -> None:
        _within("strength", self.strength, 0.0, 1.0)
        _within("gradient_per_mm", self.gradient_per_mm, 1e-9, 1e12)
        _within("roughness", self.roughness, 0.0, 1.0)
        _within("specular", self.specular, 0.0, 1.0)


@dataclass(frozen=True)
class Medium:
    """How a volume meets light: transfer function, phase function and scale factors.

    Extinction is ``opacity(value) * density`` per millimetre of the volume's own space.
    """

    transfer_function: TransferFunction
    density: float = 1.0
    """Factor on the extinction, 0 to 1000."""
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
        _within("density", self.density, 0.0, 1e3)
        _within("albedo", self.albedo, 0.0, 1.0)
        _within("anisotropy", self.anisotropy, -0.99, 0.99)
        _within("bounces", self.bounces, 1, 1000)


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
    name, parts = _native.preset_medium(name, volume.native)
    (opacity, color), density, albedo, anisotropy, bounces, _filter, surface = parts
    curve = TransferFunction(opacity, color)
    return name, Medium(curve, density, albedo, anisotropy, bounces, "smooth", SurfaceReflection(*surface))


def with_surface(medium: Medium, surface: bool | SurfaceReflection | None) -> Medium:
    """A medium with reflection switched on or off, or its own where nothing is said."""
    if isinstance(surface, SurfaceReflection):
        return replace(medium, surface=surface)
    if surface is False:
        return replace(medium, surface=SurfaceReflection())
    if surface is True and medium.surface.strength == 0.0:
        return replace(medium, surface=replace(medium.surface, strength=1.0))
    return medium


def _within(name: str, value: float, low: float, high: float) -> None:
    if not low <= value <= high:
        raise ValueError(f"{name} must be {low:g} to {high:g}")


def _rgb(color: Sequence[float]) -> Rgb:
    r, g, b = (float(part) for part in color)
    return r, g, b
