"""What is rendered, from where and in which light. All of it is plain data that compares, copies and pickles."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from lumivox import _native, look
from lumivox.look import Filter, Medium, Rgb, SurfaceReflection, TransferFunction
from lumivox.volume import PathLike, StageProgress, Volume

Vec3 = tuple[float, float, float]
Rows = list[list[float]]


class EnvironmentMap:
    """Light from all directions: an equirectangular map of radiance, linear RGB.

    Row 0 is straight up, the last row straight down; the centre column is what a viewer of the face has ahead.
    """

    __slots__ = ("native",)

    def __init__(self, texels: npt.ArrayLike) -> None:
        """Of radiance (rows, columns, 3)."""
        self.native = _native.EnvironmentMap(np.require(texels, np.float32, ["C", "A"]))

    @classmethod
    def load(cls, path: PathLike) -> EnvironmentMap:
        """Reads an equirectangular ``.hdr`` or ``.exr`` file."""
        made = cls.__new__(cls)
        made.native = _native.load_environment(os.fspath(path))
        return made

    @property
    def array(self) -> npt.NDArray[np.float32]:
        """Radiance (rows, columns, 3): a copy."""
        return self.native.array()

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
    color: Rgb = (1.0, 1.0, 1.0)
    """Radiance of a uniform one."""
    zenith: Rgb = (1.5, 1.6, 1.8)
    """Radiance of a gradient from straight up."""
    horizon: Rgb = (1.0, 1.0, 1.0)
    """Radiance of a gradient from the horizon."""
    nadir: Rgb = (0.16, 0.15, 0.14)
    """Radiance of a gradient from straight down."""


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


@dataclass(frozen=True)
class PointLight:
    """A bulb: it shines on volumes and is not seen itself."""

    position: Vec3
    """Millimetres in the scene's space."""
    intensity: Rgb = (1.0, 1.0, 1.0)
    """Irradiance at 1 m."""
    radius: float = 0.0
    """Millimetres; larger ones have softer shadows."""


@dataclass(frozen=True)
class SpotLight:
    """A bulb that shines into a cone."""

    position: Vec3
    """Millimetres in the scene's space."""
    target: Vec3
    """The point that its axis goes through."""
    half_angle: float = 30.0
    """Degrees from the axis to the edge of the cone."""
    intensity: Rgb = (1.0, 1.0, 1.0)
    """Irradiance at 1 m, on the axis."""
    radius: float = 0.0
    """Millimetres; larger ones have softer shadows."""


Light = Sun | PointLight | SpotLight


@dataclass(frozen=True)
class VolumeInstance:
    """One volume in a scene. Any number may overlap, rotated and scaled at will."""

    volume: Volume
    medium: Medium
    clip: tuple[Vec3, Vec3] = ((0.0, 0.0, 0.0), (1.0, 1.0, 1.0))
    """What is kept, as opposite corners; fractions along the voxel axes x, y, z."""
    world_from_patient: Rows | None = None
    """3 x 4: metres of the scene's space from LPS millimetres. Default: upright, the first volume's centre at the origin."""
    layers: int = 1
    """Bits that it shares with the lights that reach it."""


@dataclass(frozen=True)
class Scene:
    """Volumes in the light of an environment and of any number of lights."""

    volumes: tuple[VolumeInstance, ...]
    environment: Environment = field(default_factory=Environment)
    lights: tuple[Light, ...] = ()

    @classmethod
    def of(
        cls,
        volumes: Volume | Sequence[Volume],
        *,
        preset: str | Sequence[str] | None = None,
        transfer_function: TransferFunction | Sequence[TransferFunction] | None = None,
        density: float | None = None,
        albedo: float | None = None,
        anisotropy: float | None = None,
        bounces: int | None = None,
        surface: bool | SurfaceReflection | None = None,
        filter: Filter = "smooth",
        peel: float | None = None,
        clip: tuple[Sequence[float], Sequence[float]] | None = None,
        environment: str | Environment | EnvironmentMap = "studio",
        environment_strength: float = 1.0,
        environment_rotation: float = 0.0,
        light: Light | Sequence[Light] = (),
        progress: StageProgress | None = None,
    ) -> Scene:
        """Volumes in the patient space they share, each with a look, as ``lumivox render`` makes them.

        Options are those of :func:`lumivox.render`; looks are given once for all volumes, or once for each.
        """
        given = _volumes(volumes)
        if not given:
            raise ValueError("a scene needs at least one volume")
        if preset is not None and transfer_function is not None:
            raise ValueError("preset and transfer_function exclude each other")
        names = _each("preset", preset, len(given), str)
        curves = _each("transfer_function", transfer_function, len(given), TransferFunction)
        placed = []
        for volume, name, curve in zip(given, names, curves, strict=True):
            # Which part is seen depends on the look: skin hides what some are for.
            by_look = None if curve is not None else name or look.default_preset(volume)
            shown = Volume(volume.native.peeled(by_look, peel, progress))
            _, medium = look.preset_medium(name or look.default_preset(shown), shown)
            if curve is not None:
                medium = replace(medium, transfer_function=curve)
            medium = replace(
                medium,
                density=medium.density if density is None else density,
                albedo=medium.albedo if albedo is None else albedo,
                anisotropy=medium.anisotropy if anisotropy is None else anisotropy,
                bounces=medium.bounces if bounces is None else bounces,
                filter=filter,
            )
            placed.append(VolumeInstance(shown, look.with_surface(medium, surface), _clip(clip)))
        light_from = environment
        if isinstance(light_from, EnvironmentMap):
            light_from = Environment(light_from)
        if isinstance(light_from, str):
            known = light_from in ("studio", "uniform", "gradient")
            light_from = Environment(light_from if known else EnvironmentMap.load(light_from))
        strength = light_from.strength * environment_strength
        light_from = replace(light_from, strength=strength, rotation=light_from.rotation + environment_rotation)
        lights = (light,) if isinstance(light, Sun | PointLight | SpotLight) else tuple(light)
        return cls(tuple(placed), light_from, lights)


