"""Images: layers of light as arrays, and how they become pixels."""

from __future__ import annotations

import os
import re
import tempfile
from dataclasses import asdict, dataclass, field, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from lumivox import _check, _native
from lumivox._check import PathLike
from lumivox.scene import Camera, Scene

Array = npt.NDArray[np.float32]
MM_PER_METRE = 1e3


@dataclass(frozen=True)
class Display:
    """How light becomes pixels."""

    background: str = "#14171c"
    """What stands behind: ``"transparent"``, ``"environment"``, or a colour as ``"#rrggbb"``."""
    exposure: float = 0.0
    """Stops brighter, or darker if negative."""
    tone: str = "agx"
    """``"agx"`` and ``"aces"`` are filmic, ``"plain"`` clips."""
    gamma: float = 1.0
    """Exponent 1/gamma on the pixels after the tone map."""

    def __post_init__(self) -> None:
        word = self.background
        if not isinstance(word, str) or not re.fullmatch("transparent|environment|#[0-9a-fA-F]{6}", word):
            known = "transparent, environment or a colour such as #202428"
            raise (ValueError if isinstance(word, str) else TypeError)(f"background must be {known}, not {_check.shown(word)}")
        _check.number("exposure", self.exposure, -32.0, 32.0)
        _check.choice("tone", self.tone, ("agx", "aces", "plain"))
        _check.number("gamma", self.gamma, 0.1, 10.0)


