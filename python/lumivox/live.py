"""A scan that is looked at while it is rendered: what the notebook's widget and napari's share."""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from lumivox import _native, rendering
from lumivox._check import PathLike
from lumivox.image import Image
from lumivox.look import TransferFunction
from lumivox.scene import Camera, Scene
from lumivox.volume import Volume

COARSE = 4
"""While something changes and no light is kept, pixels along an axis for one."""

CLEAN = 16
"""Samples from which an image at rest is shown in the place of one of kept light."""

REST = 2.0
"""Seconds without a change after which the thread ends."""

BINS = 64
"""Bars of a histogram."""


@dataclass(frozen=True)
class Settings:
    """What a view shows, and from where."""

    azimuth: float | None = None
    elevation: float | None = None
    zoom: float = 1.0
    preset: str | None = None
    transfer_function: TransferFunction | None = None


class Live:
    """Renders a scan on a thread of its own: at once after a change, finer and finer while it rests; then that ends.

    What is shown at once is a picture of the light that is kept in the scan, or, without ``kept_light`` and where the GPU
    has no room for that, a coarse one. At rest the image is the same in either case.

    ``show`` is called there with each image, ``failed`` with what went wrong; :meth:`update` may be called on any thread and
    returns at once.
    """

    def __init__(
        self,
        scan: Volume,
        size: tuple[int, int],
        samples: int,
        show: Callable[[Image], None],
        failed: Callable[[Exception], None],
        kept_light: bool = True,
        **options: Any,
    ) -> None:
        self._kept_light = kept_light
        self._tell: Callable[[Scene, Settings], None] | None = None
        self.renders = True
        """Whether it renders; else whoever is told of scenes does."""
        self._told: Scene | None = None
        self._moving: rendering.Moving | None = None
        self._scan, self._size, self._samples, self._options = scan, size, samples, options
        self._show, self._failed = show, failed
        self._changed = threading.Condition()
        self._settings: Settings | None = None
        self._ended = False
        self._scenes: dict[tuple[Any, ...], Scene] = {}
        self.error: Exception | None = None
        """What went wrong; the view stays as it was."""
        self._thread: threading.Thread | None = None

    def update(self, settings: Settings) -> None:
        """Shows something else from now on."""
        with self._changed:
            self._settings = settings
            self._changed.notify_all()
            if self._thread is None and not self._ended:
                self._thread = threading.Thread(target=self._run, name="lumivox-live", daemon=True)
                self._thread.start()

    def end(self, wait: bool = True) -> None:
        """Ends the thread, and waits for it."""
        with self._changed:
            self._ended = True
            self._changed.notify_all()
            thread = self._thread
        if wait and thread is not None:
            thread.join()
        if wait or thread is None:
            self._forget_light()

    def _run(self) -> None:
        while True:
            with self._changed:
                if self._settings is None and not self._ended:
                    self._changed.wait(REST)
                if self._ended or self._settings is None:
                    if self._ended:
                        self._forget_light()
                    # A view that nobody closed leaves no thread behind; the next change begins another.
                    self._thread = None
                    return
                settings, self._settings = self._settings, None
            assert settings is not None
            try:
                self._render(settings)
                self.error = None
            except Exception as error:
                self.error = error
                self._failed(error)

    def hand_over(self, tell: Callable[[Scene, Settings], None] | None, renders: bool, settings: Settings) -> None:
        """Tells of scenes from now on, beginning with that of ``settings``, and renders them, too, or not."""
        with self._changed:
            self._tell, self._told, self.renders = tell, None, renders
        self.update(settings)

    def now(self, settings: Settings) -> Image:
        """The image at rest, rendered on the caller's thread."""
        scene, rest = self._planned(settings)
        return rendering.render(scene, **{**rest, "progress": None})

    def save(self, settings: Settings, path: PathLike) -> None:
        """Writes the scene at rest to a file, see :meth:`Scene.save`."""
        scene, rest = self._planned(settings)
        kept = {name: rest[name] for name in ("size", "samples", *rendering.DISPLAY, "seed", "noise", "denoise") if name in rest}
        scene.save(path, rest["camera"], **kept)

    def _wanted(self, *_: object) -> bool:
        return self._settings is None and not self._ended

    def _planned(self, settings: Settings) -> tuple[Scene, dict[str, Any]]:
        """The scene, and options of the image at rest."""
        scene = self._scene(settings)
        fov = self._options.get("fov", 28.0)
        camera = Camera.framing(scene, settings.azimuth, settings.elevation, settings.zoom, fov, size=self._size)
        options: Any = {name: value for name, value in self._options.items() if name not in rendering.LOOK}
        return scene, {**options, "camera": camera, "size": self._size, "samples": self._samples, "progress": self._wanted}

    def _render(self, settings: Settings) -> None:
        with self._changed:
            tell, told, renders = self._tell, self._told, self.renders
        # Cameras are known to whoever is told.
        if tell is not None and (scene := self._scene(settings)) is not told:
            tell(scene, settings)
            with self._changed:
                if self._tell is tell:
                    self._told = scene
        if not renders:
            return
        scene, rest = self._planned(settings)
        first = self._of_kept_light(scene, rest)
        is_clean = first is not None
        if first is None:
            width, height = self._size
            coarse = (max(1, width // COARSE), max(1, height // COARSE))
            # Denoised, for it is gone in a moment; what rests is left as it is.
            first = rendering.render(scene, **{**rest, "size": coarse, "samples": 1, "denoise": True, "progress": None})
        if not self._ended:
            self._show(first)
        if not self._wanted():
            return
        last: Image | None = None
        for image in rendering.progressive(scene, **rest):
            if not self._wanted():
                return
            last = image
            # What is seen is not followed by what is noisier.
            if not is_clean or image.min_samples >= CLEAN:
                self._show(image)
                last = None
        if last is not None:
            self._show(last)

    def _of_kept_light(self, scene: Scene, options: Any) -> Image | None:
        """A picture of the light that is known now; of a part of an image there is none."""
        if not self._kept_light or options.get("region") is not None:
            return None
        if self._moving is None:
            self._moving = rendering.Moving(options.get("gpu"))
        return self._moving.picture(rendering.plan(scene, options))

    def _forget_light(self) -> None:
        if self._moving is not None:
            self._moving.end()
            self._moving = None

    def _scene(self, settings: Settings) -> Scene:
        """The scene of a look; the last is kept, for most changes are the camera's."""
        key = (settings.preset, settings.transfer_function)
        scene = self._scenes.get(key)
        if scene is None:
            looks: Any = {name: value for name, value in self._options.items() if name in rendering.LOOK}
            scene = Scene.of(self._scan, **{**looks, "preset": settings.preset})
            if settings.transfer_function is not None:
                instance = scene.volumes[0]
                medium = replace(instance.medium, transfer_function=settings.transfer_function)
                scene = replace(scene, volumes=(replace(instance, medium=medium),))
            self._scenes = {key: scene}
        return scene


def usual_angles(scene: Scene) -> tuple[float, float]:
    """Azimuth and elevation from which a scene is seen where nothing is said, which turning begins with."""
    azimuth, elevation = _native.usual_angles(scene)
    return azimuth, elevation


def histogram(scan: Volume) -> list[float]:
    """Voxels by value, as fractions of the fullest bar, on a logarithmic scale."""
    # Some 10 million voxels tell as much as all.
    step = max(1, round((scan.array.size / 1e7) ** (1 / 3)))
    values = scan.array[::step, ::step, ::step].astype(np.float64) * scan.slope + scan.intercept
    counts, _ = np.histogram(values, BINS, scan.value_range)
    bars = np.log1p(counts)
    return [float(bar) for bar in bars / max(bars.max(), 1.0)]
