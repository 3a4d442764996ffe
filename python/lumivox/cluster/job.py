"""Work under way on a cluster: an image in parts, or many images."""

from __future__ import annotations

import contextlib
import threading
import time
import uuid
import weakref
from collections import OrderedDict
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from lumivox import _native
from lumivox.cluster import roster, worker
from lumivox.cluster.merge import Merge
from lumivox.cluster.parts import Part
from lumivox.cluster.shipping import MOST_RESIDENT, Shared, detach
from lumivox.image import Image
from lumivox.rendering import Plan, Progress

RETRIES = 5
"""How often a part is tried again whose worker or GPU fails."""

STRIKES = 2
"""Failures after which a worker gets nothing more of a job."""

LOOK = 0.01
"""Seconds between two looks for results."""

LOOK_AFTER = 5.0
"""Seconds between two looks whether those are there who may work, where not all may."""

PATIENCE = 60.0
"""Seconds for which parts wait for a worker that is started again, where those alone are left that have failed."""

_sent: weakref.WeakKeyDictionary[Any, OrderedDict[str, Any]] = weakref.WeakKeyDictionary()
"""Of each client, the volumes and maps that its workers have, the last used."""


class Cancelled(_native.LumivoxError):
    """The job was cancelled."""


@dataclass
class Figures:
    """What a job took, for those who measure."""

    parts: int = 0
    retried: int = 0
    """Parts that were given out again by this end; workers that die are made up for by Dask itself."""
    volume_bytes: int = 0
    """Of volumes and maps that each worker got, and had not had before."""
    film_bytes: int = 0
    """Of films that came back."""
    send: float = 0.0
    """Seconds of sending volumes."""
    trace: float = 0.0
    """Seconds of tracing, of all workers together."""
    busy: float = 0.0
    """Seconds in workers, scenes and films included."""
    merge: float = 0.0
    """Seconds of adding up here."""
    wall: float = 0.0
    """Seconds from the first part given out to the last one added."""
    workers: dict[str, int] = field(default_factory=dict)
    """Parts by worker."""


@dataclass(frozen=True)
class Given:
    """A task that was given out."""

    number: int
    run: Callable[..., Any]
    arguments: tuple[Any, ...]
    priority: int
    allowed: list[str] | None
    """Who may do it; ``None`` where everybody may."""


