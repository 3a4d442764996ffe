"""Scenes as documents: the words that files of scenes have, and that the native half reads (``docs/scenes.md``).

What Python has of its own is translated here, both ways, and nowhere else: where a sun stands becomes where its light travels
to, and a spot's target its direction.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import asdict, fields
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from lumivox import _native
    from lumivox.classification import ClipShape, LabelStyle
    from lumivox.labels import Labels
    from lumivox.light import Environment, Light, PointLight, SpotLight
    from lumivox.look import Medium, TransferFunction
    from lumivox.scene import Scene, VolumeInstance

VERSION = 1

SPACES = {"scene": "world", "patient": "patient"}
"""Python's words for the spaces that clip shapes lie in, and a document's."""

Words = Mapping[str, Any]
"""A part of a document."""

Part = tuple["_native.Volume", "_native.Labels | None", "_native.Volume | None"]
"""What a document does not hold of a volume: its voxels, its labels, depths below its skin."""


def text(words: Words) -> str:
    """JSON of a part of a document; of numpy's numbers, too."""
    return json.dumps(words, allow_nan=False, default=lambda number: number.item())


def of_scene(scene: Scene) -> Words:
    """What a scene is, besides voxels, labels and the light's map."""
    return {
        "lumivox_scene": VERSION,
        "volumes": [_of_instance(instance) for instance in scene.volumes],
        "environment": _of_environment(scene.environment),
        "lights": [_of_light(light) for light in scene.lights],
    }


def _of_instance(instance: VolumeInstance) -> Words:
    words: dict[str, Any] = {"scan": {}, "look": of_medium(instance.medium), "layers": instance.layers}
    if instance.clip != ((0.0, 0.0, 0.0), (1.0, 1.0, 1.0)):
        words["clip"] = instance.clip
    if instance.world_from_patient is not None:
        words["world_from_patient"] = instance.world_from_patient
    shapes: Any = instance.clip_shapes
    words["clip_shapes"] = [
        {"kind": shape.kind, "from_shape": shape.from_shape, "space": SPACES[shape.space], "inverted": shape.inverted}
        for shape in shapes
    ]
    if instance.labels is not None:
        pairs: Any = instance.label_styles
        words["labels"] = {"styles": [_of_style(instance.labels, value, style) for value, style in pairs]}
    if instance.peel is not None:
        words["peel"] = instance.peel.mm
    return words


def of_medium(medium: Medium) -> Words:
    """A look, written out."""
    own = {name: getattr(medium, name) for name in _same(type(medium))}
    return {**of_curve(medium.transfer_function), **own, "surface": asdict(medium.surface)}


def _same(kind: type[Medium]) -> list[str]:
    """What a medium has that is a look's by the same name: all but what is made of parts."""
    return [one.name for one in fields(kind) if one.name not in ("transfer_function", "surface")]


def of_curve(curve: TransferFunction) -> Words:
    """A transfer function's part of a look."""
    rows = [{"per_mm": row.per_mm, "transfer_function": _of_points(row.transfer_function)} for row in curve.gradients]
    return {"transfer_function": _of_points(curve), "gradients": rows}


def _of_points(curve: TransferFunction) -> Words:
    return {"opacity": curve.opacity, "color": curve.color}


def _of_style(labels: Labels, value: int, style: LabelStyle) -> Words:
    words = {name: getattr(style, name) for name in ("visible", "color", "opacity", "density", "clipped")}
    if style.transfer_function is not None:
        words["transfer_function"] = _of_points(style.transfer_function)
    if style.surface is not None:
        words["surface"] = asdict(style.surface)
    return {"label": labels.native.word_of(value), **{name: word for name, word in words.items() if word is not None}}


def _of_environment(environment: Environment) -> Words:
    words = {"strength": environment.strength, "rotation": environment.rotation}
    source = environment.source
    # A map comes beside the document.
    colors = (
        {"uniform": ("color",), "gradient": ("zenith", "horizon", "nadir")}.get(source, ()) if isinstance(source, str) else ()
    )
    return {
        **words,
        "source": source if isinstance(source, str) else "studio",
        **{name: getattr(environment, name) for name in colors},
    }


def _of_light(light: Light) -> Words:
    from lumivox.light import DirectionalLight, PointLight, Sun

    if isinstance(light, DirectionalLight):
        return {"kind": "sun", **asdict(light)}
    if isinstance(light, Sun):
        around, above = math.radians(light.azimuth), math.radians(light.elevation)
        direction = (-math.sin(around) * math.cos(above), -math.sin(above), -math.cos(around) * math.cos(above))
        irradiance = [light.strength * math.pi] * 3
        return {"kind": "sun", "direction": direction, "irradiance": irradiance, "degrees": light.degrees, "layers": light.layers}
    if isinstance(light, PointLight):
        return {"kind": "point", "lamp": _of_lamp(light), "layers": light.layers}
    direction = tuple(to - at for to, at in zip(light.target, light.position, strict=True))
    words = {
        "kind": "spot",
        "lamp": _of_lamp(light),
        "direction": direction,
        "half_angle": light.half_angle,
        "layers": light.layers,
    }
    return {
        **words,
        "cone": {"attenuation": light.attenuation}
        if light.inner_half_angle is None
        else {"inner_half_angle": light.inner_half_angle},
    }


