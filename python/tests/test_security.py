"""Who reaches a cluster: nobody but this process, unless somebody was given the key."""

from __future__ import annotations

import asyncio
import os
import stat
import subprocess
import sys
import threading
import warnings
from collections.abc import Iterator
from pathlib import Path

import psutil
import pytest

from lumivox import cluster
from lumivox.cluster import local as of_this_machine
from lumivox.cluster import security, worker


@pytest.fixture(scope="module")
def local() -> Iterator[cluster.Local]:
    """A cluster of one worker."""
    with cluster.Local(1) as one:
        yield one


def listening(process: psutil.Process) -> set[str]:
    """The addresses that a process and its children listen on."""
    every = [process, *process.children(recursive=True)]
    found = [one.net_connections("inet") for one in every]
    return {use.laddr.ip for uses in found for use in uses if use.status == psutil.CONN_LISTEN}


def speak(address: str, keys: object) -> None:
    """Connects to a scheduler or a worker, and asks who it is."""
    from distributed.comm import connect

    async def ask() -> None:
        comm = await connect(address, timeout=3, **keys.get_connection_args("client"))  # type: ignore[attr-defined]
        try:
            await comm.write({"op": "identity", "reply": True})
            await comm.read()
        finally:
            await comm.close()

    asyncio.run(ask())


def test_this_machines_cluster_listens_to_this_machine_only(local: cluster.Local) -> None:
    assert listening(psutil.Process()) == {"127.0.0.1"}


def test_no_page_tells_what_it_does(local: cluster.Local) -> None:
    import http.client

    def answers(port: int) -> int:
        link = http.client.HTTPConnection("127.0.0.1", port, timeout=3)
        try:
            link.request("GET", "/info/main/workers.html")
            return link.getresponse().status
        except (OSError, http.client.HTTPException):
            return 0
        finally:
            link.close()

    every = [psutil.Process(), *psutil.Process().children(recursive=True)]
    ports = {use.laddr.port for one in every for use in one.net_connections("inet") if use.status == psutil.CONN_LISTEN}
    assert ports and not {port for port in ports if answers(port) not in (0, 404)}


def test_whoever_has_not_the_key_is_not_let_in(local: cluster.Local, tmp_path: Path) -> None:
    from distributed import Security

    addresses = [local.client.scheduler.address, *local.client.scheduler_info(n_workers=-1)["workers"]]
    assert len(addresses) == 2
    other = security.credentials(security.make_credentials(tmp_path / "other"))
    for address in addresses:
        speak(address, security.credentials(local.credentials))
        with pytest.raises(OSError):
            speak(address.replace("tls://", "tcp://"), Security())
        with pytest.raises(OSError):
            speak(address, other)


def test_the_key_is_its_owners_alone_and_goes_with_the_cluster(tmp_path: Path) -> None:
    place = cluster.make_credentials(tmp_path / "keys")
    assert stat.S_IMODE(place.stat().st_mode) == 0o700
    assert {stat.S_IMODE(file.stat().st_mode) for file in place.iterdir()} == {0o600}
    with pytest.raises(FileExistsError, match="is not empty"):
        cluster.make_credentials(place)
    with pytest.raises(FileNotFoundError, match="make_credentials"):
        cluster.credentials(tmp_path)
    folder = of_this_machine.Folder()
    assert stat.S_IMODE(folder.path.stat().st_mode) == 0o700
    folder.remove()
    assert not folder.path.exists()


def test_folders_of_processes_that_were_killed_go_with_the_next(
    python: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    monkeypatch.setattr(of_this_machine.tempfile, "tempdir", None)
    killed = "import os; from lumivox.cluster import local; folder = local.Folder(); os.kill(os.getpid(), 9)"
    flags = ["-P"] if sys.version_info >= (3, 11) else []
    subprocess.run([python, *flags, "-c", killed], check=False, timeout=60)
    (left,) = tmp_path.iterdir()
    mine = of_this_machine.Folder()
    another = of_this_machine.Folder()
    assert not left.exists() and mine.path.exists() and another.path.exists()
    for folder in (mine, another):
        folder.remove()
    monkeypatch.setattr(of_this_machine.tempfile, "tempdir", None)


def test_threads_share_the_machines_one_cluster(monkeypatch: pytest.MonkeyPatch) -> None:
    made = []

    class Slow:
        def __init__(self) -> None:
            made.append(self)
            threading.Event().wait(0.2)

        def close(self) -> None:
            made.remove(self)

    monkeypatch.setattr(of_this_machine, "Local", Slow)
    monkeypatch.setattr(of_this_machine, "_default", None)
    threads = [threading.Thread(target=of_this_machine.default) for _ in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(made) == 1
    of_this_machine.end()
    assert not made


def test_an_open_cluster_beyond_this_machine_is_warned_of_once() -> None:
    with pytest.warns(UserWarning, match="asks nobody for a key"):
        security.say_if_open("tcp://192.0.2.7:8786")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for address in (
            "tcp://192.0.2.7:8786",
            "tls://192.0.2.8:8786",
            "tcp://127.0.0.1:8786",
            "tcp://[::1]:8786",
            "inproc://a/b",
        ):
            security.say_if_open(address)


def test_a_claim_of_a_gpu_follows_no_link_that_others_laid(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(worker.tempfile, "gettempdir", lambda: str(tmp_path))
    precious = tmp_path / "precious"
    precious.write_text("kept")
    (tmp_path / f"lumivox-{os.getuid()}-gpu-0.lock").symlink_to(precious)
    assert not worker.Claim.__new__(worker.Claim)._lock(0)
    assert precious.read_text() == "kept"
