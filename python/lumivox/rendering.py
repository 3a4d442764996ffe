"""Rendering: options, GPUs, whole images and images little by little."""

from __future__ import annotations

import difflib
import inspect
import os
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal, TypedDict, TypeVar

from lumivox import _check, _native
from lumivox._check import PathLike, Vector
from lumivox.classification import ClipShape, Labelled
from lumivox.image import Display, Image
from lumivox.labels import Labels
from lumivox.light import Environment, EnvironmentMap, Light
from lumivox.look import Filter, SurfaceReflection
from lumivox.scene import Camera, Curve, Scene, pixels
from lumivox.volume import Volume

if sys.version_info >= (3, 11):
    from typing import Unpack
else:
    from typing_extensions import Unpack

DEFAULT_SAMPLES = 512
"""Paths per pixel unless asked otherwise: little noise, and seconds on a GPU."""

DEFAULT_SOFTWARE_TIME = 120.0
"""Seconds after which it ends where it would take long for want of a GPU, unless asked otherwise."""

MOST_SAMPLES = 1 << 24

LEAST_FOR_NOISE = 16
"""Samples before which the noise of a pixel is not known."""
"""The film counts in 32-bit floats, which are exact up to here."""


@dataclass(frozen=True)
class Progress:
    """How far a render is."""

    samples: float
    """Samples of the average pixel."""
    target: int
    """Samples asked for."""
    elapsed: float
    """Seconds since tracing began."""
    left: float
    """Seconds until it is complete, by what it took so far."""
    noise: float | None
    """Noise at the last look, as a fraction of the brightness."""


RenderProgress = Callable[[Progress], object]
"""Is told how far a render is; returning ``False`` stops it and keeps what there is."""


class Options(TypedDict, total=False):
    """What can be asked of a render; see :func:`render`."""

    preset: str | Sequence[str] | None
    transfer_function: Curve | Sequence[Curve] | None
    shift: float | Sequence[float]
    window_scale: float | Sequence[float]
    window: tuple[float, float] | Sequence[tuple[float, float] | None] | None
    density: float | Sequence[float | None] | None
    albedo: float | None
    anisotropy: float | None
    bounces: int | None
    surface: bool | SurfaceReflection | None
    filter: Filter
    peel: float | None
    peel_mm: float | None
    clip: tuple[Vector, Vector] | None
    clip_shape: ClipShape | Sequence[ClipShape]
    labels: Labels | Literal["found"] | PathLike | None
    label: Labelled | None
    camera: Camera | None
    azimuth: float | None
    elevation: float | None
    zoom: float
    fov: float
    eye: Vector | None
    target: Vector | None
    environment: str | Environment | EnvironmentMap
    environment_strength: float
    environment_rotation: float
    light: Light | Sequence[Light]
    size: tuple[int, int] | Sequence[int]
    samples: int | None
    noise: float | None
    first_sample: int
    region: tuple[int, int, int, int] | None
    time: float | None
    seed: int
    layers: bool
    denoise: bool
    exposure: float
    tone: str
    gamma: float
    background: str
    gpu: int | str | None
    pass_samples: int | None
    progress: RenderProgress | None


Function = TypeVar("Function", bound=Callable[..., Any])


OWN: Options = {
    "camera": None,
    "eye": None,
    "size": (768, 768),
    "samples": None,
    "noise": None,
    "first_sample": 0,
    "region": None,
    "time": None,
    "seed": 0,
    "layers": False,
    "denoise": False,
    "gpu": None,
    "pass_samples": None,
    "progress": None,
}
"""What a render does unless asked otherwise, besides what a scene, a camera and a display do."""


def _defaults() -> dict[str, Any]:
    """The default of each option, where it is written down."""
    written: dict[str, Any] = {}
    for function in (Display, Camera.framing, Scene.of):
        parameters = inspect.signature(function).parameters.values()
        written.update({one.name: one.default for one in parameters})
    written.update(OWN)
    return {name: written[name] for name in Options.__annotations__}


DEFAULTS = _defaults()


