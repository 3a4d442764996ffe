"""Who may use a cluster: a worker runs whatever it is sent, so that those it listens to must hold a key (TLS, both ways)."""

from __future__ import annotations

import ipaddress
import os
from pathlib import Path
from typing import Any

from lumivox import _check
from lumivox._check import PathLike

FOLDER_VARIABLE = "LUMIVOX_CREDENTIALS"
"""Names the folder of :func:`make_credentials` that ``tls://`` addresses are spoken to with."""

CERTIFICATE, KEY = "certificate.pem", "key.pem"

PAGE = "docs/security.md"

_told: set[str] = set()


def make_credentials(folder: PathLike) -> Path:
    """Makes the certificate and the key of a cluster in a new or empty folder that nobody else can read, and returns it.

    Scheduler, workers and clients of one cluster have the same; who has it not is not let in, and cannot listen. Copy the
    folder to the machines of the cluster by a way that nobody reads (``scp -p``). Valid for a year.
    """
    place = Path(_check.file("folder", folder))
    place.mkdir(mode=0o700, parents=True, exist_ok=True)
    if any(place.iterdir()):
        raise FileExistsError(f"{place} is not empty; name a new folder for the cluster's certificate and key")
    # A folder that was there may be open to others.
    place.chmod(0o700)
    made = _new()
    _write(place / CERTIFICATE, made.tls_ca_file)
    _write(place / KEY, made.tls_client_key)
    return place


def credentials(folder: PathLike) -> Any:
    """The ``distributed.Security`` of a folder of :func:`make_credentials`, for a ``distributed.Client`` of your own."""
    from distributed import Security

    place = Path(_check.file("folder", folder))
    for name in (CERTIFICATE, KEY):
        if not (place / name).is_file():
            raise FileNotFoundError(f"{place / name} is missing: lumivox.cluster.make_credentials({str(place)!r}) makes it")
    certificate, key = str(place / CERTIFICATE), str(place / KEY)
    roles = ("client", "scheduler", "worker")
    parts = {f"tls_{role}_{part}": path for role in roles for part, path in (("cert", certificate), ("key", key))}
    return Security(require_encryption=True, tls_ca_file=certificate, **parts)


def for_address(address: str) -> Any:
    """What an address is spoken to with: the folder that ``LUMIVOX_CREDENTIALS`` names, else what Dask's configuration says."""
    from distributed import Security

    named = os.environ.get(FOLDER_VARIABLE)
    return credentials(named) if named and address.startswith("tls://") else Security()


def say_if_open(address: str) -> None:
    """Says once of a cluster that lets everyone in who reaches it."""
    if address in _told or not address.startswith("tcp://") or _is_here(address):
        return
    _told.add(address)
    note = f"the cluster at {address} asks nobody for a key: whoever reaches it can run programs on it, and read the scans"
    _check.warn(f"{note}. Use tls:// ({PAGE} says how), or a network that only you reach")


def _is_here(address: str) -> bool:
    host = address.partition("://")[2].rpartition(":")[0].strip("[]")
    try:
        return host == "localhost" or ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


def _new() -> Any:
    from distributed import Security

    try:
        return Security.temporary()
    except ImportError as error:
        raise ImportError("a cluster's key is made by cryptography: pip install 'lumivox[cluster]'") from error


def _write(path: Path, text: str) -> None:
    with open(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "w") as file:
        file.write(text)
