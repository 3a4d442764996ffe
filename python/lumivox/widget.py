"""A scan in a notebook, live: turn it with the mouse, choose a preset, drag its opacity.

    from lumivox import widget

    view = widget.View(scan)
    view

Needs anywidget (``pip install 'lumivox[widget]'``). What was set with the mouse is there as attributes: ``view.azimuth``,
``view.transfer_function``; ``view.image`` is what is shown.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from lumivox import look, rendering
from lumivox.image import Image
from lumivox.look import ColorStop, OpacityKnot, TransferFunction
from lumivox.scene import Camera, Scene
from lumivox.volume import Volume

try:
    import anywidget
    import traitlets
except ImportError as error:
    raise ImportError("lumivox.widget needs anywidget: pip install 'lumivox[widget]'") from error

COARSE = 4
"""While something changes, pixels along an axis for one."""

BINS = 64
"""Bars of the histogram behind the opacity curve."""


@dataclass(frozen=True)
class Settings:
    """What a view shows, and from where."""

    azimuth: float = 0.0
    elevation: float = 0.0
    zoom: float = 1.0
    preset: str | None = None
    transfer_function: TransferFunction | None = None


class Live:
    """Renders a scan on a thread of its own: coarse at once after a change, finer and finer while it rests.

    ``show`` is called there with each image; :meth:`update` may be called on any thread and returns at once.
    """

    def __init__(self, scan: Volume, size: tuple[int, int], samples: int, show: Callable[[Image], None], **options: Any) -> None:
        self._scan, self._size, self._samples, self._show, self._options = scan, size, samples, show, options
        self._changed = threading.Condition()
        self._settings: Settings | None = None
        self._ended = False
        self._scenes: dict[tuple[Any, ...], Scene] = {}
        self.error: Exception | None = None
        """What went wrong; the view stays as it was."""
        self._thread = threading.Thread(target=self._run, name="lumivox-widget", daemon=True)
        self._thread.start()

    def update(self, settings: Settings) -> None:
        """Shows something else from now on."""
        with self._changed:
            self._settings = settings
            self._changed.notify_all()

    def end(self) -> None:
        """Ends the thread."""
        with self._changed:
            self._ended = True
            self._changed.notify_all()
        self._thread.join()

    def _run(self) -> None:
        while True:
            with self._changed:
                while self._settings is None and not self._ended:
                    self._changed.wait()
                if self._ended:
                    return
                settings, self._settings = self._settings, None
            assert settings is not None
            try:
                self._render(settings)
            except Exception as error:
                self.error = error

    def _wanted(self, *_: object) -> bool:
        return self._settings is None and not self._ended

    def _render(self, settings: Settings) -> None:
        scene = self._scene(settings)
        camera = Camera.framing(scene, settings.azimuth, settings.elevation, settings.zoom, size=self._size)
        width, height = self._size
        coarse = (max(1, width // COARSE), max(1, height // COARSE))
        options: Any = {name: value for name, value in self._options.items() if name not in rendering.LOOK}
        # Denoised, for it is gone in a moment; what rests is left as it is.
        self._show(rendering.render(scene, **{**options, "camera": camera, "size": coarse, "samples": 1, "denoise": True}))
        if not self._wanted():
            return
        rest = {**options, "camera": camera, "size": self._size, "samples": self._samples, "progress": self._wanted}
        for image in rendering.progressive(scene, **rest):
            if not self._wanted():
                return
            self._show(image)

    def _scene(self, settings: Settings) -> Scene:
        """The scene of a look; the last is kept, for most changes are the camera's."""
        key = (settings.preset, settings.transfer_function)
        if key not in self._scenes:
            looks: Any = {name: value for name, value in self._options.items() if name in rendering.LOOK}
            scene = Scene.of(self._scan, **{**looks, "preset": settings.preset})
            if settings.transfer_function is not None:
                instance = scene.volumes[0]
                medium = replace(instance.medium, transfer_function=settings.transfer_function)
                scene = replace(scene, volumes=(replace(instance, medium=medium),))
            self._scenes = {key: scene}
        return self._scenes[key]