class Tasks:
    """Tasks on a cluster, each with its number; results come as they are done, lost ones are made again."""

    def __init__(self, client: Any, shared: Sequence[Shared], figures: Figures, workers: roster.Roster) -> None:
        self.client = client
        self._roster = workers
        self._strikes: dict[str, int] = {}
        self._looked = time.monotonic()
        self.job = uuid.uuid4().hex
        self.figures = figures
        self._shared = list(shared)
        self._futures: dict[Any, Given] = {}
        self._lost_since: float | None = None
        self._attempts: dict[int, int] = {}
        self._stopped = threading.Event()
        self._send()

    def _send(self) -> None:
        begin = time.perf_counter()
        known = _sent.setdefault(self.client, OrderedDict())
        missing = [one for one in self._shared if one.key not in known or known[one.key].status != "finished"]
        if missing:
            # To each worker at once, from one to the next; who comes later gets it from them with its first part.
            futures = self.client.scatter(missing, broadcast=True, hash=True, workers=self._allowed())
            known.update(zip((one.key for one in missing), futures, strict=True))
        self._data = [known[one.key] for one in self._shared]
        for one in self._shared:
            known.move_to_end(one.key)
        while len(known) > max(MOST_RESIDENT, len(self._shared)):
            known.popitem(last=False)
        self.figures.send += time.perf_counter() - begin
        self.figures.volume_bytes += sum(one.content.array.nbytes for one in missing)

    def give(self, number: int, priority: int, run: Callable[..., Any], *arguments: Any) -> Any:
        """Gives a task out."""
        key = f"lumivox-{self.job}-{number}-{self._attempts.get(number, 0)}"
        allowed = self._allowed()
        future = self.client.submit(
            worker.run,
            run,
            self.job,
            *arguments,
            *self._data,
            key=key,
            pure=False,
            priority=priority,
            workers=allowed,
        )
        self._futures[future] = Given(number, run, arguments, priority, allowed)
        return future

    def results(self) -> Iterator[Any]:
        """What comes back, in any order; raises what cannot be made up for."""
        from distributed import CancelledError, as_completed
        from distributed.scheduler import KilledWorker

        waiting = as_completed(list(self._futures), loop=self.client.loop)
        while waiting.count():
            if not waiting.has_ready():
                time.sleep(LOOK)
                self._look_after()
                continue
            future = next(waiting)
            given = self._futures.pop(future)
            try:
                result = future.result()
                why = result.why if isinstance(result, worker.Failed) else None
            except (_native.RenderError, ValueError, TypeError):
                # The scene's fault, which it has everywhere.
                raise
            except (CancelledError, KilledWorker) as error:
                if self._stopped.is_set():
                    raise Cancelled("cancelled") from None
                # The last worker that held the volumes is gone, or one part met several that died.
                result, why = None, f"its worker was lost ({error})"
            except Exception as error:
                # It did not even begin: a worker came that has no Lumivox, or another one.
                result, why = None, str(error) or type(error).__name__
            finally:
                future.release()
            if why is None:
                yield result
                continue
            if isinstance(result, worker.Failed):
                self._strikes[result.worker] = self._strikes.get(result.worker, 0) + 1
            attempts = self._attempts[given.number] = self._attempts.get(given.number, 0) + 1
            if attempts > RETRIES:
                raise _native.GpuError(f"part {given.number} was given out {attempts} times and failed each time: {why}")
            self.figures.retried += 1
            self._look()
            self._send()
            waiting.add(self.give(given.number, given.priority, given.run, *given.arguments))

    @property
    def notes(self) -> list[str]:
        """Which workers were left out, and why."""
        return self._roster.notes

    def _allowed(self) -> list[str] | None:
        """Who may work on this job; ``None`` where everybody may."""
        failed = {address for address, strikes in self._strikes.items() if strikes >= STRIKES}
        return self._roster.without(failed)

    def _look(self) -> None:
        """Looks who is there, and who of them can work. Where nobody is just now, those of before may be back soon."""
        with contextlib.suppress(_native.LumivoxError, OSError):
            self._roster = roster.look(self.client)

    def _look_after(self) -> None:
        """Gives out anew what only those may do who are gone: one that was started again has another address."""
        if time.monotonic() - self._looked < LOOK_AFTER:
            return
        self._looked = time.monotonic()
        if self._stopped.is_set() or all(given.allowed is None for given in self._futures.values()):
            return
        there = self.client.scheduler_info(n_workers=-1)["workers"]

        def is_lost(given: Given) -> bool:
            return given.allowed is not None and not any(address in there for address in given.allowed)

        # Of each by itself: who may now can have changed since it was given out.
        lost = [future for future, given in self._futures.items() if is_lost(given)]
        if not there or not lost:
            self._lost_since = None
            return
        self._lost_since = self._lost_since or self._looked
        self._look()
        allowed = self._allowed()
        fit = allowed is None or any(self._strikes.get(address, 0) < STRIKES for address in allowed if address in there)
        # Those alone that have failed get it only when nobody else comes.
        if fit or self._looked - self._lost_since > PATIENCE:
            # Each comes back as cancelled, and is given out again.
            self.client.cancel(lost, force=True)
            self._lost_since = None

    def cancel(self) -> None:
        """Takes back what is not begun, and stops what is."""
        self._stopped.set()
        futures = list(self._futures)
        self.client.run(worker.cancel, self.job, on_error="ignore")
        if futures:
            self.client.cancel(futures, force=True)

    @property
    def stopped(self) -> bool:
        """Whether it was cancelled."""
        return self._stopped.is_set()


