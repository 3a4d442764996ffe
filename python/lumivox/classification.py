"""What a point of a scan is besides its value: which label it has, whether it is cut away, how deep below the skin it lies."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any, Literal

from lumivox import _check, _native, look
from lumivox._check import FURTHEST_MM, Matrix, Vector
from lumivox.labels import Labels
from lumivox.look import SurfaceReflection, TransferFunction
from lumivox.volume import Volume

MOST_CLIP_SHAPES = 1024

MOST_PEELED_MM = 63.0


@dataclass(frozen=True)
class LabelStyle:
    """How the voxels of a label look; what is ``None`` is as the medium says."""

    visible: bool = True
    """Whether they are there at all."""
    color: Vector | str | None = None
    """Their colour in place of the transfer function's: linear RGB, ``"#rrggbb"`` (sRGB), or ``"own"``, the label's."""
    opacity: float = 1.0
    """Multiplies their opacity, 0 to 1."""
    density: float | None = None
    """Factor on their extinction, 0 to 1e9, in place of the medium's."""
    transfer_function: TransferFunction | None = None
    """Their transfer function, without gradients."""
    surface: SurfaceReflection | None = None
    """Their reflection at surfaces."""
    clipped: bool = True
    """Whether clip shapes cut them."""

    def __post_init__(self) -> None:
        _check.flag("visible", self.visible)
        _check.flag("clipped", self.clipped)
        if self.color is not None and not (isinstance(self.color, str) and self.color == "own"):
            object.__setattr__(self, "color", _check.color("color", self.color))
        object.__setattr__(self, "opacity", _check.number("opacity", self.opacity, 0.0, 1.0))
        if self.density is not None:
            object.__setattr__(self, "density", _check.number("density", self.density, 0.0, 1e9))
        curve = self.transfer_function
        if curve is not None:
            if not isinstance(curve, TransferFunction):
                made_by = "lumivox.load_transfer_function(path) reads one"
                raise TypeError(f"transfer_function must be a lumivox.TransferFunction, not {_check.shown(curve)}; {made_by}")
            if curve.gradients:
                raise ValueError("a label's transfer function has no gradients; leave them out")
        if self.surface is not None and not isinstance(self.surface, SurfaceReflection):
            raise TypeError(f"surface must be a lumivox.SurfaceReflection, not {_check.shown(self.surface)}")

    @classmethod
    def of_preset(cls, preset: str, volume: Volume, **style: Any) -> LabelStyle:
        """Transfer function, density and surface of a preset, placed for a volume; ``style`` is what else it has."""
        _, medium = look.preset_medium(preset, volume)
        parts = {"transfer_function": medium.transfer_function, "density": medium.density, "surface": medium.surface}
        return cls(**{**parts, **style})


Style = LabelStyle | str
"""A style, or the command's words for one: ``"hide"``, ``"show"``, ``"color"`` (its own), ``"color:#rrggbb"``,
``"opacity:F"``, ``"density:F"``, ``"preset:NAME"``, ``"matte"``, ``"uncut"`` (by clip shapes); several with commas between."""

Labelled = Mapping[str, Style] | Mapping[int, Style] | Mapping[str | int, Style]
"""Styles of labels by name or number."""


def styles(labels: Labels, volume: Volume, given: Mapping[Any, Style]) -> tuple[tuple[int, LabelStyle], ...]:
    """Styles by value, of styles by name, number or ``"*"`` for all; in turn: words change what was said before of a label."""
    if not isinstance(given, Mapping):
        example = '{"lungs": "hide", "bone": lumivox.LabelStyle(opacity=0.5)}'
        raise TypeError(f"label must be a dict of styles by name, such as {example}, not {_check.shown(given)}")
    own = {label.value: label.color for label in labels.labels}
    made: dict[int, LabelStyle] = {}
    for name, style in given.items():
        for value in labels.values_of(name):
            if isinstance(style, LabelStyle):
                changed = style
            elif isinstance(style, str):
                changed = made.get(value, LabelStyle())
                for word in style.split(","):
                    changed = _with_word(changed, word.strip(), volume)
            else:
                words = "a lumivox.LabelStyle, or words such as 'hide'"
                raise TypeError(f"the style of label {name} must be {words}, not {_check.shown(style)}")
            if isinstance(changed.color, str) and changed.color == "own":
                # What has no label has no colour of its own.
                changed = replace(changed, color=own.get(value))
            made[value] = changed
    return tuple(made.items())


def say_if_unseen(scene: Any, labels: Labels, given: Labelled) -> None:
    """Says of which labels of a Scene's only volume that were asked for by name hardly anything is seen."""
    named = {value for word in given if word != "*" for value in labels.values_of(word)}
    unseen = _native.unseen_labels(scene, sorted(named))
    asked = [label.name for label in labels.labels if label.value in unseen]
    if asked:
        remedy = "give it a look of its own, such as 'preset:NAME' or LabelStyle(transfer_function=...)"
        words = _check.listed(asked, "and")
        _check.warn(f"label {words}: hardly anything is seen of it, for the look makes what it is of clear; {remedy}")