@dataclass(frozen=True, eq=False)
class Image:
    """A rendered image: its layers, and its picture. Rows count from the top; light is linear RGB with sRGB primaries."""

    film: _native.Film = field(repr=False)
    """The sums of which the layers are means."""
    scene: Scene = field(repr=False)
    camera: Camera = field(repr=False)
    display: Display = field(default_factory=Display)
    complete: bool = True
    """Whether it has all the samples that were asked for; with a ``time`` alone, as many as that allowed."""
    seconds: float = 0.0
    """Time spent tracing."""
    notes: tuple[str, ...] = ()
    """What is worth knowing about it, as sentences."""
    smoothed: bool = False
    """Whether noise was smoothed out, so that what is left of it is not known."""

    def __repr__(self) -> str:
        width, height = self.size
        count = "1 sample" if self.min_samples == 1 else f"{self.min_samples} samples"
        parts = [f"{width} x {height} pixels", count, f"{self.seconds:.3g} s"]
        noise = self.noise
        parts += [] if noise is None else [f"noise {100.0 * noise:.2g}%"]
        parts += ["denoised"] if self.smoothed else []
        parts += [] if self.complete else ["not complete"]
        return f"<lumivox.Image: {', '.join(parts)}>"

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> npt.NDArray[Any]:
        """:attr:`pixels`, for numpy and Pillow."""
        if copy is False:
            raise ValueError("pixels are made when they are asked for")
        pixels = self.pixels
        return pixels if dtype is None else pixels.astype(dtype, copy=False)

    @property
    def size(self) -> tuple[int, int]:
        """Width and height in pixels."""
        width, height = self.film.size
        return width, height

    @property
    def radiance(self) -> Array:
        """Mean radiance scattered by the volumes (rows, columns, 3); what stands behind is not in it."""
        return self.film.radiance()

    @property
    def alpha(self) -> Array:
        """The fraction of rays that met something (rows, columns), 0 to 1."""
        return self.film.alpha()

    @property
    def depth(self) -> Array:
        """Millimetres along the view to what rays met first, averaged (rows, columns); infinite where they met nothing."""
        return self.film.depth() * np.float32(MM_PER_METRE)

    @property
    def positions(self) -> Array:
        """Where rays met something first, averaged (rows, columns, 3): LPS millimetres of the first scan's patient.

        Infinite where they met nothing.
        """
        width, height = self.size
        columns, rows = np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5)
        depth = self.depth.astype(np.float64)
        with np.errstate(invalid="ignore"):
            places = self.camera.unproject(np.stack([columns, rows, depth], axis=-1), self.size)
            from_scene = np.linalg.inv(np.vstack([self.scene.scene_from_patient(), [0.0, 0.0, 0.0, 1.0]]))
            places = places @ from_scene[:3, :3].T + from_scene[:3, 3]
        return np.where(np.isfinite(depth)[..., None], places, np.inf).astype(np.float32)

    @property
    def variance(self) -> Array:
        """Variance of the mean luminance (rows, columns), infinite before a second sample; that before it was denoised."""
        return self.film.variance()

    @property
    def samples(self) -> Array:
        """Paths that each pixel has (rows, columns)."""
        return self.film.samples()

    @property
    def albedo(self) -> Array | None:
        """Mean albedo of what rays met first (rows, columns, 3); ``None`` unless rendered with ``layers=True``."""
        return self.film.albedo()

    @property
    def normal(self) -> Array | None:
        """Mean normal of what rays met first (rows, columns, 3): x to the patient's left, y to the head, z to the viewer.

        ``None`` unless rendered with ``layers=True``.
        """
        return self.film.normal()

    @property
    def noise(self) -> float | None:
        """The noise left, as a fraction of the brightness.

        ``None`` before a second sample, where nothing is seen, and of a denoised image: what is left then is not known.
        """
        return None if self.smoothed else self.film.noise

    @property
    def min_samples(self) -> int:
        """Paths of the pixel that has the fewest."""
        return self.film.min_samples

    def shown(self, **display: Any) -> Image:
        """The same image with other ``background``, ``exposure``, ``tone`` or ``gamma``: nothing is rendered again."""
        for option in display:
            if option not in Display.__annotations__:
                raise TypeError(f"there is no option '{option}'; there are {', '.join(Display.__annotations__)}")
        return replace(self, display=replace(self.display, **display))

    def denoised(self) -> Image:
        """The same image with less noise, for a little bias; better of one rendered with ``layers=True``."""
        return self if self.smoothed else replace(self, film=self.film.denoised(), smoothed=True)

    @property
    def pixels(self) -> npt.NDArray[np.uint8]:
        """The picture (rows, columns, 4): red, green, blue and straight alpha as screens show them, 8 bits each."""
        show = self.display
        return self.film.pixels(self.scene, self.camera, show.background, show.exposure, show.tone, show.gamma)

    def save(self, path: PathLike) -> None:
        """Writes the picture as ``.png``, or all layers in linear light as ``.exr``.

        Channels of the latter are R, G, B (radiance, premultiplied) and A, ``Z`` (depth in mm), ``variance``, and
        ``albedo.R`` to ``normal.Z`` where there are any; 32-bit floats.
        """
        name = _check.file("path", path)
        folder = _check.writable(name)
        ending = os.path.splitext(name)[1].lower()
        if ending == ".png":
            data = _native.encode_png(self.pixels)
        elif ending == ".exr":
            data = _native.encode_exr(self._channels(), False)
        else:
            raise ValueError(f"{name}: the output must end in .png or .exr")
        # Under another name first: nobody ever sees half of one.
        try:
            handle, partial = tempfile.mkstemp(prefix=".lumivox-", suffix=".partial", dir=folder)
        except OSError as error:
            # Of the name that was given, not of the one that nobody knows.
            raise type(error)(f"{name} cannot be written: {error.strerror}") from None
        try:
            # Such a file is its owner's alone; a picture has the rights that all new files have.
            mask = os.umask(0)
            os.umask(mask)
            os.chmod(partial, 0o666 & ~mask)
            with os.fdopen(handle, "wb") as file:
                file.write(data)
            os.replace(partial, name)
        except BaseException:
            if os.path.exists(partial):
                os.remove(partial)
            raise

    def save_scene(self, path: PathLike, **options: Any) -> None:
        """Writes what it shows, from where and how, to a file that every host of Lumivox opens: see :meth:`Scene.save`, which
        ``options`` are for."""
        samples = max(1, self.min_samples)
        self.scene.save(path, self.camera, **{"size": self.size, "samples": samples, **asdict(self.display), **options})

    def _channels(self) -> list[tuple[str, Array]]:
        channels = list(zip("RGB", np.moveaxis(self.radiance, 2, 0), strict=True))
        channels += [("A", self.alpha), ("Z", self.depth), ("variance", self.variance)]
        for name, layer, parts in (("albedo", self.albedo, "RGB"), ("normal", self.normal, "XYZ")):
            if layer is not None:
                channels += [(f"{name}.{part}", layer[..., i]) for i, part in enumerate(parts)]
        return [(name, np.ascontiguousarray(plane)) for name, plane in channels]

    def _repr_png_(self) -> bytes:
        return _native.encode_png(self.pixels)

    def __reduce__(self) -> tuple[Any, ...]:
        parts = (self.film.sums(), self.scene, self.camera, self.display, self.complete, self.seconds, self.notes, self.smoothed)
        return _unpickle, parts


def _unpickle(sums: Array, *rest: Any) -> Image:
    # What came over a network may lie at odd addresses.
    return Image(_native.Film(np.require(sums, requirements=["C", "A"])), *rest)