def with_options(function: Function) -> Function:
    """Spells out the options of a function that takes them by name, so that editors and notebooks complete them.

    Names and defaults alone, as people read them; types are those of :class:`Options`, for tools.
    """
    kept = inspect.signature(function)
    given = [one for one in kept.parameters.values() if one.kind is not inspect.Parameter.VAR_KEYWORD]
    options = [
        inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=default)
        for name, default in DEFAULTS.items()
        if name not in kept.parameters
    ]
    shown = [one.replace(annotation=inspect.Parameter.empty) for one in given]
    vars(function)["plain_signature"] = kept
    vars(function)["__signature__"] = inspect.Signature([*shown, *options])
    return function


LOOK = frozenset(
    {
        "preset",
        "transfer_function",
        "shift",
        "window_scale",
        "window",
        "density",
        "albedo",
        "anisotropy",
        "bounces",
        "surface",
        "filter",
        "peel",
        "peel_mm",
        "clip",
        "clip_shape",
        "labels",
        "label",
        "environment",
        "environment_strength",
        "environment_rotation",
        "light",
    }
)
FRAMING = frozenset(["azimuth", "elevation", "zoom", "eye", "target"])
DISPLAY = frozenset(["background", "exposure", "tone", "gamma"])


@dataclass(frozen=True)
class Request:
    """How an image is sampled."""

    size: tuple[int, int]
    samples: int
    time: float | None = None
    seed: int = 0
    guides: bool = False
    first_sample: int = 0
    pass_samples: int | None = None
    window: tuple[int, int, int, int] | None = None
    """The part of the image: its left column, top row, width and height."""
    noise: float | None = None
    """Relative noise at which it is done before it has all samples."""


@dataclass(frozen=True)
class Plan:
    """A render that was asked for, with nothing left to choose but the GPU."""

    scene: Scene
    camera: Camera
    request: Request
    display: Display
    denoise: bool
    unbounded: bool
    """Whether nobody said how long it may take."""

    @property
    def as_many_as_time_allows(self) -> bool:
        """Whether a time was asked for, and no number of samples."""
        return self.request.time is not None and self.request.samples == MOST_SAMPLES


@dataclass(frozen=True)
class Gpu:
    """A device that could render."""

    index: int
    name: str
    driver: str
    api: str
    software: bool
    """Whether it computes on the CPU."""
    unsuitable: str | None
    """What it lacks, where it cannot be used."""


def gpus() -> list[Gpu]:
    """Every device, the most capable first; ``render(gpu=...)`` takes an index, or a part of a name."""
    return [Gpu(index, *device) for index, device in enumerate(_native.gpus())]


class Renderer:
    """Renders on one GPU, by index or by a part of its name; the scan stays there between images.

    :func:`render` keeps one for each GPU; make one to free it earlier, by letting go of it.
    """

    def __init__(self, gpu: int | str | None = None) -> None:
        self.native = _native.Renderer(_which(gpu))
        self.uploaded = 0
        """Bytes that the last image brought to the GPU: no voxels where they were there already."""

    @property
    def gpu(self) -> Gpu:
        """What it renders on; its index is not known."""
        return Gpu(-1, *self.native.device)

    @with_options
    def render(self, scan: Scene | Volume | Sequence[Volume], **options: Unpack[Options]) -> Image:
        """As :func:`lumivox.render`, on this GPU."""
        if options.get("gpu") is not None:
            raise ValueError("a Renderer has its GPU; make another for another, or call lumivox.render(gpu=...)")
        return self.run(plan(scan, options), options.get("progress"))

    def run(self, planned: Plan, progress: RenderProgress | None = None) -> Image:
        """Renders what was planned."""
        request = planned.request
        if planned.unbounded and self.gpu.software:
            request = replace(request, time=DEFAULT_SOFTWARE_TIME)
        film, outcome, _, trace, unfinished, reductions, self.uploaded = self.native.render(
            planned.scene, planned.camera, request, _teller(progress)
        )
        if outcome not in ("complete", "time", "stopped"):
            # What there is of it was kept for those who wait at a screen; a program wants to know.
            raise _native.GpuError(outcome)
        notes = _notes(film, unfinished, reductions)
        if outcome == "time" and not planned.as_many_as_time_allows:
            notes.append(_late(film, request))
        # Who asked for what there is time for, and for no number of samples, has it.
        done = outcome == "complete" or (outcome == "time" and planned.as_many_as_time_allows)
        image = Image(film, planned.scene, planned.camera, planned.display, done, trace, tuple(notes))
        return image.denoised() if planned.denoise else image


