"""The active image of napari as a path-traced picture: *Plugins > Lumivox > Cinematic view*.

Dragging turns it, the wheel zooms. Its place is the layer's scale, rotation, shear and units; the topmost visible labels layer
in three dimensions colours it. ``metadata["modality"]`` (``"CT"`` or ``"MR"``) chooses what the first look is. Needs napari:
``pip install 'lumivox[napari]'``.
"""

from __future__ import annotations

import threading
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from lumivox import _check, look
from lumivox._check import Rgb
from lumivox.image import Image
from lumivox.labels import MOST, Labels, numbers_in
from lumivox.live import Live, Settings, usual_angles
from lumivox.look import TransferFunction
from lumivox.volume import Volume

try:
    from napari.layers import Image as ImageLayer
    from napari.layers import Labels as LabelsLayer
    from qtpy.QtCore import QObject, Qt, QTimer, Signal
    from qtpy.QtGui import QImage, QPixmap
    from qtpy.QtWidgets import QComboBox, QHBoxLayout, QLabel, QPushButton, QSizePolicy, QVBoxLayout, QWidget
except ImportError as error:
    raise ImportError("lumivox.napari needs napari: pip install 'lumivox[napari]'") from error

COLORMAP = "layer's colormap"
"""The look that the layer has in napari: its colormap, opaque towards the upper contrast limit."""

SIZE = (400, 400)

SAMPLES = 256

SETTLE = 200
"""Milliseconds without a change of a layer before its voxels are taken anew: painting changes them many times a second."""

EVENTS = ("data", "visible", "opacity", "colormap", "contrast_limits", "scale", "translate", "rotate", "shear", "affine", "units")


def patient_from_voxel(layer: Any) -> Any:
    """4 x 4: millimetres from voxel indices x, y, z, of the last three axes of a layer, which are z, y, x.

    napari's world is taken for the patient's, its axes reversed: they are LPS where the file's were.
    """
    corner = np.zeros(layer.ndim)
    origin = np.asarray(layer.data_to_world(corner), dtype=np.float64)
    matrix = np.eye(4)
    for axis in range(3):
        along = corner.copy()
        along[-1 - axis] = 1.0
        matrix[:3, axis] = (np.asarray(layer.data_to_world(along)) - origin)[-3:][::-1]
    matrix[:3, 3] = origin[-3:][::-1]
    return np.diag([*(_millimetres(unit) for unit in layer.units[-3:][::-1]), 1.0]) @ matrix


def _millimetres(unit: Any) -> float:
    """How long a unit is; pixels, and what is no length, are taken for millimetres."""
    try:
        return float((1 * unit).to("mm").magnitude)
    except Exception:
        return 1.0


def volume_of(layer: Any, step: tuple[int, ...] = ()) -> Volume:
    """An image layer as a volume; of more than three axes, the first stand at ``step``."""
    if layer.rgb:
        raise ValueError("an image of colours is no scan: one value for each voxel is needed")
    if layer.ndim < 3:
        raise ValueError(f"an image of three dimensions is needed, and '{layer.name}' has {layer.ndim}")
    matrix = patient_from_voxel(layer)
    modality = layer.metadata.get("modality", "")
    return Volume.from_array(_voxels(layer, step), origin=matrix[:3, 3].tolist(), orientation=matrix[:3, :3], modality=modality)


def labels_of(layer: Any, step: tuple[int, ...] = ()) -> Labels:
    """A labels layer as labels, with its colours; numbers beyond 255 are numbered anew, and names keep what they were."""
    array, matrix = _voxels(layer, step), patient_from_voxel(layer)
    numbers = np.array([number for number in numbers_in(array) if number > 0][:MOST], dtype=np.int64)
    values = {int(number): int(number) for number in numbers}
    if numbers.size and numbers[-1] > MOST:
        values = {int(number): place + 1 for place, number in enumerate(numbers)}
        found = np.searchsorted(numbers, array).clip(0, numbers.size - 1)
        array = np.where(numbers[found] == array, found + 1, 0)
    named = _names(layer)
    return Labels.from_array(
        array,
        (1.0, 1.0, 1.0),
        matrix[:3, 3].tolist(),
        matrix[:3, :3],
        names={value: named.get(number, f"label {number}") for number, value in values.items()},
        colors={value: _color(layer.get_color(number)) for number, value in values.items()},
    )


