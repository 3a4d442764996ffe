"""A cluster of this machine alone: a worker for each GPU, or for each core where there is none."""

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
from typing import Any

from lumivox import _check, rendering
from lumivox.cluster.worker import GPU_VARIABLE

START = 120.0
"""Seconds that workers may take to come up."""


def _cores() -> int:
    """The cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


class Local:
    """Workers on this machine, in processes of their own; one that dies is started again.

    They are started as programs, not forked: a script needs no ``if __name__ == "__main__"`` for it, a notebook neither.
    """

    def __init__(self, workers: int | None = None) -> None:
        from distributed import Client, LocalCluster

        hardware = [gpu.index for gpu in rendering.gpus() if gpu.unsuitable is None and not gpu.software]
        if workers is None:
            workers = len(hardware) or _cores()
        workers = _check.whole("workers", workers, 1, 1000)
        self._processes: list[subprocess.Popen[bytes]] = []
        self._folder = tempfile.mkdtemp(prefix="lumivox-cluster-")
        self._cluster: Any = LocalCluster(
            n_workers=0,
            processes=False,
            protocol="tcp",
            dashboard_address=":0",
            silence_logs=logging.ERROR,
            scheduler_port=0,
        )
        self.client: Any = Client(self._cluster, set_as_default=False)
        for number in range(workers):
            environment = dict(os.environ)
            if hardware:
                environment[GPU_VARIABLE] = str(hardware[number % len(hardware)])
            else:
                # Software Vulkan takes every core for each process, and they would be in each other's way.
                environment.setdefault("LP_NUM_THREADS", str(max(1, _cores() // workers)))
            self._processes.append(self._start(environment))
        try:
            self.client.wait_for_workers(workers, timeout=START)
        except BaseException:
            self.close()
            raise

    def _start(self, environment: dict[str, str]) -> subprocess.Popen[bytes]:
        program = [sys.executable, "-P"] if sys.version_info >= (3, 11) else [sys.executable]
        arguments = ["-m", "distributed.cli.dask_worker", self._cluster.scheduler_address, "--nthreads", "1"]
        options = ["--no-dashboard", "--memory-limit", "0", "--death-timeout", "60", "--local-directory", self._folder]
        # Of a session of its own: Ctrl-C is for whoever waits, who cancels what is under way.
        return subprocess.Popen(
            [*program, *arguments, *options],
            env=environment,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            start_new_session=True,
        )

    def close(self) -> None:
        """Ends the workers."""
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
        with contextlib.suppress(Exception):
            self._cluster.close(timeout=5)
        shutil.rmtree(self._folder, ignore_errors=True)

    def __enter__(self) -> Local:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


_default: Local | None = None


def default() -> Local:
    """This machine's cluster, which is kept until the process ends."""
    global _default
    if _default is None:
        _default = Local()
        atexit.register(_end)
    return _default


def _end() -> None:
    global _default
    if _default is not None:
        _default.close()
        _default = None
