"""The notebook's view, without a browser: what a page would send, and what it would be sent."""

from __future__ import annotations

import json
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import traitlets

import lumivox
from lumivox import browser, live, widget


@pytest.fixture
def view(head: lumivox.Volume) -> Iterator[widget.View]:
    view = widget.View(head, size=(32, 24), samples=4, preset="ct-bone", azimuth=20.0)
    yield view
    view.close()


def wait(until: Callable[[], bool]) -> None:
    deadline = time.monotonic() + 60
    while not until():
        assert time.monotonic() < deadline, "nothing happened"
        time.sleep(0.01)


def test_a_single_slice_is_seen_from_its_front_and_turned_from_there() -> None:
    scan = lumivox.Volume.from_array(np.arange(480, dtype=np.uint16).reshape(1, 20, 24), modality="MR")
    view = widget.View(scan, size=(32, 24), samples=4)
    try:
        assert view.azimuth == 0.0 and view.elevation == pytest.approx(-90.0)
    finally:
        view.close()
    turned = widget.View(scan, size=(32, 24), samples=4, azimuth=30.0)
    turned.close()
    assert (turned.azimuth, turned.elevation) == (30.0, 0.0)


def rests(view: widget.View, azimuth: float) -> Callable[[], bool]:
    """Whether it shows all samples, from there."""

    def check() -> bool:
        image = view.image
        if image is None or image.min_samples < 4 or image.size != (32, 24):
            return False
        expected = lumivox.Camera.framing(image.scene, azimuth, size=(32, 24))
        return bool(np.allclose(image.camera.world_from_camera, expected.world_from_camera))

    return check


def test_a_view_comes_to_rest_and_is_the_renders_image(view: widget.View, head: lumivox.Volume) -> None:
    wait(rests(view, 20.0))
    assert view.png.startswith(b"\x89PNG") and view._repr_png_() == view.png
    own = lumivox.render(head, preset="ct-bone", azimuth=20.0, size=(32, 24), samples=4)
    assert view.image is not None
    np.testing.assert_allclose(view.image.radiance, own.radiance, rtol=1e-5, atol=1e-6)
    assert view.preset == "ct-bone" and "ct-skin" in view.presets
    assert len(view.histogram) == 64 and max(view.histogram) == 1.0


def test_what_is_shown_is_kept_as_a_scene(head_folder: Path, tmp_path: Path) -> None:
    view = widget.View(lumivox.load(head_folder), size=(32, 24), samples=4, preset="ct-bone", azimuth=20.0, tone="aces")
    try:
        wait(rests(view, 20.0))
        view.save_scene(tmp_path / "seen.json")
    finally:
        view.close()
    opened = lumivox.load_scene(tmp_path / "seen.json")
    assert (opened.size, opened.samples, opened.display.tone) == ((32, 24), 4, "aces")
    assert view.image is not None
    np.testing.assert_allclose(opened.render().radiance, view.image.radiance, rtol=1e-5, atol=1e-6)


def test_orbit_preset_and_opacity_change_what_is_shown(view: widget.View) -> None:
    wait(rests(view, 20.0))
    assert view.image is not None
    first = view.image.pixels
    # What a page sends while the mouse turns the patient.
    view.set_state({"azimuth": 110.0})
    wait(rests(view, 110.0))
    turned = view.image
    assert (turned.pixels != first).any()
    before = [list(knot) for knot in view.knots]
    view.set_state({"preset": "ct-skin"})
    assert view.knots != before, "the curve is the preset's"
    wait(lambda: view.image is not turned and rests(view, 110.0)())
    skin = view.image
    assert skin.scene.volumes[0].medium.transfer_function == view.transfer_function
    view.set_state({"knots": [[-500.0, 0.0, "linear"], [500.0, 0.25, "linear"]]})
    wait(lambda: view.image is not skin and view.image.scene.volumes[0].medium.transfer_function.opacity[-1].opacity == 0.25)
    assert view.transfer_function.opacity[1].value == 500.0


def test_what_makes_no_sense_breaks_nothing(view: widget.View) -> None:
    wait(rests(view, 20.0))
    view.set_state({"elevation": 1e9, "zoom": -4.0})
    view.set_state({"elevation": 0.0, "zoom": 1.0, "azimuth": 45.0})
    wait(rests(view, 45.0))


