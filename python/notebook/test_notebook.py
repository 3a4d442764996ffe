"""The widget in a real notebook: JupyterLab in Chromium, with a mouse. `script/python --notebook` runs it."""

from __future__ import annotations

import base64
import json
import os
import re
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from playwright.sync_api import Locator, Page, Playwright, expect, sync_playwright

CELL = """import lumivox
from lumivox import widget
view = widget.View(lumivox.phantom("head", 48), size=(320, 320), samples=4, preset="ct-bone", azimuth=30)
view"""

IN_BROWSER = """import lumivox
from lumivox import widget
view = widget.View(lumivox.phantom("head", 32), size=(160, 160), samples=16, preset="ct-bone", azimuth=30, in_browser=True)
view"""

SOFTWARE_GPU = [
    "--enable-unsafe-webgpu",
    "--ignore-gpu-blocklist",
    "--use-vulkan=swiftshader",
    "--enable-features=Vulkan",
    "--use-angle=vulkan",
    "--enable-unsafe-swiftshader",
]
"""Has Chromium give pages a GPU that is the processor."""

WAIT = 120_000
"""Milliseconds: software Vulkan compiles kernels on first use."""


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """JupyterLab over a folder with notebooks: its address."""
    folder = tmp_path_factory.mktemp("lab")
    kernel = {"name": "python3", "display_name": "Python 3", "language": "python"}
    for name, source in (("view", CELL), ("page", IN_BROWSER)):
        cell = {"cell_type": "code", "id": "view", "metadata": {}, "execution_count": None, "outputs": [], "source": source}
        notebook = {"cells": [cell], "metadata": {"kernelspec": kernel}, "nbformat": 4, "nbformat_minor": 5}
        (folder / f"{name}.ipynb").write_text(json.dumps(notebook))
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    own = {f"JUPYTER_{what}_DIR": str(folder / what.lower()) for what in ("CONFIG", "DATA", "RUNTIME")}
    path = os.pathsep.join([os.path.dirname(sys.executable), os.environ["PATH"]])
    options = [
        "--no-browser",
        "--allow-root",
        "--ip=127.0.0.1",
        f"--port={port}",
        "--IdentityProvider.token=",
        f"--notebook-dir={folder}",
    ]
    with (folder / "server.log").open("w") as log:
        process = subprocess.Popen(
            [sys.executable, "-m", "jupyterlab", *options],
            env={**os.environ, **own, "PATH": path},
            stdout=log,
            stderr=subprocess.STDOUT,
        )
    try:
        for _ in range(600):
            with socket.socket() as knock:
                knock.settimeout(0.1)
                if knock.connect_ex(("127.0.0.1", port)) == 0:
                    break
            assert process.poll() is None, (folder / "server.log").read_text()
            time.sleep(0.1)
        yield f"http://127.0.0.1:{port}/lab/tree"
    finally:
        process.terminate()
        process.wait()


@pytest.fixture(scope="module")
def play() -> Iterator[Playwright]:
    with sync_playwright() as play:
        yield play


@pytest.fixture(scope="module")
def page(play: Playwright, server: str) -> Iterator[Page]:
    """The notebook, its cell run."""
    with opened(play, f"{server}/view.ipynb") as page:
        yield page


@contextmanager
def opened(play: Playwright, address: str, *options: str) -> Iterator[Page]:
    """A notebook in Chromium, its cell run."""
    # As root, a browser has no sandbox; what it shows is our own.
    browser = play.chromium.launch(executable_path=os.environ["LUMIVOX_BROWSER"], args=["--no-sandbox", *options])
    page = browser.new_page(viewport={"width": 900, "height": 820})
    page.set_default_timeout(WAIT)
    said: list[str] = []
    page.on("pageerror", lambda error: said.append(str(error)))
    page.goto(address)
    # Sooner, a cell would be run by nobody.
    expect(page.get_by_text(re.compile(r"\| Idle$"))).to_be_visible(timeout=WAIT)
    page.locator(".jp-Notebook .cm-content").first.click()
    page.keyboard.press("Shift+Enter")
    yield page
    assert said == [], "the page raised nothing"
    browser.close()


def rests(page: Page, unlike: bytes = b"") -> bytes:
    """The picture once it has all its samples and is another than before."""
    deadline = time.monotonic() + WAIT / 1e3
    while True:
        expect(output(page).get_by_text("4 of 4 samples")).to_be_visible(timeout=WAIT)
        found = picture(page)
        if found != unlike and output(page).get_by_text("4 of 4 samples").is_visible():
            return found
        assert time.monotonic() < deadline, "it shows what it showed"
        page.wait_for_timeout(100)


def output(page: Page) -> Locator:
    return page.locator(".jp-OutputArea-output").first


def picture(page: Page) -> bytes:
    return output(page).locator("img").screenshot()


def kept(page: Page, name: str) -> None:
    """A screenshot for people, where one is asked for."""
    if wanted := os.environ.get("LUMIVOX_SCREENSHOTS"):
        page.screenshot(path=Path(wanted) / f"{name}.png")


def asked(page: Page, expression: str) -> str:
    """What the kernel says of an expression, in a cell below."""
    page.locator(".jp-Notebook .cm-content").last.click()
    page.keyboard.press("Control+A")
    page.keyboard.type(f"print('said', {expression})")
    page.keyboard.press("Control+Enter")
    found = page.locator(".jp-OutputArea-output pre", has_text=re.compile("^said")).last
    expect(found).to_be_visible(timeout=WAIT)
    return (found.text_content() or "").removeprefix("said").strip()


