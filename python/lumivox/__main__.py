"""``python -m lumivox doctor``: what this machine has for rendering, and what it lacks."""

from __future__ import annotations

import ctypes.util
import os
import platform
import sys
from pathlib import Path

import numpy as np

import lumivox

INSTALL = (
    "Install Vulkan drivers; they include one that runs on the CPU: sudo apt-get install libvulkan1 mesa-vulkan-drivers (Debian, "
    "Ubuntu), vulkan-loader mesa-vulkan-drivers (Fedora), vulkan-icd-loader vulkan-swrast (Arch)"
)
NVIDIA = (
    "There is an NVIDIA GPU, but its Vulkan driver does not answer: install the graphics part of NVIDIA's driver (Debian: "
    "nvidia-vulkan-icd); in a container, allow NVIDIA_DRIVER_CAPABILITIES=graphics"
)
WINDOWS = "Install the graphics driver of the GPU's maker: Vulkan or Direct3D 12 is needed. A remote desktop may hide the GPU"


def remedy() -> str:
    """What to do where nothing can render."""
    named = [name for name in ("VK_DRIVER_FILES", "VK_ICD_FILENAMES") if os.environ.get(name)]
    if named and ctypes.util.find_library("vulkan"):
        return f"{named[0]} is set, so that only the drivers it names are used: unset it"
    if sys.platform == "win32":
        return WINDOWS
    return NVIDIA if Path("/dev/nvidia0").exists() else INSTALL


def doctor() -> int:
    """Prints what is seen; 1 where nothing can render."""
    print(f"Lumivox {lumivox.__version__}, Python {platform.python_version()}, numpy {np.__version__}, {platform.platform()}")
    devices = lumivox.gpus()
    for gpu in devices:
        kind = "software" if gpu.software else "GPU"
        print(f"{gpu.index}: {gpu.name} ({gpu.api}, {gpu.driver}, {kind}){f': {gpu.unsuitable}' if gpu.unsuitable else ''}")
    if any(gpu.unsuitable is None for gpu in devices):
        return 0
    print(f"no GPU can be used. {remedy()}.", file=sys.stderr)
    return 1


if __name__ == "__main__":
    if sys.argv[1:] != ["doctor"]:
        sys.exit("python -m lumivox doctor: what this machine has for rendering, and what it lacks")
    sys.exit(doctor())
