"""Renders on a cluster, through Dask: on this machine's GPUs unless told otherwise.

    from lumivox import cluster

    image = cluster.render(scan, preset="ct-bone", samples=4096)

``cluster=`` takes the address of a Dask scheduler (``"tls://head:8786"``), a ``distributed.Client``, or anything that a
client connects to (dask-jobqueue on SLURM, dask-kubernetes, Coiled). Workers need ``pip install lumivox[cluster]``, and one
thread each; each takes a GPU of its machine that no other has, or the one that ``LUMIVOX_GPU`` names.

A worker runs what it is sent. This machine's cluster listens to this process alone; another one should ask for a key
(:func:`make_credentials`): ``tls://`` addresses are spoken to with the folder that ``LUMIVOX_CREDENTIALS`` names, or as Dask's
configuration says. Of a ``tcp://`` address beyond this machine a warning says that it asks for none.
"""

from __future__ import annotations

import asyncio
import os
import re
import sys
import weakref
from collections.abc import Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from typing import Any

try:
    import distributed
except ImportError as error:
    raise ImportError("lumivox.cluster needs Dask: pip install 'lumivox[cluster]'") from error

from lumivox import _check
from lumivox._check import PathLike
from lumivox.cluster import local as local_module
from lumivox.cluster import parts as splitting
from lumivox.cluster import security
from lumivox.cluster.job import Cancelled, Figures, Images, Job
from lumivox.cluster.local import Local, default
from lumivox.cluster.roster import Roster, look
from lumivox.cluster.security import credentials, make_credentials
from lumivox.image import Image
from lumivox.rendering import Options, Plan, RenderProgress, plan, with_options
from lumivox.scene import Camera, Scene
from lumivox.volume import Volume

if sys.version_info >= (3, 11):
    from typing import Unpack
else:
    from typing_extensions import Unpack

__all__ = [
    "Cancelled",
    "Figures",
    "Images",
    "Job",
    "Local",
    "credentials",
    "film",
    "make_credentials",
    "render",
    "study",
    "submit",
    "workers",
]

Target = Any
"""``None`` or ``"local"``, an address, a ``distributed.Client``, a :class:`Local`, or a Dask cluster."""

CONNECT = 10.0
"""Seconds that a scheduler may take to answer."""

_clients: dict[str, Any] = {}
_of_clusters: weakref.WeakKeyDictionary[Any, Any] = weakref.WeakKeyDictionary()


_of_the_parent: list[Any] = []
"""What a process that was forked must not even let go of: to close it would wait for threads that are not there."""


def _forget() -> None:
    """In a process that was forked: clients are the parent's."""
    global _clients, _of_clusters
    _of_the_parent.append((_clients, _of_clusters, local_module.forget()))
    _clients, _of_clusters = {}, weakref.WeakKeyDictionary()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_forget)


def client_of(cluster: Target) -> Any:
    """The client for what was named as a cluster."""
    if cluster is None or cluster == "local":
        return default().client
    if isinstance(cluster, Local):
        return cluster.client
    if isinstance(cluster, distributed.Client):
        if cluster.status != "running":
            raise ConnectionError(f"the cluster's client is {cluster.status}: make another")
        security.say_if_open(cluster.scheduler.address)
        return cluster
    how = "the address of a Dask scheduler, such as tls://HOST:8786, a distributed.Client, or 'local' for this machine"
    if isinstance(cluster, str):
        if not re.search(r"://.|.:\d+$", cluster):
            raise ValueError(f"cluster {cluster!r} is not {how}")
        return _kept(_clients, cluster)
    if not isinstance(getattr(cluster, "scheduler_address", None), str):
        raise TypeError(f"cluster must be {how}, not {_check.shown(cluster)}")
    return _kept(_of_clusters, cluster)


def _kept(clients: Any, cluster: Any) -> Any:
    """The one client for an address or a cluster of Dask's."""
    known = clients.get(cluster)
    if known is None or known.status != "running":
        known = clients[cluster] = _connect(cluster)
    return known