def _late(film: _native.Film, request: Request) -> str:
    return f"the time was over at {film.min_samples} of the {request.samples - request.first_sample} samples per pixel"


def _notes(film: _native.Film, unfinished: int, reductions: Sequence[int]) -> list[str]:
    """What is worth knowing about an image."""
    notes = []
    if unfinished > 0:
        notes.append(f"{unfinished} pixels are darker than they should be: their longest paths had not ended")
    coarsest = max(reductions, default=1)
    if coarsest > 1:
        notes.append(f"the GPU has no room for all voxels: the scan was rendered at 1/{coarsest} of its resolution")
    if film.min_samples > 0 and not film.alpha().any():
        notes.append("no ray met the scan: check eye, camera, clip, clip_shape, label, the transfer function")
    return notes


def _which(gpu: Any) -> int | str | None:
    """An index, or a part of a name."""
    if gpu is None or isinstance(gpu, str):
        return gpu
    if not _check.is_number(gpu) or gpu != gpu // 1:
        raise TypeError(f"gpu must be an index of lumivox.gpus(), or a part of a name, not {_check.shown(gpu)}")
    if gpu < 0:
        raise ValueError(f"gpu must be an index of lumivox.gpus(), from 0, not {_check.shown(gpu)}")
    return int(gpu)


_renderers: dict[int | str | None, Renderer] = {}


def renderer(gpu: int | str | None = None) -> Renderer:
    """The renderer that is kept for a GPU."""
    gpu = _which(gpu)
    if gpu not in _renderers:
        _renderers[gpu] = Renderer(gpu)
    return _renderers[gpu]


@with_options
def render(scan: Scene | Volume | Sequence[Volume], **options: Unpack[Options]) -> Image:
    """Renders a scan, several in the patient space they share, or a scene. Options and defaults are the command's.

    Look (not with a :class:`Scene`, which has one), once for all scans or once for each:

    - ``preset``: a name. Default: what suits the scan; see :func:`lumivox.presets`.
    - ``transfer_function``: opacity and colour by value (and gradient), in place of the preset's; or a file of it.
    - ``shift``, ``window_scale``: moves opacity and colour to higher values (HU for CT), and widens them about their centre
      (0.01 to 100), as a window's level and width do. ``window``, in their place: stretches them over a level and a width
      in the scan's unit: ``(40, 400)``.
    - ``density``: factor on the extinction, per millimetre however large the scan is. ``albedo``: fraction of light that
      survives a scattering, 0 to 1. ``anisotropy``: mean cosine of scattering, -0.99 to 0.99. ``bounces``: most scatterings
      along a path, 1 to 1000. ``surface``: reflection where the value changes quickly. Default of all: the preset's.
    - ``filter``: ``"smooth"`` (default), ``"trilinear"``, ``"tricubic"`` or ``"nearest"``.
    - ``peel``: millimetres below the skin that are taken off a CT, up to 63. Default: the preset's.
      ``peel_mm``, in its place: the same while it is looked at: other amounts cost nothing more.
    - ``clip``: the part to keep: two corners, fractions along the voxel axes x, y, z.
      ``clip_shape``: cuts it open: a :class:`ClipShape`, or several; what each keeps is seen.
    - ``labels``: which voxels are what: :class:`Labels`, a file (see :func:`load_labels`), or ``"found"`` for what is found in
      a CT by itself. ``label``: how they look, in turn: a dict of :class:`LabelStyle` by name, by number, or by ``"*"`` for
      all; or of the command's words: ``{"*": "opacity:0.2", "lungs": "hide", "bone": "color:#e8d8b0,opacity:1,uncut"}``.

    Camera:

    - ``camera``, in place of: ``azimuth`` and ``elevation`` (degrees around the patient; 0 sees the face, and a single slice
      is seen from its front unless one of them is given), ``zoom`` (1), ``eye`` and ``target`` (mm from the first scan's
      centre). ``fov``: degrees from bottom to top (28).

    Light (not with a :class:`Scene`):

    - ``environment``: ``"studio"`` (default), ``"uniform"``, ``"gradient"``, an ``.hdr`` or ``.exr`` file, or an
      :class:`Environment`; ``environment_strength`` (1), ``environment_rotation`` (degrees). ``light``: suns and lamps.

    Image:

    - ``size``: width and height in pixels (768, 768).
    - ``samples``: paths per pixel (512, or as many as ``time`` allows; without a GPU, as many as two minutes allow).
      ``noise``: ends before, once the error that is left is such a fraction of the image's brightness: 0.02 is hardly seen.
      ``time``: seconds of tracing after which it ends. ``seed``: another seed gives other noise.
      ``first_sample``: begins with that one, so that the sums of several ranges (``image.film.sums()``) add up to the whole.
    - ``region``: the part of the image that is rendered: left column, top row, width and height. Default: all of it.
    - ``layers``: keeps albedo and normal, too. ``denoise``: smooths out the noise that is left, slightly biased.
    - ``exposure`` (stops), ``tone`` (``"agx"``), ``gamma`` (1), ``background`` (``"#14171c"``).

    Running:

    - ``gpu``: an index of :func:`gpus`, or a part of a name. Default: the most capable.
    - ``progress``: is told a :class:`Progress` a few times a second; ``False`` from it stops, and keeps what there is.
    - ``pass_samples``: samples of a pixel that are added up before the film is; fixed, the same scene gives the same sums
      to the last bit on all devices of a kind. Default: what is fastest.

    Ctrl-C stops it. Other threads run meanwhile. Raises :class:`GpuError` or :class:`RenderError`, and ``ValueError`` for
    options that make no sense.
    """
    planned = plan(scan, options)
    return renderer(options.get("gpu")).run(planned, options.get("progress"))


