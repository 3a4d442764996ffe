"""The renderer in a page: what the notebook's widget sends to a browser that has WebGPU, in place of pictures.

Wheels carry the npm package ``lumivox`` in the folder ``web``. With one that was made without it, a page shows what the kernel
renders.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from lumivox import _document
from lumivox.image import Display
from lumivox.light import EnvironmentMap
from lumivox.scene import Scene, VolumeInstance

FOLDER = Path(__file__).with_name("web")

PROGRAM = ("lumivox_wasm.js", "lumivox.js", "lumivox_wasm_bg.wasm")
"""The npm package's files that a page needs, in the order in which they are sent."""

MOST_SENT = 1 << 28
"""Bytes of voxels that are sent to a page at most."""

BEHIND = Display().background
"""What stands behind where a picture is to have none: a page's canvas is opaque."""


def has_program() -> bool:
    """Whether there is a program for pages."""
    return all((FOLDER / name).is_file() for name in PROGRAM)


def program() -> list[bytes]:
    """Its files."""
    return [(FOLDER / name).read_bytes() for name in PROGRAM]


def obstacle(scene: Scene) -> str | None:
    """Why a page cannot show a scene; ``None`` where it can."""
    if isinstance(scene.environment.source, EnvironmentMap):
        return "its light is a panorama"
    for one in scene.volumes:
        if one.peel is not None:
            return "it is peeled"
        labels = one.labels
        if labels is not None and not (
            labels.shape == one.volume.shape and np.allclose(labels.patient_from_voxel, one.volume.patient_from_voxel)
        ):
            return "its labels have voxels of their own"
    if sum(one.volume.array.nbytes for one in scene.volumes) > MOST_SENT:
        return "it is large"
    return None


def parts(scene: Scene) -> tuple[list[dict[str, Any]], list[memoryview]]:
    """What a page makes scans of: what is said of each, and the bytes of voxels, and of labels where it has some."""
    told, sent = [], []
    for one in scene.volumes:
        told.append(_told(one))
        sent.append(_bytes(one.volume.array))
        if one.labels is not None:
            sent.append(_bytes(one.labels.array))
    return told, sent


def _bytes(array: npt.NDArray[Any]) -> memoryview:
    return np.ascontiguousarray(array).data.cast("B")


def _told(one: VolumeInstance) -> dict[str, Any]:
    volume = one.volume
    words: dict[str, Any] = {
        "kind": volume.array.dtype.name,
        "description": {
            "dims": list(volume.shape[::-1]),
            "patientFromVoxel": volume.patient_from_voxel[:3].tolist(),
            "slope": volume.slope,
            "intercept": volume.intercept,
            "modality": volume.modality or "other",
            "unit": volume.unit,
        },
    }
    if one.labels is not None:
        words["labels"] = [{"value": label.value, "name": label.name, "color": list(label.color)} for label in one.labels.labels]
    return words


def document(scene: Scene, display: Display, seed: int, camera: Mapping[str, float | None]) -> str:
    """The scene document that a page shows."""
    words = {name: getattr(display, name) for name in ("exposure", "tone", "gamma")}
    behind = BEHIND if display.background == "transparent" else display.background
    whole = {
        **_document.of_scene(scene),
        "camera": camera,
        "display": {**words, "background": behind},
        "film": {"seed": seed},
    }
    return _document.text(whole)