def _connect(cluster: Any) -> Any:
    try:
        if not isinstance(cluster, str):
            client = distributed.Client(cluster, set_as_default=False, timeout=CONNECT)
        else:
            keys = security.for_address(cluster)
            _answers(cluster, keys)
            client = distributed.Client(cluster, set_as_default=False, timeout=CONNECT, security=keys)
    except FileNotFoundError:
        raise
    except (OSError, ValueError, RuntimeError, TypeError) as error:
        key = "" if not str(cluster).startswith("tls://") else f" ({security.FOLDER_VARIABLE} names the folder of its key)"
        raise ConnectionError(f"no Dask scheduler answers at {cluster}{key}: {error}") from error
    security.say_if_open(client.scheduler.address)
    return client


def _answers(address: str, keys: Any) -> None:
    """Raises where nobody answers. A client that finds nobody leaves a thread behind, so none is made before."""
    from distributed.comm import connect

    async def ask() -> None:
        comm = await connect(address, timeout=CONNECT, **keys.get_connection_args("client"))
        await comm.close()

    # In a thread of its own: notebooks have a loop running in this one.
    with ThreadPoolExecutor(1) as thread:
        thread.submit(asyncio.run, ask()).result()


def workers(cluster: Target = None) -> dict[str, dict[str, Any]]:
    """The workers that can render, by address: the GPU of each, whether it is in software, its process, its version.

    Others get nothing to do: those without a GPU, without Lumivox or with another version. Images say which in their notes.
    """
    return look(client_of(cluster)).usable


@with_options
def submit(
    scan: Scene | Volume | Sequence[Volume],
    *,
    cluster: Target = None,
    tiles: int | None = None,
    ranges: int | None = None,
    **options: Unpack[Options],
) -> Job:
    """Begins an image, split into ``tiles`` (bands of rows) times ``ranges`` (of samples); see :func:`render`."""
    _own(options)
    client = client_of(cluster)
    return _submit(client, _planned(plan(scan, options)), tiles, ranges)


@with_options
def render(
    scan: Scene | Volume | Sequence[Volume],
    *,
    cluster: Target = None,
    tiles: int | None = None,
    ranges: int | None = None,
    **options: Unpack[Options],
) -> Image:
    """Renders one image on a cluster; options are those of :func:`lumivox.render`, but for ``time`` and ``gpu``.

    - ``tiles``: bands of rows that it is split into. Default: large ones first, small ones at the end, so that none is
      waited for; of 1,048,576 pixels at least on a GPU.
    - ``ranges``: ranges of samples. Default: 1, or more where there are too few tiles for all workers. More of them show
      the whole image earlier (:meth:`Job.partial`), and take a film's bytes each.
    - ``pass_samples``: samples of a pixel that are added up before its film is. Default: 64, in software 4.
    - ``progress``: is told how far it is, a few times a second; ``False`` from it cancels.

    The image is that of ``lumivox.render(..., pass_samples=...)`` on one such GPU, to the last bit with one range, or with
    ranges of one pass each; with others it differs in the rounding of 32-bit sums. It never depends on how many workers
    there are, nor on which died.
    """
    job = submit(scan, cluster=cluster, tiles=tiles, ranges=ranges, **options)
    return watched(job, options.get("progress"))


def watched(job: Job, progress: RenderProgress | None) -> Image:
    """Waits for a job, and tells how far it is."""
    try:
        while progress is not None and not job.wait(0.2):
            if progress(job.progress) is False:
                job.cancel()
                break
    except BaseException:
        job.cancel()
        raise
    return job.result()


