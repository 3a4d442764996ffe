"""Scenes in files: what every host of Lumivox saves and opens (``docs/scenes.md``)."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass, field
from typing import Any

from lumivox import _check, _document, _native, rendering
from lumivox._check import PathLike
from lumivox.image import Display, Image
from lumivox.scene import Camera, Scene
from lumivox.volume import StageProgress

IMAGE = ("size", "samples", "seed", "noise", "denoise")
"""Options of an image that are kept with a scene."""


@dataclass(frozen=True)
class SavedScene:
    """A scene as it was saved: with where it was seen from, and its image."""

    scene: Scene
    camera: Camera
    size: tuple[int, int] = (768, 768)
    """Width and height in pixels."""
    samples: int | None = None
    """Paths per pixel; ``None`` for as many as are usual."""
    seed: int = 0
    """Another gives other noise."""
    noise: float | None = None
    """Relative noise at which the image is done before it has all samples."""
    denoise: bool = False
    """Whether the noise that is left is smoothed out."""
    display: Display = field(default_factory=Display)
    """How light becomes pixels."""

    def options(self) -> dict[str, Any]:
        """Those of :func:`lumivox.render` that it stands for."""
        own = {name: getattr(self, name) for name in ("camera", *IMAGE)}
        return {**own, **asdict(self.display)}

    def render(self, **options: Any) -> Image:
        """The image; ``options`` of :func:`lumivox.render` win over what was saved."""
        return rendering.render(self.scene, **self._with(options))

    def save(self, path: PathLike, **options: Any) -> None:
        """Writes it to a file, as it was or with other ``options``, those of :meth:`Scene.save`.

        What is said of scans, looks and light is that of ``scene``: ``dataclasses.replace(saved, scene=...)`` changes it.
        """
        given = self._with(options)
        save(self.scene, path, given.pop("camera", None), given)

    def _with(self, options: dict[str, Any]) -> dict[str, Any]:
        """Its own options, over which others win."""
        given = self.options()
        if rendering.FRAMING & options.keys():
            del given["camera"]
            given["fov"] = self.camera.fov
        return {**given, **options}


def load_scene(path: PathLike, *, allow_outside_data: bool = False, progress: StageProgress | None = None) -> SavedScene:
    """Opens a scene that the command, Python or an engine saved.

    - ``allow_outside_data``: headers (``.mhd``, ``.nhdr``) may name data files anywhere.
    - ``progress``: is told ``(stage, done, total)`` while scans are read.

    What is wrong with the file is a :class:`ScanError` that names the line; a scan that is not there is a
    :class:`MissingFileError` that does so, too; a scan that is another than it was is told as a warning.
    """
    name = _check.file("path", path)
    _check.called("progress", progress, "(stage, done, total)")
    text, parts, environment_map, rows, fov, notes = _native.load_scene(
        name, _check.flag("allow_outside_data", allow_outside_data), progress
    )
    for note in notes:
        _check.warn(note)
    words = json.loads(text)
    film = words["film"]
    return SavedScene(
        _document.scene(words, parts, environment_map),
        Camera(rows, fov),
        **{**{one: film[one] for one in IMAGE if one in film}, "size": tuple(film["size"])},
        display=Display(**words["display"]),
    )


def save(scene: Scene, path: PathLike, camera: Camera | None, options: dict[str, Any]) -> None:
    """Writes a scene, see :meth:`Scene.save`."""
    name = _check.file("path", path)
    _check.writable(name)
    kept = rendering.FRAMING | rendering.DISPLAY | {"fov", *IMAGE}
    for option in options:
        if option not in kept:
            raise TypeError(f"a scene keeps no option '{option}'; there are {_check.listed(sorted(kept))}")
    given: Any = {"camera": camera, **options} if camera is not None else options
    planned = rendering.plan(scene, given)
    film = {one: options[one] for one in IMAGE if options.get(one) is not None}
    display = {one: getattr(planned.display, one) for one in sorted(rendering.DISPLAY)}
    _native.save_scene(name, scene, planned.camera, _document.text(film), _document.text(display))
