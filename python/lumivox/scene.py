"""What is rendered, from where and in which light. All of it is plain data that compares, copies and pickles."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from lumivox import _check, _document, _native, classification, look
from lumivox._check import Matrix, PathLike, Vector
from lumivox.classification import ClipShape, Labelled, LabelStyle, Peel
from lumivox.labels import Labels, load_labels
from lumivox.light import ALL_LAYERS, Environment, EnvironmentMap, Light, environment_of, lights_of
from lumivox.look import Filter, Medium, SurfaceReflection, TransferFunction
from lumivox.volume import StageProgress, Volume

Vec3 = tuple[float, float, float]
Curve = TransferFunction | str | os.PathLike[str]
"""A transfer function, or a file of one."""


@dataclass(frozen=True)
class VolumeInstance:
    """One volume in a scene. Any number may overlap, rotated and scaled at will."""

    volume: Volume
    medium: Medium
    clip: tuple[Vector, Vector] = ((0.0, 0.0, 0.0), (1.0, 1.0, 1.0))
    """What is kept, as opposite corners; fractions along the voxel axes x, y, z."""
    world_from_patient: Matrix | None = None
    """3 x 4: the scene's millimetres from LPS millimetres. Default: upright, the first volume's centre at the origin."""
    layers: int = 1
    """Bits: lights reach it whose ``layers`` share one of them."""
    labels: Labels | None = None
    """Which of its parts are what."""
    label_styles: Labelled | Sequence[tuple[int, LabelStyle]] = ()
    """How these look: a dict by name, number or ``"*"``, of styles or the command's words for them; kept by value."""
    clip_shapes: ClipShape | Sequence[ClipShape] = ()
    """What is kept of it besides, by each of them."""
    peel: Peel | None = None
    """What of it lies too near to the skin to be seen."""

    def __post_init__(self) -> None:
        if not isinstance(self.volume, Volume):
            raise TypeError(f"volume must be a lumivox.Volume, not {_check.shown(self.volume)}")
        if not isinstance(self.medium, Medium):
            made_by = "lumivox.Scene.of(volume, preset=...) makes one of a preset"
            raise TypeError(f"medium must be a lumivox.Medium, not {_check.shown(self.medium)}; {made_by}")
        object.__setattr__(self, "clip", _clip(self.clip))
        if self.world_from_patient is not None:
            object.__setattr__(self, "world_from_patient", _check.rows("world_from_patient", self.world_from_patient))
            self._say_if_tiny()
        _check.whole("layers", self.layers, 0, ALL_LAYERS)
        if self.labels is not None and not isinstance(self.labels, Labels):
            raise TypeError(f"labels must be lumivox.Labels, not {_check.shown(self.labels)}")
        object.__setattr__(self, "label_styles", self._styles())
        object.__setattr__(self, "clip_shapes", classification.clip_shapes("clip_shapes", self.clip_shapes))
        if self.peel is not None and not isinstance(self.peel, Peel):
            raise TypeError(f"peel must be a lumivox.Peel, not {_check.shown(self.peel)}")

    def _say_if_tiny(self) -> None:
        """Metres in place of millimetres make it a thousandth as large, and nothing of it is seen."""
        scale = abs(float(np.linalg.det(np.array(self.world_from_patient)[:, :3]))) ** (1 / 3)
        if scale < 0.005:
            _check.warn(f"world_from_patient makes the volume {scale:.2g} times as large: it is of millimetres, not metres")

    def _styles(self) -> tuple[tuple[int, LabelStyle], ...]:
        given: Any = self.label_styles
        if isinstance(given, Sequence) and all(isinstance(pair, tuple) and len(pair) == 2 for pair in given):
            given = dict(given)
        if not given:
            return ()
        if self.labels is None:
            raise ValueError("label_styles are of labels, and there are none; give labels, too")
        return classification.styles(self.labels, self.volume, given)