@with_options
def film(
    scan: Scene | Volume | Sequence[Volume],
    cameras: Iterable[Camera],
    *,
    cluster: Target = None,
    save: str | PathLike | None = None,
    **options: Unpack[Options],
) -> Images:
    """Renders a film, a frame for each camera: iterate over ``(number, image)`` as they come.

    ``save``: a file for each frame, such as ``"frame-{:04d}.png"``; workers make the pictures, and only those come back:
    it then gives ``(number, path)``.
    """
    _own(options)
    if not isinstance(cameras, Iterable):
        raise TypeError(f"cameras must be several lumivox.Camera, one for each frame, not {_check.shown(cameras)}")
    client = client_of(cluster)
    first: Plan | None = None
    plans = []
    for camera in cameras:
        if not isinstance(camera, Camera):
            raise TypeError(f"cameras must be lumivox.Camera, one for each frame, not {_check.shown(camera)}")
        if first is None:
            # The scene is looked at once, not for each frame.
            first = _planned(plan(scan, {**options, "camera": camera}))
        plans.append(replace(first, camera=camera))
    return _images(client, plans, save)


@with_options
def study(
    scenes: Iterable[Scene | Plan],
    *,
    cluster: Target = None,
    save: str | PathLike | None = None,
    **options: Unpack[Options],
) -> Images:
    """Renders one image of each scene, such as of one scan under many looks: iterate over ``(number, image)`` as they come.

    Volumes that scenes share are sent once. Without a ``camera``, each scene is framed by itself.
    """
    _own(options)
    if isinstance(scenes, Scene | Volume) or not isinstance(scenes, Iterable):
        raise TypeError(f"scenes must be several lumivox.Scene, not {_check.shown(scenes)}")
    client = client_of(cluster)
    plans = [scene if isinstance(scene, Plan) else _planned(plan(scene, options)) for scene in scenes]
    return _images(client, plans, save)


class _Saved(Images):
    """Images that are written as they come."""

    pattern: str = ""

    def _each(self) -> Any:
        for number, png in super()._each():
            path = self.pattern.format(number)
            with open(path, "wb") as file:
                file.write(png)
            yield number, path


def _images(client: Any, plans: list[Plan], save: str | PathLike | None) -> Images:
    there = look(client)
    plans = [_with_pass(one, there) for one in plans]
    if save is None:
        return Images(client, plans, False, there)
    pattern = _check.file("save", save)
    needed = f"{pattern}: a name for each frame is needed, such as frame-{{:04d}}.png"
    try:
        first, second = pattern.format(0), pattern.format(1)
    except (IndexError, KeyError, ValueError):
        raise ValueError(needed) from None
    if not pattern.lower().endswith(".png") or first == second:
        raise ValueError(needed)
    _check.writable(first)
    saved = _Saved(client, plans, True, there)
    saved.pattern = pattern
    return saved


def _own(options: Options) -> None:
    """Options that are for one machine are told."""
    if options.get("gpu") is not None:
        raise ValueError("gpu is for one machine; workers take their own, or the one that LUMIVOX_GPU names")
    for name in ("region", "first_sample"):
        if options.get(name):
            raise ValueError(f"{name} is for one machine; a cluster splits images by itself")


def _planned(planned: Plan) -> Plan:
    if planned.request.time is not None:
        raise ValueError("time is for one machine; give samples, and cancel what takes too long")
    return replace(planned, unbounded=False)


def _with_pass(planned: Plan, workers: Roster) -> Plan:
    """A plan with passes that suit the slowest of the workers: all must have the same."""
    if planned.request.pass_samples is not None:
        return planned
    samples = splitting.PASS_OF_SOFTWARE if workers.software else splitting.PASS_OF_GPU
    return replace(planned, request=replace(planned.request, pass_samples=samples))


def _submit(client: Any, planned: Plan, tiles: int | None, ranges: int | None) -> Job:
    there = look(client)
    planned = _with_pass(planned, there)
    request = planned.request
    assert request.pass_samples is not None
    for name, value in (("tiles", tiles), ("ranges", ranges)):
        if value is not None:
            _check.whole(name, value, 1, 1 << 24)
    count = len(there.usable)
    if tiles is None:
        heights = splitting.usual_tiles(request.size, count, there.software)
    else:
        heights = splitting.equal_tiles(request.size, tiles)
    if ranges is None:
        ranges = splitting.usual_ranges(len(heights), count)
    split = splitting.split(request.size, request.samples, heights, ranges, request.pass_samples)
    return Job(client, planned, split, there)