def test_options_of_a_view_are_told_where_it_is_made(head: lumivox.Volume) -> None:
    for words, options in (
        ("samples must be a whole number", {"samples": 1.5}),
        ("size must be width and height in pixels", {"size": 32}),
        ("there is no option 'azimut'; did you mean 'azimuth'?", {"azimut": 3}),
        ("there is no preset 'bone'", {"preset": "bone"}),
        ("eye is not for a view: it is turned by azimuth and elevation", {"eye": (0, 0, 900)}),
    ):
        with pytest.raises((TypeError, ValueError)) as told:
            widget.View(head, **options)  # type: ignore[arg-type]
        assert words in str(told.value)
    with pytest.raises(TypeError, match="a view shows a lumivox.Volume, not 'scan.nii'"):
        widget.View("scan.nii")  # type: ignore[arg-type]


def test_a_view_may_begin_with_a_function_labels_and_a_cut(head: lumivox.Volume) -> None:
    curve = lumivox.TransferFunction([(-500, 0.0), (300, 0.5, "in-out")], [(0, "#e0a080")])
    options: dict[str, object] = {
        "labels": "found",
        "label": {"air outside": "hide"},
        "clip_shape": lumivox.ClipShape.plane((0, 0, 0), (0, 0, -1)),
        "transfer_function": curve,
    }
    view = widget.View(head, size=(32, 24), samples=4, azimuth=20.0, **options)
    try:
        wait(rests(view, 20.0))
        assert view.transfer_function == curve
        own = lumivox.render(head, azimuth=20.0, size=(32, 24), samples=4, **options)  # type: ignore[arg-type]
        assert view.image is not None
        np.testing.assert_allclose(view.image.radiance, own.radiance, rtol=1e-5, atol=1e-5)
        # Rows for gradients are kept while the curve is dragged, which shows none of them.
        steep = lumivox.TransferFunction(curve.opacity, curve.color, [(50.0, curve)])
        view.transfer_function = steep
        wait(lambda: view.image is not None and view.image.scene.volumes[0].medium.transfer_function == steep)
    finally:
        view.close()


def test_what_goes_wrong_is_said_and_forgotten(view: widget.View) -> None:
    wait(rests(view, 20.0))
    shown = view.image
    view.set_state({"knots": []})
    assert view.message == "a transfer function needs at least one opacity knot"
    assert view.image is shown
    view.set_state({"knots": [[0.0, 0.0, "linear"], [500.0, 0.5, "linear"]]})
    wait(lambda: view.image is not shown and rests(view, 20.0)())
    assert view.message == ""


def test_a_preset_that_there_is_not_is_refused_and_blocks_nothing(view: widget.View) -> None:
    with pytest.raises(traitlets.TraitError, match="preset 'nonsense' is not one of"):
        view.preset = "nonsense"
    assert view.preset == "ct-bone"
    view.preset = "ct-skin"
    wait(rests(view, 20.0))
    assert view.message == ""


def test_a_view_at_rest_has_no_thread(head: lumivox.Volume, monkeypatch: pytest.MonkeyPatch) -> None:
    def threads() -> set[threading.Thread]:
        return {thread for thread in threading.enumerate() if thread.name == "lumivox-live"}

    monkeypatch.setattr(live, "REST", 0.1)
    before = threads()
    view = widget.View(head, size=(32, 24), samples=4, azimuth=20.0)
    wait(rests(view, 20.0))
    wait(lambda: not threads() - before)
    # And the next change is shown.
    view.azimuth = 50.0
    wait(rests(view, 50.0))
    view.close()
    assert not threads() - before


def first_images(head: lumivox.Volume, azimuths: list[float], **options: bool) -> list[lumivox.Image]:
    """What a view shows first after each turn."""
    came: list[lumivox.Image] = []
    wrong: list[Exception] = []
    view = live.Live(head, (64, 48), 32, came.append, wrong.append, **options, preset="ct-bone")
    firsts = []
    try:
        for azimuth in azimuths:
            before = len(came)
            view.update(live.Settings(azimuth=azimuth, preset="ct-bone"))
            # Of the view before one more may come.
            scene = lumivox.Scene.of(head, preset="ct-bone")
            seen = lumivox.Camera.framing(scene, azimuth, size=(64, 48)).world_from_camera

            def turned(before: int = before, seen: object = seen) -> list[lumivox.Image]:
                return [one for one in came[before:] if np.allclose(one.camera.world_from_camera, seen)]  # type: ignore[arg-type]

            wait(lambda: bool(turned()) or bool(wrong))
            firsts.append(turned()[0])
    finally:
        view.end()
    assert not wrong
    return firsts


