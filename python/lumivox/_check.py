"""What arguments have to be: errors name the argument, say what it must be, and show what it was."""

from __future__ import annotations

import math
import numbers
import os
import re
import sys
import warnings
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

Rgb = tuple[float, float, float]
PathLike = str | os.PathLike[str]
Vector = Sequence[float] | npt.NDArray[Any]
"""Numbers along axes, such as x, y and z: a tuple, a list or an array."""
Matrix = Sequence[Sequence[float]] | npt.NDArray[Any]
"""Rows of numbers."""

FURTHEST_MM = 1e6
"""Further from a scan is nothing: 1 km."""


def shown(value: object) -> str:
    """A value as an error shows it: short."""
    if isinstance(value, np.ndarray) and (value.size > 12 or value.ndim > 1):
        return f"an array of shape {value.shape}"
    text = repr(value)
    return text if len(text) <= 80 else f"{text[:70]}... ({type(value).__name__})"


def listed(words: Iterable[str], last: str = "or") -> str:
    """``'a', 'b' or 'c'``."""
    *most, end = (f"'{word}'" for word in words)
    return f"{', '.join(most)} {last} {end}" if most else end


def is_number(value: object) -> bool:
    """Whether it is a real number; ``True`` is none, nor is an array."""
    return isinstance(value, numbers.Real) and not isinstance(value, bool | np.bool_)


def number(name: str, value: Any, low: float = -math.inf, high: float = math.inf) -> float:
    """A finite number within a range."""
    extent = f"{low:.10g} to {high:.10g}" if math.isfinite(low) and math.isfinite(high) else "a finite number"
    if not is_number(value):
        raise TypeError(f"{name} must be a number{f', {extent}' if extent[0] != 'a' else ''}, not {shown(value)}")
    made = float(value)
    if not (low <= made <= high and math.isfinite(made)):
        raise ValueError(f"{name} must be {extent}, not {shown(value)}")
    return made


def whole(name: str, value: Any, low: int, high: int) -> int:
    """A whole number within a range; ``1e4`` is one, too."""
    if not is_number(value):
        raise TypeError(f"{name} must be a whole number, {low} to {high}, not {shown(value)}")
    if not (math.isfinite(value) and low <= value <= high):
        raise ValueError(f"{name} must be {low} to {high}, not {shown(value)}")
    if value != int(value):
        raise ValueError(f"{name} must be a whole number, {low} to {high}, not {shown(value)}")
    return int(value)


def choice(name: str, value: Any, words: Sequence[str]) -> Any:
    """One of some words."""
    if not isinstance(value, str) or value not in words:
        raise (ValueError if isinstance(value, str) else TypeError)(f"{name} {shown(value)} is not {listed(words)}")
    return value


def vector(name: str, value: Any, what: str = "three numbers, x, y and z", most: float = math.inf) -> tuple[float, float, float]:
    """Three finite numbers."""
    try:
        made = tuple(value)
    except TypeError:
        made = ()
    if isinstance(value, str) or len(made) != 3 or not all(is_number(part) for part in made):
        raise TypeError(f"{name} must be {what}, not {shown(value)}")
    x, y, z = (float(part) for part in made)
    if not all(math.isfinite(part) for part in (x, y, z)):
        raise ValueError(f"{name} must be {what}, and finite, not {shown(value)}")
    if max(abs(x), abs(y), abs(z)) > most:
        raise ValueError(f"{name} must be within 1 km ({FURTHEST_MM:.0f} mm) of the scan, not {shown(value)}")
    return x, y, z


def color(name: str, value: Any) -> Rgb:
    """A colour in linear RGB, of three numbers from 0 to 1, or of ``"#rrggbb"``, which is sRGB."""
    if isinstance(value, str):
        if not re.fullmatch("#[0-9a-fA-F]{6}", value):
            raise ValueError(f"{name} {value!r} is no colour; write it as '#c04030', or as linear red, green and blue")
        r, g, b = (_linear(int(value[i : i + 2], 16) / 255.0) for i in (1, 3, 5))
        return r, g, b
    r, g, b = vector(name, value, "a colour: '#rrggbb', or linear red, green and blue")
    if not all(0.0 <= part <= 1.0 for part in (r, g, b)):
        raise ValueError(f"{name} must be a colour with parts of 0 to 1, not {shown(value)}")
    return r, g, b


def _linear(code: float) -> float:
    linear: float = code / 12.92 if code <= 0.04045 else ((code + 0.055) / 1.055) ** 2.4
    return linear


def light(name: str, value: Any) -> Rgb:
    """Red, green and blue of light, which may be any amount."""
    r, g, b = vector(name, value, "three numbers, red, green and blue")
    if min(r, g, b) < 0.0:
        raise ValueError(f"{name} must not be below 0, as {shown(value)} is")
    return r, g, b


def file(name: str, value: Any) -> str:
    """The name of a file or folder."""
    if isinstance(value, bytes) or not isinstance(value, str | os.PathLike):
        raise TypeError(f"{name} must be the name of a file or folder, not {shown(value)}")
    made = os.fspath(value)
    if not made:
        raise ValueError(f"{name} is empty; name a file or folder")
    return made