class View(anywidget.AnyWidget):  # type: ignore[misc]
    """A scan in a notebook. ``options`` are those of :func:`lumivox.render` that it has no handle for."""

    _esm = Path(__file__).with_name("widget.js")
    png = traitlets.Bytes(b"").tag(sync=True)
    width = traitlets.Int(512).tag(sync=True)
    height = traitlets.Int(512).tag(sync=True)
    azimuth = traitlets.Float(0.0).tag(sync=True)
    elevation = traitlets.Float(0.0).tag(sync=True)
    zoom = traitlets.Float(1.0).tag(sync=True)
    preset = traitlets.Unicode("").tag(sync=True)
    presets = traitlets.List(traitlets.Unicode()).tag(sync=True)
    knots = traitlets.List().tag(sync=True)
    """Opacity knots ``[value, opacity, ease]`` of the look, as they are dragged."""
    stops = traitlets.List().tag(sync=True)
    """Colour stops ``[value, [r, g, b]]``, linear."""
    value_range = traitlets.List(traitlets.Float()).tag(sync=True)
    histogram = traitlets.List(traitlets.Float()).tag(sync=True)
    """Voxels by value, as fractions of the fullest bar, on a logarithmic scale."""
    samples = traitlets.Int(0).tag(sync=True)
    _live: Live | None = None

    def __init__(self, scan: Volume, *, size: tuple[int, int] = (512, 512), samples: int = 512, **options: Any) -> None:
        super().__init__()
        self._scan = scan
        self._image: Image | None = None
        self._quiet = False
        self._edited = False
        self.width, self.height = size
        self.presets = [preset.name for preset in look.presets()]
        low, high = scan.value_range
        self.value_range = [low, max(high, low + 1.0)]
        self.histogram = _histogram(scan)
        self.azimuth, self.elevation = options.pop("azimuth", 0.0), options.pop("elevation", 0.0)
        self.zoom = options.pop("zoom", 1.0)
        self.preset = options.pop("preset", None) or look.default_preset(scan)
        self._live = Live(scan, size, samples, self._shown, **options)
        self._take_preset()
        self.observe(self._on_preset, ["preset"])
        self.observe(self._on_curve, ["knots", "stops"])
        self.observe(self._on_change, ["azimuth", "elevation", "zoom"])
        self._on_change()

    @property
    def image(self) -> Image | None:
        """What is shown; ``None`` before there is anything."""
        return self._image

    @property
    def transfer_function(self) -> TransferFunction:
        """The look's opacity and colour, as they were edited."""
        return TransferFunction([OpacityKnot(*knot) for knot in self.knots], [ColorStop(v, tuple(c)) for v, c in self.stops])

    @transfer_function.setter
    def transfer_function(self, curve: TransferFunction) -> None:
        self.set_trait("stops", [[stop.value, list(stop.color)] for stop in curve.color])
        self.set_trait("knots", [list(knot) for knot in curve.opacity])

    def close(self) -> None:
        """Ends the view and its thread."""
        if self._live is not None:
            self._live.end()
        super().close()

    def _take_preset(self) -> None:
        _, medium = look.preset_medium(self.preset, self._scan)
        self._quiet = True
        try:
            self.transfer_function = medium.transfer_function
        finally:
            self._quiet = False
        self._edited = False

    def _on_preset(self, _: object) -> None:
        self._take_preset()
        self._on_change()

    def _on_curve(self, _: object) -> None:
        if not self._quiet:
            self._edited = True
            self._on_change()

    def _on_change(self, _: object = None) -> None:
        curve = self.transfer_function if self._edited else None
        # A page may send anything: what makes no sense is brought into its range.
        elevation, zoom = min(max(self.elevation, -90.0), 90.0), min(max(self.zoom, 0.1), 20.0)
        if self._live is not None:
            self._live.update(Settings(self.azimuth, elevation, zoom, self.preset, curve))

    def _shown(self, image: Image) -> None:
        self._image = image
        self.samples = image.min_samples
        self.png = image._repr_png_()

    def _repr_png_(self) -> bytes | None:
        return self.png or None


def _histogram(scan: Volume) -> list[float]:
    # Some 10 million voxels tell as much as all.
    step = max(1, round((scan.array.size / 1e7) ** (1 / 3)))
    values = scan.array[::step, ::step, ::step].astype(np.float64) * scan.slope + scan.intercept
    counts, _ = np.histogram(values, BINS, scan.value_range)
    bars = np.log1p(counts)
    return [float(bar) for bar in bars / max(bars.max(), 1.0)]