def _forget() -> None:
    """In a process that was forked: what the parent has open is the parent's."""
    _renderers.clear()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_forget)


@with_options
def progressive(scan: Scene | Volume | Sequence[Volume], **options: Unpack[Options]) -> Iterator[Image]:
    """The images of a render under way: of 1, 2, 4, 8 ... samples, until it is complete. Options are those of :func:`render`.

    What is wrong with options is raised at once. Leaving the loop stops it and frees the GPU.
    """
    planned = plan(scan, options)
    return _progressive(planned, renderer(options.get("gpu")), _teller(options.get("progress")))


def _progressive(planned: Plan, chosen: Renderer, told: Callable[..., object] | None) -> Iterator[Image]:
    limit = planned.request.time
    if planned.unbounded and chosen.gpu.software:
        limit = DEFAULT_SOFTWARE_TIME
    # The limit is looked at here, between images.
    request = replace(planned.request, time=None)
    still = chosen.native.begin(planned.scene, planned.camera, request)
    try:
        samples = request.first_sample + 1
        while True:
            samples = min(samples, request.samples)
            film, outcome, seconds, unfinished, reductions = still.trace_to(samples, told)
            clean = request.noise is not None and film.min_samples >= LEAST_FOR_NOISE and (film.noise or 0.0) <= request.noise
            whole = outcome == "complete" and (clean or samples == request.samples)
            late = not whole and limit is not None and seconds >= limit
            notes = _notes(film, unfinished, reductions)
            if late and not planned.as_many_as_time_allows:
                notes.append(_late(film, request))
            done = whole or (late and planned.as_many_as_time_allows)
            image = Image(film, planned.scene, planned.camera, planned.display, done, seconds, tuple(notes))
            yield image.denoised() if planned.denoise else image
            if whole or late or outcome == "stopped":
                return
            samples *= 2
    finally:
        still.end()


class Moving:
    """Pictures of a scene that moves, of the light that is kept in its volumes: without noise, and a little biased. What was
    learnt of the light serves the next picture, wherever it is seen from."""

    def __init__(self, gpu: int | str | None = None) -> None:
        self._native = _native.Moving(renderer(gpu).native)

    def picture(self, planned: Plan) -> Image | None:
        """What was planned, as far as it is known now; ``None`` where the GPU has no room for its light."""
        pictured = self._native.picture(planned.scene, planned.camera, planned.request.size)
        if pictured is None:
            return None
        film, seconds = pictured
        return Image(film, planned.scene, planned.camera, planned.display, False, seconds, smoothed=True)

    def end(self) -> None:
        """Frees what it has on the GPU."""
        self._native.end()