@dataclass(frozen=True)
class Camera:
    """Where a scene is seen from."""

    world_from_camera: Rows
    """3 x 4: metres of the scene's space from the camera's, which looks along -z, with y upwards."""
    fov: float = 28.0
    """Degrees between the bottom and the top of the image."""

    @classmethod
    def look_at(
        cls, eye: Sequence[float], target: Sequence[float], up: Sequence[float] = (0.0, 1.0, 0.0), fov: float = 28.0
    ) -> Camera:
        """A camera at ``eye`` that looks at ``target``.

        Both are millimetres from the first scan's centre: x to the patient's left, y to the head, z to the viewer.
        """
        return cls(_native.look_at(list(eye), list(target), list(up), fov), fov)

    @classmethod
    def framing(
        cls,
        scene: Scene,
        azimuth: float = 0.0,
        elevation: float = 0.0,
        zoom: float = 1.0,
        fov: float = 28.0,
        *,
        size: tuple[int, int] = (768, 768),
        target: Sequence[float] | None = None,
    ) -> Camera:
        """A camera around all that is seen of a scene, for images of ``size`` (width, height).

        - ``azimuth``: degrees it turns around the patient; 0 sees the face, 90 the patient's left.
        - ``elevation``: degrees it rises, -90 to 90.
        - ``zoom``: how many times closer than where everything fits.
        - ``target``: the point looked at, as ``eye``. Default: the centre of what is seen.
        """
        if not -90.0 <= elevation <= 90.0:
            raise ValueError("elevation must be -90 to 90")
        if not 1e-3 <= zoom <= 1e3:
            raise ValueError("zoom must be 0.001 to 1000")
        around = None if target is None else list(target)
        rows, _ = _native.frame(scene, azimuth, elevation, zoom, fov, size[0] / size[1], around)
        return cls(rows, fov)


def _volumes(volumes: Volume | Sequence[Volume]) -> list[Volume]:
    """Volumes that are some."""
    given: list[Any] = list(volumes) if isinstance(volumes, list | tuple) else [volumes]
    for one in given:
        if not isinstance(one, Volume):
            made_by = "lumivox.load(path) or lumivox.Volume.from_array(array) makes one"
            raise TypeError(f"a lumivox.Volume is needed, not {type(one).__name__}: {made_by}")
    return given


def _each(name: str, given: Any, count: int, kind: type) -> list[Any]:
    """What was given once for all, or once for each."""
    if given is None or isinstance(given, kind):
        return [given] * count
    several = list(given)
    if len(several) not in (1, count):
        times, what = len(several), "scan" if count == 1 else "scans"
        raise ValueError(f"{name} is given {times} times for {count} {what}; give it once for all, or once for each")
    return several * count if len(several) == 1 else several


def _clip(clip: tuple[Sequence[float], Sequence[float]] | None) -> tuple[Vec3, Vec3]:
    if clip is None:
        return (0.0, 0.0, 0.0), (1.0, 1.0, 1.0)
    (a, b, c), (d, e, f) = ((float(part) for part in corner) for corner in clip)
    if not (0.0 <= a < d <= 1.0 and 0.0 <= b < e <= 1.0 and 0.0 <= c < f <= 1.0):
        raise ValueError("clip must be fractions from 0 to 1, each low one below its high one")
    return (a, b, c), (d, e, f)