def test_what_turns_is_nearer_to_its_image_at_rest_with_kept_light(head: lumivox.Volume) -> None:
    azimuths = [float(degrees) for degrees in range(20, 32)]
    kept = first_images(head, azimuths)[-1]
    coarse = first_images(head, azimuths[-1:], kept_light=False)[-1]
    assert (kept.size, coarse.size) == ((64, 48), (16, 12))
    assert kept.smoothed and not kept.complete
    rest = lumivox.render(head, preset="ct-bone", azimuth=azimuths[-1], size=(64, 48), samples=256)
    of_kept = np.sqrt(np.mean((kept.radiance - rest.radiance) ** 2))
    of_coarse = np.sqrt(np.mean((np.kron(coarse.radiance, np.ones((4, 4, 1))) - rest.radiance) ** 2))
    assert of_kept < 0.7 * of_coarse, f"{of_kept} with kept light, {of_coarse} without"
    # Where rays meet nothing there is no depth, as in any image.
    seen = (kept.alpha > 0.9) & (rest.alpha > 0.9)
    assert seen.any() and np.median(np.abs(kept.depth[seen] - rest.depth[seen])) < 2.0
    assert np.isinf(kept.depth[kept.alpha == 0.0]).all()


def test_no_image_at_rest_is_noisier_than_what_was_shown_before(head: lumivox.Volume) -> None:
    came: list[lumivox.Image] = []
    view = live.Live(head, (32, 24), 32, came.append, lambda error: pytest.fail(str(error)), preset="ct-bone")
    try:
        view.update(live.Settings(azimuth=20.0))
        wait(lambda: bool(came) and came[-1].complete)
    finally:
        view.end()
    assert [one.min_samples for one in came] == [1, 16, 32]


def test_kept_light_is_on_or_off(head: lumivox.Volume) -> None:
    with pytest.raises(TypeError, match="kept_light"):
        widget.View(head, kept_light="yes")  # type: ignore[arg-type]


Sent = list[tuple[dict[str, Any], list[Any]]]


def of_kind(sent: Sent, kind: str) -> Sent:
    return [message for message in sent if message[0]["kind"] == kind]


def in_page(scan: lumivox.Volume, monkeypatch: pytest.MonkeyPatch, folder: Path, **options: Any) -> tuple[widget.View, Sent]:
    """A view of a lumivox with a program for browsers, and what it sends pages."""
    for name in browser.PROGRAM:
        (folder / name).write_text(name)
    monkeypatch.setattr(browser, "FOLDER", folder)
    view = widget.View(scan, size=(32, 24), samples=4, preset="ct-bone", azimuth=20.0, **options)
    sent: Sent = []
    monkeypatch.setattr(view, "send", lambda content, buffers=(): sent.append((content, list(buffers))))
    return view, sent


