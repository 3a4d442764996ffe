"""Light: what surrounds a scene, suns and lamps."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from lumivox import _check, _native
from lumivox._check import PathLike, Vector

ALL_LAYERS = (1 << 32) - 1
"""The bits of all layers."""

SOURCES = ("studio", "uniform", "gradient")
"""Light that needs no map."""


class EnvironmentMap:
    """Light from all directions: an equirectangular map of radiance, linear RGB.

    Row 0 is straight up, the last row straight down; the centre column is what a viewer of the face has ahead.
    """

    __slots__ = ("native",)

    def __init__(self, texels: npt.ArrayLike) -> None:
        """Of radiance (rows, columns, 3)."""
        try:
            shape = np.shape(texels)
        except ValueError:
            shape = ()
        if len(shape) != 3 or shape[2] != 3 or np.asarray(texels).dtype.kind not in "biuf":
            raise ValueError(f"an environment map must be numbers of (rows, columns, 3), not {_check.shown(texels)}")
        self.native = _native.EnvironmentMap(np.require(texels, np.float32, ["C", "A"]))

    @classmethod
    def load(cls, path: PathLike) -> EnvironmentMap:
        """Reads an equirectangular ``.hdr`` or ``.exr`` file."""
        return cls._of(_native.load_environment(_check.file("path", path)))

    @classmethod
    def _of(cls, native: _native.EnvironmentMap) -> EnvironmentMap:
        made = cls.__new__(cls)
        made.native = native
        return made

    @property
    def array(self) -> npt.NDArray[np.float32]:
        """Radiance (rows, columns, 3): a copy."""
        return self.native.array()

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, EnvironmentMap):
            return NotImplemented
        return self.native is other.native or np.array_equal(self.array, other.array)

    def __hash__(self) -> int:
        return hash(self.array.tobytes())

    def __copy__(self) -> EnvironmentMap:
        return self

    def __deepcopy__(self, _: Any) -> EnvironmentMap:
        return self

    def __reduce__(self) -> tuple[Any, ...]:
        return EnvironmentMap, (self.array,)


@dataclass(frozen=True)
class Environment:
    """The light around a scene."""

    source: str | EnvironmentMap = "studio"
    """``"studio"``, ``"uniform"``, ``"gradient"``, or a map."""
    strength: float = 1.0
    """Factor on the light."""
    rotation: float = 0.0
    """Degrees it turns around the vertical, as ``azimuth`` turns the camera."""
    color: Vector = (1.0, 1.0, 1.0)
    """Radiance of a uniform one."""
    zenith: Vector = (1.5, 1.6, 1.8)
    """Radiance of a gradient from straight up."""
    horizon: Vector = (1.0, 1.0, 1.0)
    """Radiance of a gradient from the horizon."""
    nadir: Vector = (0.16, 0.15, 0.14)
    """Radiance of a gradient from straight down."""

    def __post_init__(self) -> None:
        if not isinstance(self.source, str | EnvironmentMap):
            known = "'studio', 'uniform', 'gradient' or a lumivox.EnvironmentMap"
            raise TypeError(f"source must be {known}, not {_check.shown(self.source)}")
        if isinstance(self.source, str) and self.source not in SOURCES:
            raise ValueError(f"environment '{self.source}' is not 'studio', 'uniform', 'gradient' or a map")
        _check.number("strength", self.strength, 0.0, 1e6)
        _check.number("rotation", self.rotation)
        for name in ("color", "zenith", "horizon", "nadir"):
            object.__setattr__(self, name, _check.light(name, getattr(self, name)))


@dataclass(frozen=True)
class Sun:
    """Distant light, from where ``azimuth`` and ``elevation`` would put the camera, in degrees.

    At strength 1 a white surface that faces it is as bright as under a uniform environment.
    """

    azimuth: float
    elevation: float
    strength: float = 1.0
    degrees: float = 0.27
    """Its radius in the sky."""
    layers: int = ALL_LAYERS
    """Bits: it reaches volumes that share one of them."""

    def __post_init__(self) -> None:
        _check.whole("layers", self.layers, 0, ALL_LAYERS)
        _check.number("azimuth", self.azimuth)
        _check.number("elevation", self.elevation, -90.0, 90.0)
        _check.number("strength", self.strength, 0.0, 1e6)
        _check.number("degrees", self.degrees, 0.0, 90.0)


@dataclass(frozen=True)
class DirectionalLight:
    """Distant light by its direction, as engines and scenes in files have it; a :class:`Sun` says the same in angles."""

    direction: Vector
    """Where the light travels to, in the scene's space."""
    irradiance: Vector = (np.pi, np.pi, np.pi)
    """Linear RGB; at pi a white surface that faces it is as bright as under a uniform environment."""
    degrees: float = 0.27
    """Its radius in the sky."""
    layers: int = ALL_LAYERS
    """Bits: it reaches volumes that share one of them."""

    def __post_init__(self) -> None:
        _check.whole("layers", self.layers, 0, ALL_LAYERS)
        object.__setattr__(self, "direction", _check.vector("direction", self.direction))
        object.__setattr__(self, "irradiance", _check.light("irradiance", self.irradiance))
        _check.number("degrees", self.degrees, 0.0, 90.0)
        if not any(self.direction):
            raise ValueError("the light travels nowhere: direction is zero")