@dataclass(frozen=True)
class Scene:
    """Volumes in the light of an environment and of any number of lights."""

    volumes: tuple[VolumeInstance, ...]
    environment: Environment = field(default_factory=Environment)
    lights: tuple[Light, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "volumes", _instances(self.volumes))
        if not isinstance(self.environment, Environment):
            raise TypeError(f"environment must be a lumivox.Environment, not {_check.shown(self.environment)}")
        object.__setattr__(self, "lights", lights_of("lights", self.lights))

    def save(self, path: PathLike, camera: Camera | None = None, **options: Any) -> None:
        """Writes the scene to a file that every host of Lumivox opens, as ``lumivox scene save`` does.

        ``options`` are those of :func:`lumivox.render` for the camera, in place of ``camera``, and for the image: ``size``,
        ``samples``, ``seed``, ``noise``, ``denoise``, ``exposure``, ``tone``, ``gamma``, ``background``. Scans, labels and maps
        are named, not copied: what was made in memory is to be written and loaded first, or ``ValueError`` says so.
        """
        from lumivox import scene_files

        scene_files.save(self, path, camera, options)

    @classmethod
    def load(cls, path: PathLike, *, allow_outside_data: bool = False, progress: StageProgress | None = None) -> Scene:
        """The scene of a file; :func:`lumivox.load_scene` brings its camera and image, too."""
        from lumivox import scene_files

        return scene_files.load_scene(path, allow_outside_data=allow_outside_data, progress=progress).scene

    @property
    def _written(self) -> str:
        """Its document, for the native half; what follows comes beside it."""
        return _document.text(_document.of_scene(self))

    @property
    def _parts(self) -> list[_document.Part]:
        return [
            (
                one.volume.native,
                None if one.labels is None else one.labels.native,
                None if one.peel is None else one.peel.depth.native,
            )
            for one in self.volumes
        ]

    @property
    def _map(self) -> _native.EnvironmentMap | None:
        source = self.environment.source
        return source.native if isinstance(source, EnvironmentMap) else None

    def scene_from_patient(self) -> npt.NDArray[np.float64]:
        """3 x 4: the scene's millimetres from LPS millimetres of the first volume's patient."""
        first = self.volumes[0]
        if first.world_from_patient is not None:
            return np.array(first.world_from_patient)
        upright = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])
        return np.column_stack([upright, -upright @ np.array(first.volume.center)])

    @classmethod
    def of(
        cls,
        volumes: Volume | Sequence[Volume],
        *,
        preset: str | Sequence[str] | None = None,
        transfer_function: Curve | Sequence[Curve] | None = None,
        shift: float | Sequence[float] = 0.0,
        window_scale: float | Sequence[float] = 1.0,
        window: tuple[float, float] | Sequence[tuple[float, float] | None] | None = None,
        density: float | Sequence[float | None] | None = None,
        albedo: float | None = None,
        anisotropy: float | None = None,
        bounces: int | None = None,
        surface: bool | SurfaceReflection | None = None,
        filter: Filter = "smooth",
        peel: float | None = None,
        peel_mm: float | None = None,
        clip: tuple[Vector, Vector] | None = None,
        clip_shape: ClipShape | Sequence[ClipShape] = (),
        labels: Labels | Literal["found"] | PathLike | None = None,
        label: Labelled | None = None,
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
        if peel is not None and peel_mm is not None:
            raise ValueError("peel and peel_mm exclude each other")
        if label is not None and labels is None:
            raise ValueError("label says how labels look, and there are none; give labels, too")
        for name, mm in (("peel", peel), ("peel_mm", peel_mm)):
            if mm is not None:
                _check.number(name, mm, 0.0, classification.MOST_PEELED_MM)
        shifts = _numbers("shift", shift, len(given), -1e9, 1e9)
        scales = _numbers("window_scale", window_scale, len(given), 0.01, 100.0)
        windows = _windows(window, len(given))
        if window is not None and (set(shifts), set(scales)) != ({0.0}, {1.0}):
            raise ValueError("window says all that shift and window_scale do; give it or them")
        densities = _numbers("density", density, len(given), 0.0, 1e9)
        _check.called("progress", progress, "(stage, done, total)")
        names = _each("preset", preset, len(given), str | look.Preset)
        for one in names:
            if one is not None:
                look.preset_name(one)
        curves = _each("transfer_function", transfer_function, len(given), TransferFunction | str | os.PathLike)
        if any(name is not None and curve is not None for name, curve in zip(names, curves, strict=True)):
            raise ValueError("preset and transfer_function exclude each other")
        shapes = classification.clip_shapes("clip_shape", clip_shape)
        kept, light_from, lights = _clip(clip), environment_of(environment), lights_of("light", light)
        from_file = _labels(labels)
        placed = []
        for place, (volume, name, curve) in enumerate(zip(given, names, curves, strict=True)):
            look_of = None if name is None else look.preset_name(name)
            shown = _shown(volume, look_of, curve is not None, 0.0 if peel_mm is not None else peel, progress)
            _, medium = look.preset_medium(look_of or look.default_preset(shown), shown)
            if curve is not None:
                medium = replace(medium, transfer_function=_curve(curve, shown))
            asked = windows[place]
            function = medium.transfer_function
            dense = densities[place]
            medium = replace(
                medium,
                transfer_function=function.in_window(*asked) if asked else function.windowed(shifts[place], scales[place]),
                density=medium.density if dense is None else dense,
                albedo=medium.albedo if albedo is None else albedo,
                anisotropy=medium.anisotropy if anisotropy is None else anisotropy,
                bounces=medium.bounces if bounces is None else bounces,
                filter=filter,
            )
            found = from_file
            if labels == "found":
                found = volume.labels or volume.segment(progress).labels
            elif from_file is not None:
                _look_at_place(from_file, shown, len(given) == 1)
            instance = VolumeInstance(
                shown,
                look.with_surface(medium, surface),
                kept,
                labels=found,
                label_styles={} if label is None else label,
                clip_shapes=shapes,
                peel=_peel(volume, peel_mm, progress),
            )
            if label is not None and found is not None:
                classification.say_if_unseen(cls((instance,)), found, label)
            placed.append(instance)
        _say_if_apart(given)
        _check.number("environment_strength", environment_strength, 0.0, 1e6)
        _check.number("environment_rotation", environment_rotation)
        strength = light_from.strength * environment_strength
        light_from = replace(light_from, strength=strength, rotation=light_from.rotation + environment_rotation)
        return cls(tuple(placed), light_from, lights)


@dataclass(frozen=True)
class Camera:
    """Where a scene is seen from."""

    world_from_camera: Matrix
    """3 x 4: the scene's millimetres from the camera's, which looks along -z, with y upwards; a rotation and a place."""
    fov: float = 28.0
    """Degrees between the bottom and the top of the image."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "world_from_camera", _check.pose("world_from_camera", self.world_from_camera))
        _check.number("fov", self.fov)

    @classmethod
    def look_at(cls, eye: Vector, target: Vector, up: Vector = (0.0, 1.0, 0.0), fov: float = 28.0) -> Camera:
        """A camera at ``eye`` that looks at ``target``.

        Both are millimetres from the first scan's centre: x to the patient's left, y to the head, z to the viewer.
        """
        at, towards = _check.vector("eye", eye), _check.vector("target", target)
        return cls(_native.look_at(at, towards, _check.vector("up", up), _check.number("fov", fov, 1e-3, 179.0)), fov)

    @classmethod
    def framing(
        cls,
        scene: Scene,
        azimuth: float | None = None,
        elevation: float | None = None,
        zoom: float = 1.0,
        fov: float = 28.0,
        *,
        size: tuple[int, int] = (768, 768),
        target: Vector | None = None,
    ) -> Camera:
        """A camera around all that is seen of a scene, for images of ``size`` (width, height).

        - ``azimuth``: degrees it turns around the patient; 0 sees the face, 90 the patient's left.
        - ``elevation``: degrees it rises, -90 to 90. Default of both: 0, but a scan of a single slice is seen from its front.
        - ``zoom``: how many times closer than where everything fits.
        - ``target``: the point looked at, as ``eye``. Default: the centre of what is seen.
        """
        if not isinstance(scene, Scene):
            made_by = "lumivox.Scene.of(volume, preset=...) makes one of a volume"
            raise TypeError(f"scene must be a lumivox.Scene, not {_check.shown(scene)}; {made_by}")
        _check.number("zoom", zoom, 1e-3, 1e3)
        return cls._of(scene, azimuth, elevation, zoom, fov, size, None, target)

    @classmethod
    def _of(
        cls,
        scene: Scene,
        azimuth: float | None,
        elevation: float | None,
        zoom: float | None,
        fov: float,
        size: tuple[int, int],
        eye: Vector | None,
        target: Vector | None,
    ) -> Camera:
        """As scenes in files say it; what is ``None`` is as usual."""
        if azimuth is not None:
            _check.number("azimuth", azimuth)
        if elevation is not None:
            _check.number("elevation", elevation, -90.0, 90.0)
        _check.number("fov", fov, 1e-3, 179.0)
        width, height = pixels(size)
        at, around = (None if point is None else _check.vector(name, point) for name, point in (("eye", eye), ("target", target)))
        return cls(_native.frame(scene, azimuth, elevation, zoom, fov, width / height, at, around), fov)

    def project(self, points: npt.ArrayLike, size: tuple[int, int]) -> npt.NDArray[np.float64]:
        """Where points of the scene (..., 3), in its millimetres, are in an image of ``size`` (width, height).

        (..., 3): the column and the row, whole numbers at the borders of pixels, (0, 0) top left; and the depth in mm, which is
        negative behind the camera.
        """
        (width, height), matrix = pixels(size), np.array(self.world_from_camera)
        at = (_points("points", points) - matrix[:, 3]) @ matrix[:, :3]
        depth = -at[..., 2]
        scale = height / (2.0 * np.tan(np.radians(self.fov) / 2.0))
        with np.errstate(divide="ignore", invalid="ignore"):
            columns, rows = width / 2.0 + scale * at[..., 0] / depth, height / 2.0 - scale * at[..., 1] / depth
        return np.stack([columns, rows, depth], axis=-1)

    def unproject(self, places: npt.ArrayLike, size: tuple[int, int]) -> npt.NDArray[np.float64]:
        """The points of the scene (..., 3), in mm, that :meth:`project` puts there: of columns, rows and depths (..., 3)."""
        (width, height), matrix = pixels(size), np.array(self.world_from_camera)
        given = _points("places", places)
        depth = given[..., 2]
        scale = 2.0 * np.tan(np.radians(self.fov) / 2.0) / height
        x, y = (given[..., 0] - width / 2.0) * scale * depth, (height / 2.0 - given[..., 1]) * scale * depth
        made: npt.NDArray[np.float64] = np.stack([x, y, -depth], axis=-1) @ matrix[:, :3].T + matrix[:, 3]
        return made


LARGEST_SIDE = 32_768

MOST_PIXELS = 1 << 28


def pixels(size: Any) -> tuple[int, int]:
    """Width and height of an image that can be."""
    sides = tuple(size) if isinstance(size, Sequence | np.ndarray) and not isinstance(size, str) else ()
    if len(sides) != 2 or not all(_check.is_number(side) for side in sides):
        raise TypeError(f"size must be width and height in pixels, such as (768, 768), not {_check.shown(size)}")
    if any(side != side // 1 for side in sides):
        raise ValueError(f"size must be whole numbers of pixels, not {_check.shown(size)}")
    width, height = (int(side) for side in sides)
    if not (1 <= width <= LARGEST_SIDE and 1 <= height <= LARGEST_SIDE):
        raise ValueError(f"size: width and height must be 1 to {LARGEST_SIDE}, not {_check.shown(size)}")
    if width * height > MOST_PIXELS:
        raise ValueError(f"size: {width * height // 1_000_000} million pixels are too many")
    return width, height


def _points(name: str, given: npt.ArrayLike) -> npt.NDArray[np.float64]:
    """Triples of numbers."""
    made = np.asarray(given, dtype=np.float64)
    if made.ndim == 0 or made.shape[-1] != 3:
        raise ValueError(f"{name} must be three numbers, or an array of such (..., 3), not {_check.shown(given)}")
    return made


def _instances(given: Any) -> tuple[VolumeInstance, ...]:
    """What is in a scene, if it can be."""
    made = (given,) if isinstance(given, VolumeInstance | Volume) or not isinstance(given, Sequence) else tuple(given)
    for one in made:
        if not isinstance(one, VolumeInstance):
            made_by = "lumivox.Scene.of(volume, preset=...) makes a scene of a volume"
            raise TypeError(f"a scene's volumes are lumivox.VolumeInstance, not {_check.shown(one)}; {made_by}")
    return made


def _labels(given: Any) -> Labels | None:
    """Labels as they are, or of a file."""
    if given is None or isinstance(given, Labels):
        return given
    if isinstance(given, str | os.PathLike):
        return None if given == "found" else load_labels(given)
    made_by = "lumivox.Labels.from_array(array, like=scan) makes some of an array"
    raise TypeError(f"labels must be lumivox.Labels, a file or 'found', not {_check.shown(given)}; {made_by}")


def _look_at_place(labels: Labels, volume: Volume, only: bool) -> None:
    """Says where labels are not those of a scan."""
    if not any(labels.native.counts()[1:]):
        _check.warn("nothing is labelled")
    misplaced = labels.native.misplaced(volume.native)
    if misplaced is not None:
        none_lies_in_it, why = misplaced
        if none_lies_in_it and only:
            raise ValueError(why)
        _check.warn(why)


def _say_if_apart(volumes: list[Volume]) -> None:
    """Says where a scan lies so far from the first that they can hardly be of one patient in one place."""
    boxes = [volume.bounds for volume in volumes]
    for number, (low, high) in enumerate(boxes[1:], 2):
        first_low, first_high = boxes[0]
        gap = np.maximum(0.0, np.maximum(np.subtract(low, first_high), np.subtract(first_low, high)))
        apart, largest = float(np.linalg.norm(gap)), max(np.linalg.norm(np.subtract(b, a)) for a, b in (boxes[0], (low, high)))
        if apart > largest:
            _check.warn(f"scan {number} lies {apart:.0f} mm from the first: are they of one patient, in the same space?")


def _shown(volume: Volume, preset: str | None, own: bool, peel: float | None, progress: StageProgress | None) -> Volume:
    """Which part of a volume is seen: that depends on the look, for skin hides what some are for."""
    by_look = None if own else preset or look.default_preset(volume)
    shown, note = volume.native.shown(by_look, peel, progress)
    if note is not None:
        _check.warn(note)
    return Volume(shown)


def _peel(volume: Volume, mm: float | None, progress: StageProgress | None) -> Peel | None:
    if mm is None:
        return None
    depth = volume.skin_depth(progress)
    if depth is None:
        if mm > 0.0:
            _check.warn("nothing is peeled: no skin was found, as in all that is no CT of a body")
        return None
    return Peel(depth, mm)


def _curve(given: Any, volume: Volume) -> TransferFunction:
    return given if isinstance(given, TransferFunction) else look.load_transfer_function(given, volume.value_range)


def _volumes(volumes: Volume | Sequence[Volume]) -> list[Volume]:
    """Volumes that are some."""
    given: list[Any] = list(volumes) if isinstance(volumes, list | tuple) else [volumes]
    for one in given:
        if not isinstance(one, Volume):
            made_by = "lumivox.load(path) or lumivox.Volume.from_array(array) makes one"
            raise TypeError(f"a lumivox.Volume is needed, not {type(one).__name__}: {made_by}")
    return given


def _each(name: str, given: Any, count: int, kind: Any) -> list[Any]:
    """What was given once for all, or once for each."""
    if given is None or isinstance(given, kind):
        return [given] * count
    several = list(given) if isinstance(given, list | tuple) else [given]
    for one in several:
        if one is not None and not isinstance(one, kind):
            what = "a name, such as 'ct-bone'" if name == "preset" else "a lumivox.TransferFunction or a file of one"
            more = "; lumivox.presets() lists them" if name == "preset" else ""
            raise TypeError(f"{name} must be {what}, not {_check.shown(one)}{more}")
    return _spread(name, several, count)


def _spread(name: str, several: list[Any], count: int) -> list[Any]:
    """What was given once for all scans, for each."""
    if len(several) not in (1, count):
        times, what = len(several), "scan" if count == 1 else "scans"
        raise ValueError(f"{name} is given {times} times for {count} {what}; give it once for all, or once for each")
    return several * count if len(several) == 1 else several


def _numbers(name: str, given: Any, count: int, low: float, high: float) -> list[Any]:
    """Numbers, for each scan."""
    several = list(given) if isinstance(given, list | tuple) else [given]
    return [None if one is None else _check.number(name, one, low, high) for one in _spread(name, several, count)]


def _windows(given: Any, count: int) -> list[tuple[float, float] | None]:
    """Levels and widths, for each scan."""

    def window(one: Any) -> tuple[float, float] | None:
        if one is None:
            return None
        if not isinstance(one, list | tuple) or len(one) != 2 or not all(_check.is_number(part) for part in one):
            raise TypeError(f"window must be a level and a width, such as (40, 400), not {_check.shown(one)}")
        return _check.number("window", one[0], -1e9, 1e9), _check.number("window", one[1], 1e-9, 1e9)

    is_one = not isinstance(given, list | tuple) or (len(given) == 2 and all(_check.is_number(one) for one in given))
    return [window(one) for one in _spread("window", [given] if is_one else list(given), count)]


def _clip(clip: Any) -> tuple[Vec3, Vec3]:
    if clip is None:
        return (0.0, 0.0, 0.0), (1.0, 1.0, 1.0)
    corners = "two corners, ((x, y, z), (x, y, z)), each of fractions from 0 to 1 along the voxel axes"
    try:
        (a, b, c), (d, e, f) = (_check.vector("clip", corner) for corner in clip)
    except (TypeError, ValueError):
        raise ValueError(f"clip must be {corners}, not {_check.shown(clip)}") from None
    if not (0.0 <= a < d <= 1.0 and 0.0 <= b < e <= 1.0 and 0.0 <= c < f <= 1.0):
        raise ValueError("clip must be fractions from 0 to 1, each low one below its high one")
    return (a, b, c), (d, e, f)
