"""A cluster of this machine alone: a worker for each GPU, or for each core where there is none.

It listens on 127.0.0.1 only, and to those alone who have the key in its folder, which only this user can read: other users
of this machine reach 127.0.0.1, too, and a worker runs what it is sent.
"""

from __future__ import annotations

import atexit
import contextlib
import logging
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
from pathlib import Path
from typing import IO, Any

from lumivox import _check, rendering
from lumivox.cluster import security
from lumivox.cluster.worker import GPU_VARIABLE

START = 120.0
"""Seconds that workers may take to come up."""

HERE = "127.0.0.1"
"""Where it listens."""

PREFIX = "lumivox-cluster-"
"""What its folder among the temporary ones begins with."""


def _cores() -> int:
    """The cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


class Folder:
    """A folder for the key and for what workers write, which only this user can read. It goes with its process: at the end,
    or, where that was killed, when the next is made."""

    def __init__(self) -> None:
        _sweep()
        self.path = Path(tempfile.mkdtemp(prefix=PREFIX))
        # Held as long as the process lives, however it ends.
        self._lock: IO[bytes] | None = (self.path / "lock").open("wb")
        _try_lock(self._lock)

    def remove(self) -> None:
        """Takes it away."""
        if self._lock is not None:
            self._lock.close()
            self._lock = None
        shutil.rmtree(self.path, ignore_errors=True)


def _try_lock(file: IO[bytes]) -> bool:
    try:
        import fcntl
    except ImportError:
        return False
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        return False
    return True


def _sweep() -> None:
    """Takes folders away whose processes are gone."""
    if not hasattr(os, "getuid"):
        return
    for place in Path(tempfile.gettempdir()).glob(f"{PREFIX}*"):
        lock = place / "lock"
        # A link, or a folder of another user's, is none of ours.
        if place.is_symlink() or lock.is_symlink() or not os.access(lock, os.W_OK):
            continue
        with contextlib.suppress(OSError), lock.open("rb") as file:
            if place.stat().st_uid == os.getuid() and _try_lock(file):
                shutil.rmtree(place, ignore_errors=True)


class Local:
    """Workers on this machine, in processes of their own; one that dies is started again.

    They are started as programs, not forked: a script needs no ``if __name__ == "__main__"`` for it, a notebook neither. All
    of it listens on 127.0.0.1 alone, without a dashboard, and to nobody who has not the key that it makes.
    """

    def __init__(self, workers: int | None = None) -> None:
        from distributed import Client, LocalCluster

        hardware = [gpu.index for gpu in rendering.gpus() if gpu.unsuitable is None and not gpu.software]
        if workers is None:
            workers = len(hardware) or _cores()
        workers = _check.whole("workers", workers, 1, 1000)
        self._processes: list[subprocess.Popen[bytes]] = []
        self._cluster: Any = None
        self.client: Any = None
        self._folder = Folder()
        try:
            self.credentials = security.make_credentials(self._folder.path / "credentials")
            """The folder of its certificate and key, for programs that ``LUMIVOX_CREDENTIALS`` names it to."""
            keys = security.credentials(self.credentials)
            with _without_pages():
                self._cluster = LocalCluster(
                    n_workers=0,
                    processes=False,
                    protocol="tls",
                    host=HERE,
                    security=keys,
                    dashboard_address=None,
                    # What Dask calls so answers even without a dashboard, on a port of its own.
                    scheduler_kwargs={"dashboard": False, "dashboard_address": f"{HERE}:0"},
                    silence_logs=logging.ERROR,
                    scheduler_port=0,
                )
            self.client = Client(self._cluster, set_as_default=False, security=keys)
            for number in range(workers):
                environment = dict(os.environ)
                if hardware:
                    environment[GPU_VARIABLE] = str(hardware[number % len(hardware)])
                else:
                    # Software Vulkan takes every core for each process, and they would be in each other's way.
                    environment.setdefault("LP_NUM_THREADS", str(max(1, _cores() // workers)))
                self._processes.append(self._start(environment))
            self.client.wait_for_workers(workers, timeout=START)
        except BaseException:
            self.close()
            raise

    def _start(self, environment: dict[str, str]) -> subprocess.Popen[bytes]:
        program = [sys.executable, "-P"] if sys.version_info >= (3, 11) else [sys.executable]
        arguments = ["-m", "distributed.cli.dask_worker", self._cluster.scheduler_address, "--nthreads", "1"]
        certificate, key = (str(self.credentials / name) for name in (security.CERTIFICATE, security.KEY))
        # Without --host it would listen to the whole network.
        options = ["--host", HERE, "--protocol", "tls", "--tls-ca-file", certificate, "--tls-cert", certificate, "--tls-key", key]
        options += ["--no-dashboard", "--dashboard-address", f"{HERE}:0", "--memory-limit", "0", "--death-timeout", "60"]
        options += ["--local-directory", str(self._folder.path)]
        # Of a session of its own: Ctrl-C is for whoever waits, who cancels what is under way.
        return subprocess.Popen(
            [*program, *arguments, *options],
            env={**environment, **NO_PAGES},
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            start_new_session=True,
        )

    def close(self) -> None:
        """Ends the workers."""
        if self.client is not None:
            with contextlib.suppress(Exception):
                self.client.close(timeout=5)
        for process in self._processes:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGTERM)
        for process in self._processes:
            try:
                process.wait(5)
            except subprocess.TimeoutExpired:
                with contextlib.suppress(ProcessLookupError):
                    os.killpg(process.pid, signal.SIGKILL)
                process.wait()
        self._processes = []
        if self._cluster is not None:
            with contextlib.suppress(Exception):
                self._cluster.close(timeout=5)
        self._folder.remove()

    def __enter__(self) -> Local:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


NO_PAGES = {"DASK_DISTRIBUTED__WORKER__HTTP__ROUTES": "[]"}
"""Workers' environment: no pages about what they do."""


def _without_pages() -> Any:
    """Dask's configuration for a scheduler without pages about what it does."""
    import dask

    return dask.config.set({"distributed.scheduler.http.routes": []})


_default: Local | None = None
_making = threading.Lock()


def default() -> Local:
    """This machine's cluster, which is kept until the process ends: one, whoever asks first."""
    global _default
    with _making:
        if _default is None:
            _default = Local()
            atexit.register(end)
        return _default


def forget() -> Local | None:
    """In a process that was forked: the cluster is the parent's, and no lock is held by a thread that is not here."""
    global _default, _making
    parents, _default, _making = _default, None, threading.Lock()
    return parents


def end() -> None:
    """Ends this machine's cluster."""
    global _default
    with _making:
        if _default is not None:
            _default.close()
            _default = None