@dataclass(frozen=True)
class PointLight:
    """A bulb: it shines on volumes and is not seen itself."""

    position: Vector
    """Millimetres in the scene's space."""
    intensity: Vector = (1.0, 1.0, 1.0)
    """Irradiance at 1 m."""
    radius: float = 0.0
    """Millimetres; larger ones have softer shadows."""
    layers: int = ALL_LAYERS
    """Bits: it reaches volumes that share one of them."""
    decay: float | None = 2.0
    """The power of the distance that it gets weaker by, 2 by nature; ``None``: as lights of Unity's built-in pipeline do."""
    range: float | None = None
    """Millimetres from where on it does not shine."""

    def __post_init__(self) -> None:
        _lamp(self)


@dataclass(frozen=True)
class SpotLight:
    """A bulb that shines into a cone."""

    position: Vector
    """Millimetres in the scene's space."""
    target: Vector
    """The point that its axis goes through."""
    half_angle: float = 30.0
    """Degrees from the axis to the edge of the cone."""
    intensity: Vector = (1.0, 1.0, 1.0)
    """Irradiance at 1 m, on the axis."""
    radius: float = 0.0
    """Millimetres; larger ones have softer shadows."""
    layers: int = ALL_LAYERS
    """Bits: it reaches volumes that share one of them."""
    decay: float | None = 2.0
    """As a :class:`PointLight`'s."""
    range: float | None = None
    """As a :class:`PointLight`'s."""
    attenuation: float = 1.0
    """The power of the distance to the cone's edge that it gets weaker by."""
    inner_half_angle: float | None = None
    """In its place: degrees from the axis up to which it does not get weaker."""

    def __post_init__(self) -> None:
        _lamp(self)
        _check.number("attenuation", self.attenuation, 0.0, 1e3)
        if self.inner_half_angle is not None:
            _check.number("inner_half_angle", self.inner_half_angle, 0.0, self.half_angle)
        object.__setattr__(self, "target", _check.vector("target", self.target))
        _check.number("half_angle", self.half_angle, 0.0, 90.0)
        if self.target == self.position:
            raise ValueError("target is the light's position; move one of them")


Light = Sun | DirectionalLight | PointLight | SpotLight


def _lamp(lamp: PointLight | SpotLight) -> None:
    object.__setattr__(lamp, "position", _check.vector("position", lamp.position))
    object.__setattr__(lamp, "intensity", _check.light("intensity", lamp.intensity))
    _check.number("radius", lamp.radius, 0.0, _check.FURTHEST_MM)
    _check.whole("layers", lamp.layers, 0, ALL_LAYERS)
    if lamp.decay is not None:
        _check.number("decay", lamp.decay, 0.0, 100.0)
    elif lamp.range is None:
        raise ValueError("decay is None, which is relative to the light's range; give it one")
    if lamp.range is not None:
        _check.number("range", lamp.range, 1e-9, _check.FURTHEST_MM)


def lights_of(name: str, given: Any) -> tuple[Light, ...]:
    """Lights that are some."""
    made = tuple(given) if isinstance(given, list | tuple) else (given,)
    for one in made:
        if not isinstance(one, Light):
            example = "such as lumivox.Sun(40, 30)"
            raise TypeError(
                f"{name} must be a lumivox.Sun, DirectionalLight, PointLight or SpotLight, {example}, not {_check.shown(one)}"
            )
    return made


def environment_of(given: Any) -> Environment:
    """Light of a name, a file or a map."""
    if isinstance(given, Environment):
        return given
    if isinstance(given, EnvironmentMap) or (isinstance(given, str) and given in SOURCES):
        return Environment(given)
    if isinstance(given, str | os.PathLike):
        name = _check.file("environment", given)
        if not os.path.exists(name):
            raise ValueError(f"environment {_check.shown(given)} is not {_check.listed(SOURCES)}, nor a file")
        return Environment(EnvironmentMap.load(name))
    known = "'studio', 'uniform', 'gradient', an .hdr or .exr file, or a lumivox.Environment or EnvironmentMap"
    raise TypeError(f"environment must be {known}, not {_check.shown(given)}")