class Job:
    """An image that a cluster renders."""

    def __init__(self, client: Any, plan: Plan, parts: list[Part], workers: roster.Roster) -> None:
        self._plan, self._parts = plan, parts
        self.figures = Figures(parts=len(parts))
        self._merge = Merge(plan.request.size, 4 if plan.request.guides else 2, parts)
        self._begin = time.perf_counter()
        self._notes: dict[str, None] = {}
        self._error: BaseException | None = None
        light, shared = detach(plan)
        self._tasks = Tasks(client, shared, self.figures, workers)
        self._traced = 0
        self._given = time.perf_counter()
        for part in parts:
            # All of the first samples come first: a look in between sees the whole image.
            self._tasks.give(part.index, -part.range, worker.run_part, light, part)
        self._thread = threading.Thread(target=self._gather, name="lumivox-cluster", daemon=True)
        self._thread.start()

    def _gather(self) -> None:
        try:
            for traced in self._tasks.results():
                if not traced.complete:
                    # Stopped in the middle: it would count for less than it says.
                    continue
                begin = time.perf_counter()
                if self._merge.add(traced.part, traced.sums):
                    self._count(traced)
                self.figures.merge += time.perf_counter() - begin
            if not self._merge.done:
                raise Cancelled("cancelled")
        except BaseException as error:
            self._error = error
        finally:
            self.figures.film_bytes = self._merge.bytes
            self.figures.wall = time.perf_counter() - self._given

    def _count(self, traced: worker.Traced) -> None:
        figures, part = self.figures, traced.part
        figures.trace += traced.trace
        figures.busy += traced.total
        figures.workers[traced.worker] = figures.workers.get(traced.worker, 0) + 1
        self._traced += part.window[2] * part.window[3] * (part.samples - part.first_sample)
        for note in traced.notes:
            self._notes.setdefault(note)

    @property
    def done(self) -> bool:
        """Whether it has ended, in whatever way."""
        return not self._thread.is_alive()

    @property
    def progress(self) -> Progress:
        """How far it is."""
        width, height = self._plan.request.size
        samples, target = self._traced / (width * height), self._plan.request.samples
        elapsed = time.perf_counter() - self._begin
        left = elapsed / samples * (target - samples) if samples > 0 else float("inf")
        return Progress(samples, target, elapsed, left, None)

    def partial(self) -> Image:
        """The image of what has come back so far; pixels that nobody has traced yet are empty."""
        return self._image(self._merge.partial(), self._merge.done)

    def cancel(self) -> None:
        """Stops it; :meth:`partial` keeps what there is."""
        self._tasks.cancel()

    def wait(self, timeout: float | None = None) -> bool:
        """Waits so many seconds at most, and says whether it has ended."""
        self._thread.join(timeout)
        return self.done

    def result(self) -> Image:
        """Waits for the image. Ctrl-C cancels the job. Raises what went wrong."""
        try:
            while not self.wait(0.1):
                pass
        except BaseException:
            self.cancel()
            raise
        if self._error is not None:
            raise self._error
        return self._image(self._merge.sums, True)

    def _image(self, sums: Any, complete: bool) -> Image:
        plan = self._plan
        film = _native.Film(sums)
        notes = (*self._tasks.notes, *self._notes)
        image = Image(film, plan.scene, plan.camera, plan.display, complete, self.figures.trace, notes)
        return image.denoised() if plan.denoise else image


class Images:
    """Many images that a cluster renders, one task each: iterate once over ``(number, image)`` as they come."""

    def __init__(self, client: Any, plans: Sequence[Plan], as_png: bool, workers: roster.Roster) -> None:
        self._plans = list(plans)
        self.figures = Figures(parts=len(self._plans))
        light, shared = [], {}
        for plan in self._plans:
            detached, heavy = detach(plan)
            light.append(detached)
            shared.update({one.key: one for one in heavy})
        self._tasks = Tasks(client, list(shared.values()), self.figures, workers)
        self._begin = time.perf_counter()
        self._as_png = as_png
        self._begun = False
        for number, plan in enumerate(light):
            self._tasks.give(number, -number, worker.run_image, replace(plan, unbounded=False), number, as_png)

    def __iter__(self) -> Iterator[tuple[int, Any]]:
        """Images, or the bytes of their PNG files, with their numbers, each once and as they come."""
        if self._begun:
            raise RuntimeError("these images were iterated over already, and are not kept: dict(images) keeps them")
        self._begun = True
        return self._each()

    def _each(self) -> Iterator[tuple[int, Any]]:
        seen = set()
        try:
            for made in self._tasks.results():
                if made.index in seen or not made.complete:
                    continue
                seen.add(made.index)
                self.figures.trace += made.trace
                self.figures.workers[made.worker] = self.figures.workers.get(made.worker, 0) + 1
                yield made.index, self._image(made)
            if len(seen) < len(self._plans):
                raise Cancelled("cancelled")
        except BaseException:
            self.cancel()
            raise
        finally:
            self.figures.wall = time.perf_counter() - self._begin

    def _image(self, made: worker.Made) -> Any:
        if made.png is not None:
            self.figures.film_bytes += len(made.png)
            return made.png
        assert made.sums is not None
        self.figures.film_bytes += made.sums.nbytes
        plan = self._plans[made.index]
        film = _native.Film(np.require(made.sums, requirements=["C", "A"]))
        notes = (*self._tasks.notes, *made.notes)
        return Image(film, plan.scene, plan.camera, plan.display, made.complete, made.trace, notes)

    def cancel(self) -> None:
        """Stops it."""
        self._tasks.cancel()