def plan(scan: Scene | Volume | Sequence[Volume], options: Options) -> Plan:
    """What options ask for; ``ValueError`` and ``TypeError`` say what makes no sense."""
    asked: dict[str, Any] = dict(options)
    for name in asked:
        if name not in Options.__annotations__:
            near = difflib.get_close_matches(name, Options.__annotations__, 1)
            hint = f"; did you mean '{near[0]}'?" if near else ""
            raise TypeError(f"there is no option '{name}'{hint}")
    given = {**DEFAULTS, **asked}
    _check.called("progress", given["progress"], "a lumivox.Progress")
    _which(given["gpu"])
    size = pixels(given["size"])
    # What is wrong with a picture is said before it is traced.
    display = Display(**{name: given[name] for name in DISPLAY})
    noise = given["noise"]
    if noise is not None:
        noise = _check.number("noise", noise, 1e-4, 1.0)
    samples, time, unbounded = _extent(given["samples"], given["time"], noise)
    seed = _check.whole("seed", given["seed"], 0, (1 << 32) - 1)
    layers, denoise = (_check.flag(name, given[name]) for name in ("layers", "denoise"))
    pass_samples = given["pass_samples"]
    if pass_samples is not None:
        pass_samples = _check.whole("pass_samples", pass_samples, 1, MOST_SAMPLES)
    first = _check.whole("first_sample", given["first_sample"], 0, samples - 1)
    region = _region(given["region"], size)
    looks = {name: asked[name] for name in LOOK if name in asked}
    if isinstance(scan, Scene):
        if looks:
            raise ValueError(f"a scene has its look and light: {', '.join(sorted(looks))} cannot be given besides")
        scene = scan
    else:
        scene = Scene.of(scan, **looks)
    camera = _camera(scene, asked, size, given["fov"])
    request = Request(size, samples, time, seed, layers or denoise, first, pass_samples, region, noise)
    return Plan(scene, camera, request, display, denoise, unbounded)


def _region(given: Any, size: tuple[int, int]) -> tuple[int, int, int, int] | None:
    """A part of an image, if it is one."""
    if given is None:
        return None
    made = tuple(given) if isinstance(given, Sequence) and not isinstance(given, str) else ()
    if len(made) != 4:
        raise TypeError(f"region must be left column, top row, width and height, not {_check.shown(given)}")
    left, top = (_check.whole("region", value, 0, most - 1) for value, most in zip(made[:2], size, strict=True))
    width, height = (_check.whole("region", made[2], 1, size[0] - left), _check.whole("region", made[3], 1, size[1] - top))
    return left, top, width, height


def _extent(samples: Any, time: Any, noise: float | None) -> tuple[int, float | None, bool]:
    unbounded = samples is None and time is None
    if samples is not None:
        samples = _check.whole("samples", samples, 1, MOST_SAMPLES)
    else:
        samples = DEFAULT_SAMPLES if time is None and noise is None else MOST_SAMPLES
    return samples, None if time is None else _check.number("time", time, 0.01, 1e7), unbounded


def _camera(scene: Scene, given: dict[str, Any], size: tuple[int, int], fov: float) -> Camera:
    asked = {name: given[name] for name in FRAMING if given.get(name) is not None}
    camera: Any = given.get("camera")
    if camera is not None:
        if not isinstance(camera, Camera):
            made_by = "lumivox.Camera.look_at(eye, target) makes one"
            raise TypeError(f"camera must be a lumivox.Camera, not {_check.shown(camera)}; {made_by}")
        if asked:
            raise ValueError(f"camera is given, and {', '.join(sorted(asked))} besides")
        return camera
    _check.number("fov", fov, 0.1, 170.0)
    target = asked.pop("target", None)
    eye = asked.pop("eye", None)
    if eye is None:
        return Camera.framing(scene, **asked, fov=fov, size=size, target=target)
    if asked:
        raise ValueError(f"eye is given, and {', '.join(sorted(asked))} besides")
    return Camera._of(scene, None, None, None, fov, size, eye, target)


def _teller(progress: RenderProgress | None) -> Callable[..., object] | None:
    if progress is None:
        return None
    return lambda *told: progress(Progress(*told))