def _of_lamp(lamp: PointLight | SpotLight) -> Words:
    power = {"decay": lamp.decay, **({} if lamp.range is None else {"range": lamp.range})}
    falloff = {"relative": {"range": lamp.range}} if lamp.decay is None else {"power": power}
    return {"position": lamp.position, "intensity": lamp.intensity, "radius": lamp.radius, "falloff": falloff}


def scene(words: Words, parts: list[Part], environment_map: _native.EnvironmentMap | None) -> Scene:
    """The scene of a document that is written out, with what it does not hold."""
    from lumivox.scene import Scene

    instances = [_instance(entry, part) for entry, part in zip(words["volumes"], parts, strict=True)]
    lights = tuple(_light(light) for light in words.get("lights", ()))
    return Scene(tuple(instances), _environment(words["environment"], environment_map), lights)


def _instance(words: Words, part: Part) -> VolumeInstance:
    from lumivox.classification import Peel
    from lumivox.labels import Labels
    from lumivox.scene import VolumeInstance
    from lumivox.volume import Volume

    volume, labels, depth = part
    named = None if labels is None else Labels(labels)
    styles = {} if named is None else {style["label"]: _style(style) for style in words["labels"].get("styles", ())}
    low, high = words.get("clip", ((0.0, 0.0, 0.0), (1.0, 1.0, 1.0)))
    return VolumeInstance(
        Volume(volume),
        medium(words["look"]),
        (tuple(low), tuple(high)),
        words.get("world_from_patient"),
        words["layers"],
        named,
        styles,
        tuple(_shape(shape) for shape in words.get("clip_shapes", ())),
        None if depth is None else Peel(Volume(depth), words["peel"]),
    )


def medium(words: Words) -> Medium:
    """The medium of a look that is written out."""
    from lumivox.look import Medium, SurfaceReflection

    own = {name: words[name] for name in _same(Medium)}
    return Medium(curve(words), **own, surface=SurfaceReflection(**words["surface"]))


def curve(words: Words) -> TransferFunction:
    """The transfer function of a look."""
    rows = [(row["per_mm"], _points(row["transfer_function"])) for row in words.get("gradients", ())]
    return _points(words["transfer_function"], rows)


def _points(words: Words, rows: Any = ()) -> TransferFunction:
    from lumivox.look import TransferFunction

    return TransferFunction(words["opacity"], words["color"], rows)


def _style(words: Words) -> LabelStyle:
    from lumivox.classification import LabelStyle
    from lumivox.look import SurfaceReflection

    given = {name: word for name, word in words.items() if name != "label"}
    if "transfer_function" in given:
        given["transfer_function"] = _points(given["transfer_function"])
    if "surface" in given:
        given["surface"] = SurfaceReflection(**given["surface"])
    return LabelStyle(**given)


def _shape(words: Words) -> ClipShape:
    from lumivox.classification import ClipShape

    own = {theirs: ours for ours, theirs in SPACES.items()}
    rows = tuple(tuple(row) for row in words["from_shape"])
    return ClipShape(words["kind"], rows, words.get("inverted", False), own[words.get("space", "patient")])  # type: ignore[arg-type]


def _environment(words: Words, environment_map: _native.EnvironmentMap | None) -> Environment:
    from lumivox.light import Environment, EnvironmentMap

    given = dict(words)
    if environment_map is not None:
        given["source"] = EnvironmentMap._of(environment_map)
    return Environment(**given)


def _light(words: Words) -> Light:
    from lumivox.light import DirectionalLight, PointLight, SpotLight

    given = {name: word for name, word in words.items() if name != "kind"}
    if words["kind"] == "sun":
        return DirectionalLight(**given)
    lamp = given.pop("lamp")
    ((kind, falloff),) = lamp.pop("falloff").items()
    lamp |= {"decay": falloff["decay"] if kind == "power" else None, "range": falloff.get("range")}
    if words["kind"] == "point":
        return PointLight(**lamp, **given)
    direction, cone = given.pop("direction"), given.pop("cone")
    target = tuple(at + along for at, along in zip(lamp["position"], direction, strict=True))
    return SpotLight(**lamp, target=target, **given, **cone)
