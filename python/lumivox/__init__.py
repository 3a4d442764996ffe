"""Cinematic volume path tracing of CT and MR scans.

    import lumivox

    scan = lumivox.load("FOLDER")
    image = lumivox.render(scan, preset="ct-bone", azimuth=35)
    image.save("bone.png")

Names, defaults and words are those of the command `lumivox`. Lengths are millimetres and angles degrees, unless a name says
otherwise. Arrays of voxels have the axes z, y, x, those of images rows (from the top) and columns. Patient space is DICOM's
LPS: x to the patient's left, y to the back, z to the head. Scene space has x to the patient's left, y to the head and z to
the viewer, from the first scan's centre.
"""

import importlib as _importlib
from typing import Any as _Any

from lumivox import _codecs as _codecs_module
from lumivox import labels as _labels_module
from lumivox._native import GpuError, LumivoxError, RenderError, ScanError, __version__
from lumivox.classification import ClipShape, LabelStyle, Peel
from lumivox.errors import FileError, MissingFileError
from lumivox.image import Image
from lumivox.labels import Label, Labels, load_labels
from lumivox.light import DirectionalLight, Environment, EnvironmentMap, PointLight, SpotLight, Sun
from lumivox.look import (
    ColorStop,
    GradientFunction,
    Medium,
    OpacityKnot,
    Preset,
    SurfaceReflection,
    TransferFunction,
    load_transfer_function,
    presets,
)
from lumivox.rendering import Gpu, Progress, Renderer, gpus, progressive, render
from lumivox.scene import Camera, Scene, VolumeInstance
from lumivox.scene_files import SavedScene, load_scene
from lumivox.volume import Volume, load, phantom, scan, write_dicom_series

_codecs_module.install()
# Each knows the other: for those who ask what types a signature has.
_labels_module.Volume = Volume  # type: ignore[attr-defined]


def __getattr__(name: str) -> _Any:
    """Modules that need more than numpy, when they are asked for: ``lumivox.cluster`` without an import of its own."""
    if name in ("cluster", "interop", "napari", "widget"):
        return _importlib.import_module(f"lumivox.{name}")
    raise AttributeError(f"module 'lumivox' has no attribute '{name}'")


__all__ = [
    "Camera",
    "ClipShape",
    "ColorStop",
    "DirectionalLight",
    "Environment",
    "EnvironmentMap",
    "FileError",
    "Gpu",
    "GpuError",
    "GradientFunction",
    "Image",
    "Label",
    "LabelStyle",
    "Labels",
    "LumivoxError",
    "Medium",
    "MissingFileError",
    "OpacityKnot",
    "Peel",
    "PointLight",
    "Preset",
    "Progress",
    "RenderError",
    "Renderer",
    "SavedScene",
    "ScanError",
    "Scene",
    "SpotLight",
    "Sun",
    "SurfaceReflection",
    "TransferFunction",
    "Volume",
    "VolumeInstance",
    "__version__",
    "gpus",
    "load",
    "load_labels",
    "load_scene",
    "load_transfer_function",
    "phantom",
    "presets",
    "progressive",
    "render",
    "scan",
    "write_dicom_series",
]