def colormap_of(layer: Any) -> TransferFunction:
    """What napari shows of an image layer as a function of its values."""
    low, high = (float(limit) for limit in layer.contrast_limits)
    places = np.linspace(0.0, 1.0, 17)
    values = low + (high - low) * places ** (1.0 / float(layer.gamma))
    stops = [(float(value), _color(rgba)) for value, rgba in zip(values, layer.colormap.map(places), strict=True)]
    return TransferFunction([(low, 0.0), (low + (high - low) * 0.25, 0.0), (high, 1.0)], stops)


def _voxels(layer: Any, step: tuple[int, ...]) -> Any:
    data = layer.data[0] if layer.multiscale else layer.data
    return np.asarray(data[tuple(step[: data.ndim - 3])] if data.ndim > 3 else data)


def _names(layer: Any) -> dict[int, str]:
    table = layer.features
    for column in ("name", "label", "names"):
        if column in table and "index" in table:
            return {int(index): str(name) for index, name in zip(table["index"], table[column], strict=True)}
    return {}


def _color(rgba: Any) -> Rgb:
    codes = (255.0 * np.asarray(rgba, dtype=np.float64)[:3]).round().clip(0, 255).astype(int)
    return _check.color("color", "#{:02x}{:02x}{:02x}".format(*codes))


def head() -> list[tuple[Any, dict[str, Any], str]]:
    """A head to try things on, as napari's sample data."""
    from lumivox import phantom

    scan = phantom("head", 96)
    z, y, x = scan.spacing[::-1]
    placed = {"scale": (z, y, x), "translate": scan.origin[::-1], "metadata": {"modality": "CT"}, "units": ("mm",) * 3}
    return [(scan.values, {"name": "head", "contrast_limits": (-1000, 1500), **placed}, "image")]


class Picture(QLabel):  # type: ignore[misc]
    """The picture, and the mouse on it."""

    turned = Signal(float, float)
    """Pixels that it was dragged."""
    zoomed = Signal(float)

    def __init__(self) -> None:
        super().__init__()
        self.setMinimumSize(160, 160)
        self.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Expanding)
        self.setAlignment(Qt.AlignmentFlag.AlignCenter)
        self.setWordWrap(True)
        self.setStyleSheet("background: #14171c; color: #c8ced6")
        self._at: tuple[float, float] | None = None
        self._shown: QPixmap | None = None

    def show_pixels(self, pixels: Any) -> None:
        """Shows RGBA pixels (rows, columns, 4)."""
        height, width, _ = pixels.shape
        rgba = np.ascontiguousarray(pixels)
        self._shown = QPixmap.fromImage(QImage(rgba.data, width, height, 4 * width, QImage.Format.Format_RGBA8888))
        self._fit()

    def say(self, words: str) -> None:
        """Shows words in place of a picture."""
        self._shown = None
        self.setText(words)

    def _fit(self) -> None:
        if self._shown is not None:
            keep, smooth = Qt.AspectRatioMode.KeepAspectRatio, Qt.TransformationMode.SmoothTransformation
            self.setPixmap(self._shown.scaled(self.size(), keep, smooth))

    def resizeEvent(self, event: Any) -> None:
        """Qt's."""
        super().resizeEvent(event)
        self._fit()

    def mousePressEvent(self, event: Any) -> None:
        """Qt's."""
        self._at = (event.position().x(), event.position().y())

    def mouseMoveEvent(self, event: Any) -> None:
        """Qt's."""
        if self._at is not None:
            x, y = event.position().x(), event.position().y()
            self.turned.emit(x - self._at[0], y - self._at[1])
            self._at = (x, y)

    def mouseReleaseEvent(self, event: Any) -> None:
        """Qt's."""
        self._at = None

    def wheelEvent(self, event: Any) -> None:
        """Qt's."""
        self.zoomed.emit(float(np.exp(event.angleDelta().y() / 600.0)))
        event.accept()