def test_a_view_is_turned_zoomed_and_put_back(page: Page) -> None:
    first = rests(page)
    kept(page, "notebook")
    box = output(page).locator("img").bounding_box()
    assert box is not None and box["width"] == box["height"] == 320
    x, y = box["x"] + 160, box["y"] + 160
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x - 80, y + 16, steps=8)
    page.mouse.up()
    turned = rests(page, first)
    page.mouse.wheel(0, -240)
    closer = rests(page, turned)
    output(page).locator("img").press("ArrowUp")
    rests(page, closer)
    # 320 pixels are half a turn; the wheel is e to the 240 / 600.
    assert asked(page, "round(view.azimuth, 1), round(view.elevation, 1), round(view.zoom, 2)") == "75.0 4.0 1.49"
    output(page).locator("img").dblclick()
    deadline = time.monotonic() + WAIT / 1e3
    while rests(page) != first:
        assert time.monotonic() < deadline, "it is not back where it was, to the pixel"


def test_presets_and_opacity_are_edited(page: Page) -> None:
    before = rests(page)
    output(page).get_by_label("Preset").select_option("ct-skin")
    skin = rests(page, before)
    assert asked(page, "view.preset") == "ct-skin"
    curve = output(page).get_by_label("Opacity by value")
    knots = int(asked(page, "len(view.knots)"))
    box = curve.bounding_box()
    assert box is not None
    # Nothing is near the upper left corner: a knot comes there, is dragged down and to the right, and taken away again.
    page.mouse.dblclick(box["x"] + 20, box["y"] + 12)
    page.mouse.move(box["x"] + 20, box["y"] + 12)
    page.mouse.down()
    page.mouse.move(box["x"] + 40, box["y"] + 45, steps=4)
    page.mouse.up()
    expect(output(page).get_by_text(re.compile(r"^-\d+ HU: 0\.5\d$"))).to_be_visible()
    assert curve.bounding_box() == box, "what is said moves nothing below the pointer"
    kept(page, "notebook-curve")
    page.mouse.move(5, 5)
    hazy = rests(page, skin)
    assert int(asked(page, "len(view.knots)")) == knots + 1
    low, high = (float(value) for value in asked(page, "*view.value_range").split())
    value, opacity = (float(part) for part in asked(page, "*view.knots[0][:2]").split())
    assert abs(value - (low + (high - low) * 40 / 320)) < (high - low) / 320 and abs(opacity - 0.5) < 0.02
    box = curve.bounding_box()
    assert box is not None
    page.mouse.dblclick(box["x"] + 40, box["y"] + 45)
    page.mouse.move(5, 5)
    rests(page, hazy)
    assert int(asked(page, "len(view.knots)")) == knots


def test_what_goes_wrong_is_said(page: Page) -> None:
    assert asked(page, "view.set_trait('knots', []), view.message").endswith("needs at least one opacity knot")
    expect(output(page).get_by_role("alert")).to_have_text("a transfer function needs at least one opacity knot")
    asked(page, "view.set_trait('preset', 'ct-bone')")
    rests(page)
    expect(output(page).get_by_role("alert")).to_be_hidden()


MEANS = """async ([address]) => {
    const picture = await createImageBitmap(await (await fetch(address)).blob());
    const canvas = new OffscreenCanvas(8, 8);
    const pen = canvas.getContext("2d");
    pen.imageSmoothingQuality = "high";
    pen.drawImage(picture, 0, 0, 8, 8);
    return [...pen.getImageData(0, 0, 8, 8).data];
}"""
"""Means of 8 x 8 parts of a picture."""


def means(page: Page, png: bytes) -> list[int]:
    found: list[int] = page.evaluate(MEANS, [f"data:image/png;base64,{base64.b64encode(png).decode()}"])
    return found


def rests_unlike(page: Page, canvas: Locator, before: bytes) -> None:
    """Waits until a page has rendered another picture."""
    deadline = time.monotonic() + WAIT / 1e3
    while canvas.screenshot() == before or not output(page).get_by_text("16 of 16 samples").is_visible():
        assert time.monotonic() < deadline, "it shows what it showed"
        page.wait_for_timeout(100)


def test_a_browser_with_a_gpu_renders_itself(play: Playwright, server: str) -> None:
    # The other notebook is open in the workspace that is left.
    with opened(play, f"{server}/page.ipynb?reset", *SOFTWARE_GPU) as page:
        canvas = output(page).locator("canvas").first
        expect(canvas).to_be_visible(timeout=WAIT)
        # What it shows comes back to the kernel, which renders nothing.
        expect(output(page).get_by_text("16 of 16 samples")).to_be_visible(timeout=WAIT)
        assert asked(page, "view._live.renders, view.page_renders") == "False always"
        kept(page, "notebook-in-browser")
        first = canvas.screenshot()
        own = base64.b64decode(asked(page, "__import__('base64').b64encode(view.image._repr_png_()).decode()"))
        apart = [abs(a - b) for a, b in zip(means(page, first), means(page, own), strict=True)]
        assert max(means(page, first)) > 100 and max(apart) < 24, f"{apart}"
        box = canvas.bounding_box()
        assert box is not None
        x, y = box["x"] + 80, box["y"] + 80
        page.mouse.move(x, y)
        page.mouse.down()
        page.mouse.move(x - 40, y, steps=4)
        page.mouse.up()
        rests_unlike(page, canvas, first)
        assert asked(page, "round(view.azimuth, 1)") == "75.0"
        turned = canvas.screenshot()
        output(page).get_by_label("Preset").select_option("ct-skin")
        rests_unlike(page, canvas, turned)
        kept(page, "notebook-in-browser-skin")
        expect(output(page).get_by_role("alert")).to_be_hidden()
