"""A scan in a notebook, live: turn it with the mouse, choose a preset, drag its opacity.

    from lumivox import widget

    view = widget.View(scan)
    view

Needs anywidget (``pip install 'lumivox[widget]'``). Where the browser has a graphics card, it renders itself. What was set with
the mouse is there as attributes: ``view.azimuth``, ``view.transfer_function``; ``view.image`` is what is shown.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from lumivox import _check, browser, look, rendering
from lumivox._check import PathLike
from lumivox.image import Image
from lumivox.live import Live, Settings, histogram, usual_angles
from lumivox.look import ColorStop, GradientFunction, OpacityKnot, TransferFunction
from lumivox.scene import Scene, pixels
from lumivox.volume import Volume

try:
    import anywidget
    import traitlets
except ImportError as error:
    raise ImportError("lumivox.widget needs anywidget: pip install 'lumivox[widget]'") from error


class View(anywidget.AnyWidget):  # type: ignore[misc]
    """A scan in a notebook. ``options`` are those of :func:`lumivox.render` that it has no handle for.

    While it is turned it shows a picture of the light that is kept in the scan, without noise; with ``kept_light=False`` a
    coarse one. At rest the image is the same in either case.

    ``in_browser`` says who renders. ``None``: the browser, where it has WebGPU on a graphics card and the scan can be sent to it,
    else the kernel. ``True``: the browser wherever it has WebGPU, in software, too. ``False``: the kernel.
    """

    _esm = Path(__file__).with_name("widget.js")
    png = traitlets.Bytes(b"").tag(sync=True)
    width = traitlets.Int(512).tag(sync=True)
    height = traitlets.Int(512).tag(sync=True)
    azimuth = traitlets.Float(0.0).tag(sync=True)
    elevation = traitlets.Float(0.0).tag(sync=True)
    zoom = traitlets.Float(1.0).tag(sync=True)
    preset = traitlets.Unicode("").tag(sync=True)
    presets = traitlets.List(traitlets.Unicode()).tag(sync=True)
    knots = traitlets.List().tag(sync=True)
    """Opacity knots ``[value, opacity, ease]`` of the look, as they are dragged."""
    stops = traitlets.List().tag(sync=True)
    """Colour stops ``[value, [r, g, b]]``, linear."""
    value_range = traitlets.List(traitlets.Float()).tag(sync=True)
    histogram = traitlets.List(traitlets.Float()).tag(sync=True)
    """Voxels by value, as fractions of the fullest bar, on a logarithmic scale."""
    samples = traitlets.Int(0).tag(sync=True)
    target = traitlets.Int(0).tag(sync=True)
    """Samples that it comes to rest with."""
    unit = traitlets.Unicode("").tag(sync=True)
    message = traitlets.Unicode("").tag(sync=True)
    """What went wrong; empty where nothing did."""
    page_renders = traitlets.Unicode("never").tag(sync=True)
    """When a page is to render itself: ``"never"``, ``"card"`` (with a graphics card) or ``"always"``."""
    _live: Live | None = None

    def __init__(
        self,
        scan: Volume,
        *,
        size: tuple[int, int] = (512, 512),
        samples: int = 512,
        kept_light: bool = True,
        in_browser: bool | None = None,
        **options: Any,
    ) -> None:
        if not isinstance(scan, Volume):
            raise TypeError(f"a view shows a lumivox.Volume, not {_check.shown(scan)}")
        # What is wrong is said where the view is made, not on its thread.
        width, height = pixels(size)
        kept_light = _check.flag("kept_light", kept_light)
        if in_browser is not None:
            in_browser = _check.flag("in_browser", in_browser)
        for name in ("camera", "eye", "target"):
            if name in options:
                raise TypeError(f"{name} is not for a view: it is turned by azimuth and elevation, and comes closer by zoom")
        curve = options.pop("transfer_function", None)
        planned = rendering.plan(
            scan,
            {**options, "size": size, "samples": samples, **({} if curve is None else {"transfer_function": curve})},  # type: ignore[typeddict-item]
        )
        why = browser.obstacle(planned.scene)
        can_page = why is None and browser.has_program()
        if in_browser and not can_page:
            missing = "this lumivox was made without the program for browsers"
            raise ValueError(f"in_browser: {missing if why is None else f'a browser cannot show this: {why}'}")
        super().__init__()
        self._scan, self._display, self._seed = scan, planned.display, planned.request.seed
        self._fov = planned.camera.fov
        self._sent: tuple[Volume, ...] | None = None
        self._has_page = self._wants_pictures = False
        self._image: Image | None = None
        self._quiet = False
        self._edited = False
        self._gradients: tuple[GradientFunction, ...] = ()
        self.width, self.height = width, height
        self.target, self.unit = planned.request.samples, scan.unit
        self.presets = [preset.name for preset in look.presets()]
        low, high = scan.value_range
        self.value_range = [low, max(high, low + 1.0)]
        self.histogram = histogram(scan)
        angles = options.pop("azimuth", None), options.pop("elevation", None)
        if angles == (None, None):
            angles = usual_angles(planned.scene)
        self.azimuth, self.elevation = (angle or 0.0 for angle in angles)
        self.zoom = options.pop("zoom", 1.0)
        self.preset, _ = look.preset_medium(options.pop("preset", None) or look.default_preset(scan), scan)
        if options.get("labels") is not None:
            # Found or read once, not for each look.
            options["labels"] = planned.scene.volumes[0].labels
        self._live = Live(scan, (width, height), planned.request.samples, self._shown, self._failed, kept_light, **options)
        self._take_preset()
        if curve is not None:
            self.transfer_function = planned.scene.volumes[0].medium.transfer_function
            self._edited = True
        if can_page and in_browser is not False:
            self.page_renders = "always" if in_browser else "card"
            self.on_msg(self._on_page)
        self.observe(self._on_preset, ["preset"])
        self.observe(self._on_curve, ["knots", "stops"])
        self.observe(self._on_change, ["azimuth", "elevation", "zoom"])
        self._on_change()

    @traitlets.validate("preset")  # type: ignore[untyped-decorator]
    def _known_preset(self, proposal: Any) -> str:
        name = str(proposal["value"])
        if self.presets and name not in self.presets:
            raise traitlets.TraitError(f"preset {name!r} is not one of {', '.join(self.presets)}")
        return name

    @property
    def image(self) -> Image | None:
        """What is shown; ``None`` before there is anything. Where a browser renders, this is rendered anew by the kernel."""
        if self._live is not None and not self._live.renders:
            return self._live.now(self._settings())
        return self._image

    @property
    def transfer_function(self) -> TransferFunction:
        """The look's opacity and colour, as they were edited."""
        knots, stops = [OpacityKnot(*knot) for knot in self.knots], [ColorStop(v, tuple(c)) for v, c in self.stops]
        return TransferFunction(knots, stops, self._gradients)

    @transfer_function.setter
    def transfer_function(self, curve: TransferFunction) -> None:
        self._gradients = look.curve(curve).gradients
        self.set_trait("stops", [[stop.value, list(stop.color)] for stop in curve.color])
        self.set_trait("knots", [list(knot) for knot in curve.opacity])
        # Points that are the same as before tell nobody, and the rows for gradients may be others.
        self._on_curve(None)

    def save_scene(self, path: PathLike) -> None:
        """Writes what is shown to a file that every host of Lumivox opens, see :meth:`Scene.save`."""
        if self._live is not None and not self._live.renders:
            self._live.save(self._settings(), path)
            return
        if self._image is None:
            raise ValueError("nothing is shown yet, so that there is no scene to save")
        self._image.save_scene(path, size=(self.width, self.height), samples=self.target)

    def close(self) -> None:
        """Ends the view and its thread."""
        if self._live is not None:
            self._live.end()
        super().close()

    def _take_preset(self) -> None:
        _, medium = look.preset_medium(self.preset, self._scan)
        self._quiet = True
        try:
            self.transfer_function = medium.transfer_function
        finally:
            self._quiet = False
        self._edited = False

    def _on_preset(self, _: object) -> None:
        self._take_preset()
        self._on_change()

    def _on_curve(self, _: object) -> None:
        if not self._quiet:
            self._edited = True
            self._on_change()

    def _settings(self) -> Settings:
        curve = self.transfer_function if self._edited else None
        # A page may send anything: what makes no sense is brought into its range.
        elevation, zoom = min(max(self.elevation, -90.0), 90.0), min(max(self.zoom, 0.1), 20.0)
        return Settings(self.azimuth, elevation, zoom, self.preset, curve)

    def _on_change(self, _: object = None) -> None:
        try:
            settings = self._settings()
        except (TypeError, ValueError) as error:
            self.message = str(error)
            return
        if self._live is not None:
            self._live.update(settings)

    def _on_page(self, _: object, content: Any, buffers: Any) -> None:
        """What a page says of itself: it renders (``begin``), has done so (``picture``), or wants the kernel's ``pictures``."""
        kind = content.get("kind") if isinstance(content, dict) else None
        if self._live is None:
            return
        if kind == "picture" and buffers:
            if not self._live.renders:
                self.samples, self.png = int(content.get("samples", 0)), bytes(buffers[0])
            return
        if kind == "pictures":
            self._wants_pictures = True
            if self._live.renders:
                return
        elif kind == "begin":
            self.message = ""
            self.send({"kind": "program"}, browser.program())
            # Another page begins with nothing.
            self._sent, self._has_page = None, True
        else:
            return
        try:
            self._live.hand_over(self._tell_page if self._has_page else None, self._wants_pictures, self._settings())
        except (TypeError, ValueError) as error:
            self.message = str(error)

    def _tell_page(self, scene: Scene, settings: Settings) -> None:
        """Sends pages a scene, and its voxels where they have others."""
        self.message = ""
        volumes = tuple(one.volume for one in scene.volumes)
        if self._sent != volumes:
            told, sent = browser.parts(scene)
            self.send({"kind": "scans", "scans": told}, sent)
            self._sent = volumes
        camera = {"azimuth": settings.azimuth, "elevation": settings.elevation, "zoom": settings.zoom, "fov": self._fov}
        document = browser.document(scene, self._display, self._seed, camera)
        self.send({"kind": "scene", "document": document})

    def _failed(self, error: Exception) -> None:
        self.message = str(error)

    def _shown(self, image: Image) -> None:
        self._image = image
        self.message = ""
        self.samples = image.min_samples
        self.png = image._repr_png_()

    def _repr_png_(self) -> bytes | None:
        return self.png or None
