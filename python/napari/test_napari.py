"""The plugin in a real napari, without a screen. `script/python --napari` runs it."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from typing import Any

import napari
import numpy as np
import pytest
from npe2 import PluginManager
from qtpy.QtCore import QEvent, QPointF, Qt
from qtpy.QtGui import QMouseEvent
from qtpy.QtWidgets import QApplication

import lumivox
from lumivox import napari as plugin

WAIT = 120.0
"""Seconds: software Vulkan compiles kernels on first use."""


@pytest.fixture
def viewer(monkeypatch: pytest.MonkeyPatch) -> Iterator[Any]:
    """A napari without a window on any screen, with the plugin as its manifest says."""
    monkeypatch.setattr(plugin, "SIZE", (48, 40))
    monkeypatch.setattr(plugin, "SAMPLES", 4)
    viewer = napari.Viewer(show=False)
    yield viewer
    viewer.close()


def until(done: Callable[[], bool]) -> None:
    deadline = time.monotonic() + WAIT
    while not done():
        QApplication.processEvents()
        assert time.monotonic() < deadline, "nothing happened"
        time.sleep(0.01)


def docked(viewer: Any) -> plugin.View:
    _, view = viewer.window.add_plugin_dock_widget("lumivox", "Cinematic view")
    assert isinstance(view, plugin.View)
    return view


def rests(view: plugin.View, unlike: Any = None) -> lumivox.Image:
    def done() -> bool:
        image = view.image
        return image is not None and image is not unlike and image.min_samples == 4 and image.size == (48, 40)

    until(done)
    assert view.image is not None
    return view.image


def scan(viewer: Any) -> Any:
    (layer,) = viewer.open_sample("lumivox", "head")
    return layer


def test_the_manifest_is_in_the_wheel_and_whole() -> None:
    manager = PluginManager.instance()
    manager.discover()
    manifest = manager.get_manifest("lumivox")
    manifest.validate_imports()
    assert manifest.display_name == "Lumivox"
    assert [widget.display_name for widget in manifest.contributions.widgets] == ["Cinematic view"]


def test_the_active_image_is_shown_in_its_place(viewer: Any) -> None:
    layer = scan(viewer)
    view = docked(viewer)
    # Voxels are taken on a thread of their own.
    assert view.layer is None
    image = rests(view)
    assert view.layer == layer
    own = lumivox.phantom("head", 96)
    found = plugin.volume_of(layer)
    np.testing.assert_array_equal(found.values, own.values)
    np.testing.assert_allclose(found.patient_from_voxel, own.patient_from_voxel, atol=1e-6)
    assert found.modality == "CT" and view.looks.currentText() == "ct-muscle"
    expected = lumivox.render(found, preset="ct-muscle", size=(48, 40), samples=4)
    np.testing.assert_allclose(image.radiance, expected.radiance, rtol=1e-5, atol=1e-5)
    # What stands in the dock is that picture.
    assert view.picture.pixmap() is not None and not view.picture.pixmap().isNull()
    view.keep_as_layer()
    kept = viewer.layers[-1]
    assert kept.rgb and kept.name == "head (Lumivox)"
    np.testing.assert_array_equal(kept.data, image.pixels[..., :3])


def test_the_mouse_turns_it_and_looks_change_it(viewer: Any) -> None:
    scan(viewer)
    view = docked(viewer)
    first = rests(view)
    view.picture.resize(180, 180)
    for kind, x, button in (
        (QEvent.Type.MouseButtonPress, 90.0, Qt.MouseButton.LeftButton),
        (QEvent.Type.MouseMove, 45.0, Qt.MouseButton.NoButton),
        (QEvent.Type.MouseButtonRelease, 45.0, Qt.MouseButton.LeftButton),
    ):
        at = QPointF(x, 90.0)
        event = QMouseEvent(kind, at, at, button, Qt.MouseButton.LeftButton, Qt.KeyboardModifier.NoModifier)
        QApplication.sendEvent(view.picture, event)
    assert view.settings.azimuth == 45.0
    turned = rests(view, first)
    assert (turned.pixels != first.pixels).any()
    view.looks.setCurrentText("ct-bone")
    view.looks.activated.emit(view.looks.currentIndex())
    bone = rests(view, turned)
    assert bone.scene.volumes[0].medium.transfer_function != turned.scene.volumes[0].medium.transfer_function


def test_scale_units_and_turns_are_millimetres_of_the_patient() -> None:
    data = np.random.default_rng(1).integers(0, 255, (4, 5, 6)).astype(np.uint8)
    layer = napari.layers.Image(data, scale=(2000, 500, 250), translate=(7000, 8000, 9000), units=("um",) * 3)
    volume = plugin.volume_of(layer)
    np.testing.assert_allclose(volume.patient_from_voxel[:3], [[0.25, 0, 0, 9], [0, 0.5, 0, 8], [0, 0, 2, 7]], atol=1e-9)
    turned = napari.layers.Image(data, affine=np.array([[0, 0, 3, 1], [1, 0, 0, 2], [0, 1, 0, 3], [0, 0, 0, 1.0]]))
    # napari's z, y, x of voxel (z 0, y 0, x 1): 3 further along its z, which is the patient's.
    np.testing.assert_allclose(plugin.volume_of(turned).patient_from_voxel @ [1, 0, 0, 1], [3, 2, 4, 1])
    series = napari.layers.Image(np.stack([data, data + 1]))
    np.testing.assert_array_equal(plugin.volume_of(series, (1, 0, 0, 0)).values, (data + 1).astype(np.float32))


def test_labels_layers_colour_it_and_follow_the_brush(viewer: Any) -> None:
    layer = scan(viewer)
    view = docked(viewer)
    plain = rests(view)
    array = np.zeros(layer.data.shape, np.int32)
    array[:48] = 7
    array[48:] = 70_000
    labels = viewer.add_labels(array, scale=layer.scale, translate=layer.translate, opacity=1.0, units=("mm",) * 3)
    viewer.layers.selection.active = layer
    coloured = rests(view, plain)
    found = coloured.scene.volumes[0].labels
    assert found is not None and found.names == ["label 7", "label 70000"]
    np.testing.assert_allclose(found.patient_from_voxel, coloured.scene.volumes[0].volume.patient_from_voxel, atol=1e-6)
    style = dict(coloured.scene.volumes[0].label_styles)[1]
    expected = np.array(labels.get_color(7)[:3])
    linear = np.where(expected <= 0.04045, expected / 12.92, ((expected + 0.055) / 1.055) ** 2.4)
    np.testing.assert_allclose(style.color, linear, atol=0.01)
    labels.fill((0, 0, 0), 3)
    painted = rests(view, coloured)
    assert painted.scene.volumes[0].labels is not None and "label 3" in painted.scene.volumes[0].labels.names
    labels.visible = False
    bare = rests(view, painted)
    assert bare.scene.volumes[0].labels is None
    np.testing.assert_array_equal(bare.pixels, plain.pixels)


def test_what_is_no_scan_is_told(viewer: Any) -> None:
    view = docked(viewer)
    assert view.picture.text().startswith("Open an image of three dimensions")
    viewer.add_image(np.zeros((8, 8)), name="flat")
    until(lambda: view.picture.text() == "an image of three dimensions is needed, and 'flat' has 2")
    viewer.add_image(np.zeros((8, 8, 8)) + np.arange(8.0), name="ramp")
    image = rests(view)
    assert view.layer.name == "ramp" and view.looks.currentText() == plugin.COLORMAP
    curve = image.scene.volumes[0].medium.transfer_function
    assert (curve.opacity[0].value, curve.opacity[-1].value) == (0.0, 7.0)
    view.layer.contrast_limits = (2, 5)
    other = rests(view, image)
    assert other.scene.volumes[0].medium.transfer_function.opacity[-1].value == 5.0
    viewer.layers.clear()
    until(lambda: view.picture.text().startswith("Open an image of three dimensions"))