def test_a_page_that_renders_is_sent_program_voxels_and_scene(
    head_folder: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    folder = tmp_path / "web"
    folder.mkdir()
    head = lumivox.load(head_folder)
    view, sent = in_page(head, monkeypatch, folder, exposure=0.5, background="transparent")
    try:
        assert view.page_renders == "card" and sent == []
        view._handle_custom_msg({"kind": "begin"}, [])
        wait(lambda: of_kind(sent, "scene") != [])
        assert [content["kind"] for content, _ in sent] == ["program", "scans", "scene"]
        assert sent[0][1] == [name.encode() for name in browser.PROGRAM]
        (told,) = sent[1][0]["scans"]
        dims = told["description"]["dims"]
        voxels = np.frombuffer(sent[1][1][0], told["kind"]).reshape(dims[::-1])
        shown = lumivox.Scene.of(head, preset="ct-bone").volumes[0].volume
        assert np.array_equal(voxels, shown.array)
        assert np.allclose(told["description"]["patientFromVoxel"], shown.patient_from_voxel[:3])
        document = json.loads(sent[2][0]["document"])
        assert document["camera"] == {"azimuth": 20.0, "elevation": 0.0, "zoom": 1.0, "fov": 28.0}
        assert document["display"]["exposure"] == 0.5 and document["display"]["background"] == "#14171c"
        # A page turns by itself; another opacity is another scene, of the same voxels.
        view.azimuth = 40.0
        view.knots = [*view.knots[:-1], [view.knots[-1][0], 0.5, "linear"]]
        wait(lambda: len(of_kind(sent, "scene")) == 2)
        assert len(of_kind(sent, "scans")) == 1
        looks = [json.loads(content["document"])["volumes"][0]["look"] for content, _ in of_kind(sent, "scene")]
        assert looks[0]["transfer_function"] != looks[1]["transfer_function"]
        # What it shows comes back, is rendered here when it is asked for, and can be saved.
        view._handle_custom_msg({"kind": "picture", "samples": 4}, [memoryview(b"a picture")])
        assert (view.png, view.samples) == (b"a picture", 4)
        image = view.image
        assert image is not None and image.size == (32, 24) and image.min_samples == 4
        view.save_scene(tmp_path / "scene.lumivox")
        saved = lumivox.load_scene(tmp_path / "scene.lumivox")
        assert np.allclose(saved.camera.world_from_camera, image.camera.world_from_camera)
        assert saved.display.exposure == 0.5 and (saved.size, saved.samples) == ((32, 24), 4)
        # Another page begins with nothing; one that cannot render is shown the kernel's pictures.
        view._handle_custom_msg({"kind": "begin"}, [])
        wait(lambda: len(of_kind(sent, "scans")) == 2)
        view._handle_custom_msg({"kind": "pictures"}, [])
        wait(rests(view, 40.0))
        wait(lambda: view.png.startswith(b"\x89PNG"))
    finally:
        view.close()


def test_labels_are_sent_with_their_voxels(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    scan = lumivox.Volume.from_array(np.arange(480, dtype=np.uint16).reshape(4, 10, 12), modality="MR")
    array = (scan.array > 100).astype(np.uint8) * 3
    labels = lumivox.Labels.from_array(array, like=scan, names={3: "bright"})
    view, sent = in_page(scan, monkeypatch, tmp_path, labels=labels, label={"bright": lumivox.LabelStyle(opacity=0.5)})
    try:
        view._handle_custom_msg({"kind": "begin"}, [])
        wait(lambda: of_kind(sent, "scene") != [])
        ((content, buffers),) = of_kind(sent, "scans")
        assert [label["name"] for label in content["scans"][0]["labels"]] == ["bright"]
        assert np.array_equal(np.frombuffer(buffers[1], np.uint8).reshape(4, 10, 12), array)
        document = json.loads(of_kind(sent, "scene")[0][0]["document"])
        assert document["volumes"][0]["labels"]["styles"][0]["label"] == "bright"
    finally:
        view.close()


def test_what_a_page_cannot_show_the_kernel_does(head: lumivox.Volume, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    view, _ = in_page(head, monkeypatch, tmp_path, in_browser=False)
    view.close()
    assert view.page_renders == "never"
    view, _ = in_page(head, monkeypatch, tmp_path, in_browser=True)
    view.close()
    assert view.page_renders == "always"
    view, _ = in_page(head, monkeypatch, tmp_path, peel_mm=4.0)
    view.close()
    assert view.page_renders == "never"
    with pytest.raises(ValueError, match=r"^in_browser: a browser cannot show this: it is peeled$"):
        widget.View(head, size=(32, 24), samples=4, peel_mm=4.0, in_browser=True)
    with pytest.raises(TypeError, match="in_browser"):
        widget.View(head, size=(32, 24), in_browser="yes")  # type: ignore[arg-type]
    monkeypatch.setattr(browser, "FOLDER", tmp_path / "nowhere")
    with pytest.raises(ValueError, match=r"^in_browser: this lumivox was made without the program for browsers$"):
        widget.View(head, size=(32, 24), samples=4, in_browser=True)
    monkeypatch.setattr(browser, "MOST_SENT", 1000)
    assert browser.obstacle(lumivox.Scene.of(head)) == "it is large"