def _with_word(style: LabelStyle, text: str, volume: Volume) -> LabelStyle:
    word, colon, value = text.partition(":")

    def fraction(high: float) -> float:
        try:
            number = float(value)
        except ValueError:
            number = -1.0
        if not 0.0 <= number <= high:
            raise ValueError(f"'{word}' wants a number from 0 to {high:.10g}, as in {word}:0.5")
        return number

    match word, colon:
        case "hide", "":
            return replace(style, visible=False)
        case "show", "":
            return replace(style, visible=True)
        case "matte", "":
            return replace(style, surface=SurfaceReflection())
        case "uncut", "":
            return replace(style, clipped=False)
        case "color", "":
            return replace(style, color="own")
        case "color", _:
            return replace(style, color=_check.color("color", value))
        case "opacity", _:
            return replace(style, opacity=fraction(1.0))
        case "density", _:
            return replace(style, density=fraction(1e9))
        case "preset", ":":
            _, medium = look.preset_medium(value, volume)
            return replace(style, transfer_function=medium.transfer_function, density=medium.density, surface=medium.surface)
    known = "hide, show, color, color:#rrggbb, opacity:F, density:F, preset:NAME, matte, uncut"
    raise ValueError(f"'{text}' is none of {known}")


@dataclass(frozen=True)
class ClipShape:
    """Of a volume, what a shape keeps; of several, what each of them keeps. Cut faces are shaded as surfaces.

    Made by :meth:`plane`, :meth:`box` and :meth:`sphere`. To slide one, render again with another: the scan is on the GPU,
    and stays there.
    """

    kind: Literal["plane", "box", "sphere"]
    """In its own space a plane keeps z > 0, a box -1 to 1 along each axis, a sphere what is within 1 of the origin."""
    from_shape: Matrix
    """3 x 4: millimetres from its own space; it may turn and shear."""
    inverted: bool = False
    """Whether what it would keep is cut away, and the rest kept."""
    space: Literal["scene", "patient"] = "scene"
    """Whose millimetres: the scene's, as a camera's ``eye`` has them, or the patient's (LPS)."""

    def __post_init__(self) -> None:
        _check.choice("clip shape", self.kind, ("plane", "box", "sphere"))
        _check.flag("inverted", self.inverted)
        _check.choice("space", self.space, ("scene", "patient"))
        object.__setattr__(self, "from_shape", _check.rows("from_shape", self.from_shape))
        if not _native.is_solid(self.from_shape):
            raise ValueError(f"the {self.kind} has no inside")

    @classmethod
    def plane(cls, point: Vector, normal: Vector, *, space: Literal["scene", "patient"] = "scene") -> ClipShape:
        """Keeps the side of the plane through ``point`` that ``normal`` points to."""
        at, along = _check.vector("point", point, most=FURTHEST_MM), _check.vector("normal", normal)
        if sum(part * part for part in along) < 1e-24:
            raise ValueError("the plane's normal must not be zero")
        return cls("plane", _native.clip_shape("plane", at, along), space=space)

    @classmethod
    def box(cls, low: Vector, high: Vector, *, space: Literal["scene", "patient"] = "scene") -> ClipShape:
        """Keeps what lies between two corners."""
        a, b = _check.vector("low", low, most=FURTHEST_MM), _check.vector("high", high, most=FURTHEST_MM)
        return cls("box", _native.clip_shape("box", a, b), space=space)

    @classmethod
    def sphere(cls, centre: Vector, radius: float, *, space: Literal["scene", "patient"] = "scene") -> ClipShape:
        """Keeps what lies within ``radius`` of ``centre``."""
        at = _check.vector("centre", centre, most=FURTHEST_MM)
        if _check.is_number(radius) and not radius > 0.0:
            raise ValueError(f"the sphere's radius must be above 0, not {_check.shown(radius)}")
        reach = _check.number("radius", radius, 0.0, FURTHEST_MM)
        return cls("sphere", _native.clip_shape("sphere", at, (reach, 0.0, 0.0)), space=space)

    def invert(self) -> ClipShape:
        """The same shape, cutting away what it kept."""
        return replace(self, inverted=not self.inverted)


@dataclass(frozen=True)
class Peel:
    """What lies less deep below the skin is not there. While ``mm`` changes, scan and depth stay on the GPU."""

    depth: Volume
    """Depth in mm, on any grid: :meth:`Volume.skin_depth`."""
    mm: float
    """What is taken off, 0 to 63 mm."""

    def __post_init__(self) -> None:
        if not isinstance(self.depth, Volume):
            raise TypeError(f"depth must be a lumivox.Volume, as volume.skin_depth() gives it, not {_check.shown(self.depth)}")
        object.__setattr__(self, "mm", _check.number("mm", self.mm, 0.0, MOST_PEELED_MM))


def clip_shapes(name: str, given: ClipShape | Iterable[ClipShape]) -> tuple[ClipShape, ...]:
    """Shapes that are some."""
    made = (given,) if isinstance(given, ClipShape | str) or not isinstance(given, Iterable) else tuple(given)
    for shape in made:
        if not isinstance(shape, ClipShape):
            made_by = "lumivox.ClipShape.plane(point, normal), .box(low, high) or .sphere(centre, radius) makes one"
            raise TypeError(f"{name} must be a lumivox.ClipShape, or several, not {_check.shown(shape)}: {made_by}")
    if len(made) > MOST_CLIP_SHAPES:
        raise ValueError(f"{name} is given {len(made)} times, of which {MOST_CLIP_SHAPES} are possible")
    return made