def writable(name: str) -> str:
    """The folder of a file that can be written there."""
    folder = os.path.dirname(os.path.abspath(name))
    if not os.path.isdir(folder):
        raise FileNotFoundError(f"{name} cannot be written: there is no folder {folder}")
    if os.path.isdir(name):
        raise IsADirectoryError(f"{name} cannot be written: it is a folder; name a file in it")
    return folder


Grid = tuple[str | None, str | None, str | None, str | None]
"""Layout of a RAW scan, spacing, axes, and layout of an array, as the command has them."""


def grid(raw: Any, spacing: Any, axes: Any, layout: Any) -> Grid:
    """What is told of files that do not say what they are a grid of, if it is text and numbers."""
    for name, value, example in (
        ("raw", raw, "256x256x108:i16le:spacing=0.9,0.9,1.5"),
        ("axes", axes, "LPS"),
        ("layout", layout, "zyx"),
    ):
        if value is not None and not isinstance(value, str):
            what = "a layout" if name != "axes" else "three letters"
            raise TypeError(f"{name} must be {what}, such as '{example}', not {shown(value)}")
    lengths = None
    if spacing is not None:
        lengths = ",".join(map(repr, vector("spacing", spacing, "three lengths in mm, along x, y and z")))
    return raw, lengths, axes, layout


def modality(value: Any) -> str:
    """A word for what made a scan; which it may be, the native half knows."""
    if not isinstance(value, str):
        raise TypeError(f"modality must be 'CT', 'MR', 'PET' or 'other', not {shown(value)}")
    return value


def flag(name: str, value: Any) -> bool:
    """``True`` or ``False``."""
    if not isinstance(value, bool | np.bool_):
        raise TypeError(f"{name} must be True or False, not {shown(value)}")
    return bool(value)


def called(name: str, value: Any, given: str) -> Any:
    """A function, or nothing."""
    if value is not None and not callable(value):
        raise TypeError(f"{name} must be a function that is given {given}, not {shown(value)}")
    return value


def rows(name: str, value: Any) -> tuple[tuple[float, ...], ...]:
    """A transform as 3 rows of 4; 4 x 4 does, too."""
    try:
        matrix = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError):
        raise TypeError(f"{name} must be a transform of 3 x 4 numbers, not {shown(value)}") from None
    if matrix.shape not in ((3, 4), (4, 4)):
        raise ValueError(f"{name} must be a transform of 3 x 4 numbers, not {shown(value)}")
    if not np.isfinite(matrix).all():
        raise ValueError(f"{name} must be a transform of finite numbers")
    if np.linalg.det(matrix[:3, :3]) == 0.0:
        raise ValueError(f"{name} must be a transform that can be undone: this one flattens")
    return tuple(tuple(row) for row in matrix[:3].tolist())


def pose(name: str, value: Any) -> tuple[tuple[float, ...], ...]:
    """A rotation and a place in mm, as 3 rows of 4; 4 x 4 does, too."""
    made = rows(name, value)
    turned = np.array(made)[:, :3]
    if not np.allclose(turned.T @ turned, np.eye(3), atol=1e-4) or np.linalg.det(turned) < 0.0:
        said = "its columns have lengths other than 1, or are no right angles to each other, or mirror"
        raise ValueError(f"{name} must be a rotation and a place in mm: {said}")
    return made


def place(spacing: Any, origin: Any, orientation: Any) -> npt.NDArray[np.float64]:
    """3 x 4: LPS millimetres from voxel indices x, y, z."""
    millimetres = np.asarray(spacing, dtype=np.float64) if _is_numbers(spacing) else np.empty(0)
    if millimetres.shape != (3,) or not np.all(np.isfinite(millimetres) & (millimetres > 0.0)):
        raise ValueError(f"spacing must be three numbers above 0, not {shown(spacing)}; orientation mirrors")
    at = np.asarray(origin, dtype=np.float64) if _is_numbers(origin) else np.empty(0)
    if at.shape != (3,) or not np.all(np.isfinite(at)):
        raise ValueError(f"origin must be three finite numbers, not {shown(origin)}")
    direction = np.eye(3)
    if orientation is not None:
        direction = np.asarray(orientation, dtype=np.float64) if _is_numbers(orientation) else np.empty(0)
        if direction.size != 9 or direction.shape not in ((3, 3), (9,)):
            raise ValueError(f"orientation must be 3 x 3 numbers, columns of directions, not {shown(orientation)}")
        direction = direction.reshape(3, 3)
    return np.column_stack([direction * millimetres, at])


def _is_numbers(value: Any) -> bool:
    try:
        return np.asarray(value).dtype.kind in "iuf"
    except ValueError:
        return False


def warn(note: str) -> None:
    """Says what is worth knowing, at the line that asked."""
    frame, level = sys._getframe(1), 2
    while frame.f_back is not None and frame.f_globals.get("__name__", "").partition(".")[0] == "lumivox":
        frame, level = frame.f_back, level + 1
    warnings.warn(note, stacklevel=level)