class Relay(QObject):  # type: ignore[misc]
    """Brings images to Qt's thread. It has no parent: a thread that ends late finds it alive, the view gone or not."""

    came = Signal(object)
    taken = Signal(object)
    went_wrong = Signal(str)


@dataclass(frozen=True)
class Taken:
    """What was taken of layers, or why nothing was."""

    layer: Any
    scan: Volume | None = None
    suited: str = ""
    """The preset that suits it."""
    options: dict[str, Any] = field(default_factory=dict)
    """Those of a render, for its labels."""
    failure: str = ""


def _gather(relay: Relay, layer: Any, painted: Any, step: tuple[int, ...]) -> None:
    """Takes the voxels of layers, on a thread of its own, and tells Qt's."""
    try:
        scan = volume_of(layer, step)
        options: dict[str, Any] = {}
        if painted is not None:
            labels = labels_of(painted, step)
            style = f"color,opacity:{painted.opacity:.3f}"
            options = {"labels": labels, "label": dict.fromkeys(labels.names, style)} if labels.names else {}
        relay.taken.emit(Taken(layer, scan, look.default_preset(scan), options))
    except Exception as error:
        relay.taken.emit(Taken(layer, failure=str(error)))


class View(QWidget):  # type: ignore[misc]
    """The dock widget. ``layer`` is the image that it shows, ``image`` what is shown of it."""

    def __init__(self, napari_viewer: Any) -> None:
        super().__init__()
        self.viewer = napari_viewer
        self.layer: Any = None
        self.image: Image | None = None
        self.settings = Settings()
        self._live: Live | None = None
        self._watched: list[Any] = []
        self._taking = False
        self._again = False
        self.picture = Picture()
        self.looks = QComboBox()
        self.looks.addItems([COLORMAP, *(preset.name for preset in look.presets())])
        self.count = QLabel("")
        self.keep = QPushButton("Keep as layer")
        self.keep.setToolTip("Adds what is shown as an image layer")
        row = QHBoxLayout()
        for part in (self.looks, self.count, self.keep):
            row.addWidget(part)
        column = QVBoxLayout(self)
        column.addWidget(self.picture, 1)
        column.addLayout(row)
        self._timer = QTimer(self)
        self._timer.setSingleShot(True)
        self._timer.setInterval(SETTLE)
        self._timer.timeout.connect(self._take)
        self._relay = Relay()
        self._relay.came.connect(self._show)
        self._relay.taken.connect(self._taken)
        self._relay.went_wrong.connect(self._say)
        self.picture.turned.connect(self._turn)
        self.picture.zoomed.connect(self._zoom)
        self.looks.activated.connect(self._look)
        self.keep.clicked.connect(self.keep_as_layer)
        self.viewer.layers.selection.events.active.connect(self._later)
        self.viewer.layers.events.inserted.connect(self._later)
        self.viewer.layers.events.removed.connect(self._later)
        self.viewer.layers.events.reordered.connect(self._later)
        self.viewer.dims.events.current_step.connect(self._step)
        self.destroyed.connect(self._end)
        self._take()

    def keep_as_layer(self) -> None:
        """Adds what is shown as an image layer of colours."""
        if self.image is not None:
            self.viewer.add_image(self.image.pixels[..., :3], name=f"{self.layer.name} (Lumivox)", rgb=True)

    def turn_to(self, azimuth: float, elevation: float, zoom: float | None = None) -> None:
        """Looks from there, as :meth:`Camera.framing` does."""
        self._update(
            azimuth=azimuth, elevation=min(max(elevation, -90.0), 90.0), zoom=self.settings.zoom if zoom is None else zoom
        )

    def _update(self, **changes: Any) -> None:
        self.settings = Settings(**{**vars(self.settings), **changes})
        if self._live is not None:
            self._live.update(self.settings)

    def _turn(self, x: float, y: float) -> None:
        degrees = 180.0 / max(self.picture.width(), 1)
        angles = self.settings.azimuth, self.settings.elevation
        if angles == (None, None) and self.image is not None:
            angles = usual_angles(self.image.scene)
        azimuth, elevation = (angle or 0.0 for angle in angles)
        self.turn_to(azimuth - x * degrees, elevation + y * degrees)

    def _zoom(self, factor: float) -> None:
        self._update(zoom=min(max(self.settings.zoom * factor, 0.1), 20.0))

    def _look(self, *_: object) -> None:
        self._update(**self._look_of(self.looks.currentText()))

    def _look_of(self, name: str) -> dict[str, Any]:
        if name == COLORMAP:
            return {"preset": "plain", "transfer_function": colormap_of(self.layer)}
        return {"preset": name, "transfer_function": None}

    def _later(self, *_: object) -> None:
        self._timer.start()

    def _step(self, *_: object) -> None:
        if self.layer is not None and self.layer.ndim > 3:
            self._later()

    def _take(self) -> None:
        """Takes the voxels of the active image, and of the labels above it."""
        active = self.viewer.layers.selection.active
        images = [layer for layer in self.viewer.layers if isinstance(layer, ImageLayer) and layer.ndim >= 3 and not layer.rgb]
        chosen = active if isinstance(active, ImageLayer) and not active.rgb else self.layer if self.layer in images else None
        chosen = chosen or (images[-1] if images else None)
        painted = [layer for layer in self.viewer.layers if isinstance(layer, LabelsLayer) and layer.ndim >= 3 and layer.visible]
        self._watch([layer for layer in (chosen, *self.viewer.layers) if isinstance(layer, ImageLayer | LabelsLayer)])
        if chosen is None:
            self.layer = None
            self._end()
            self._say("Open an image of three dimensions: a scan, a stack.")
            return
        if self._taking:
            # One at a time: what has changed meanwhile is taken after it.
            self._again = True
            return
        self._taking = True
        step = tuple(self.viewer.dims.current_step)
        # Seconds for large ones, in which napari goes on.
        arguments = (self._relay, chosen, painted[-1] if painted else None, step)
        threading.Thread(target=_gather, args=arguments, name="lumivox-take", daemon=True).start()

    def _taken(self, taken: Taken) -> None:
        """Shows what was taken."""
        self._taking = False
        if self._again:
            self._again = False
            self._take()
            return
        if taken.layer not in self.viewer.layers:
            return
        if taken.scan is None:
            self.layer = taken.layer
            self._end()
            self._say(taken.failure)
            return
        # Not "is": a plugin gets another proxy of a layer each time it asks.
        if taken.layer != self.layer:
            self.layer = taken.layer
            # What suits a scan, where it is known what it is or looks like a CT; else what napari shows.
            known = taken.scan.modality or taken.suited.startswith("ct-")
            self.looks.setCurrentText(taken.suited if known else COLORMAP)
        self._end()
        relay = self._relay

        def failed(error: Exception) -> None:
            relay.went_wrong.emit(str(error))

        self._live = Live(taken.scan, SIZE, SAMPLES, relay.came.emit, failed, **taken.options)
        self._update(**self._look_of(self.looks.currentText()))

    def _watch(self, layers: list[Any]) -> None:
        for layer in self._watched:
            for name in EVENTS:
                if hasattr(layer.events, name):
                    getattr(layer.events, name).disconnect(self._later)
        self._watched = list(dict.fromkeys(layers))
        for layer in self._watched:
            for name in EVENTS:
                if hasattr(layer.events, name):
                    getattr(layer.events, name).connect(self._later)
            if isinstance(layer, LabelsLayer):
                layer.events.paint.connect(self._later)

    def _show(self, image: Image) -> None:
        self.image = image
        self.picture.show_pixels(image.pixels)
        self.count.setText(f"{image.min_samples} of {SAMPLES} samples")

    def _say(self, words: str) -> None:
        self.image = None
        self.count.setText("")
        self.picture.say(words)

    def _end(self, *_: object) -> None:
        if self._live is not None:
            # Not waited for: it ends after its dispatch, and napari goes on.
            self._live.end(wait=False)
            self._live = None

    def closeEvent(self, event: Any) -> None:
        """Qt's."""
        self._end()
        super().closeEvent(event)
