"""Which workers can do what is asked of them: those that have this version of Lumivox, and a GPU."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any

from lumivox import _native
from lumivox.cluster import worker

NOT_THERE = re.compile(r"\b(ModuleNotFoundError|ImportError|AttributeError)\b")
"""What a worker says that does not know what it is asked: Dask hands on some errors as words alone."""


@dataclass(frozen=True)
class Roster:
    """The workers of a cluster, by address."""

    usable: dict[str, dict[str, Any]]
    """What each says of itself."""
    left_out: dict[str, str]
    """Why each gets nothing to do."""

    @property
    def software(self) -> bool:
        """Whether some have no GPU but software."""
        return any(one["software"] for one in self.usable.values())

    @property
    def notes(self) -> list[str]:
        """Who was left out, and why."""
        return [f"worker {address} was left out: {why}" for address, why in sorted(self.left_out.items())]

    def without(self, addresses: set[str]) -> list[str] | None:
        """Those who may work, but for some; ``None`` where all may, and whoever joins. Where none would be left, all usable
        ones may."""
        kept = [address for address in self.usable if address not in addresses]
        if len(kept) == len(self.usable) and not self.left_out:
            return None
        return kept or list(self.usable)


def look(client: Any) -> Roster:
    """Asks each worker of a cluster what it is. Raises where none can work."""
    answers: dict[str, Any] = client.run(worker.describe, on_error="return")
    if not answers:
        raise ConnectionError("the cluster has no workers")
    usable, left_out = {}, {}
    for address, said in answers.items():
        if why := _unfit(said):
            left_out[address] = why
        else:
            usable[address] = said
    if not usable:
        kind = _native.GpuError if any(isinstance(said, _native.GpuError) for said in answers.values()) else _native.LumivoxError
        raise kind("no worker can render: " + "; ".join(f"{address}: {why}" for address, why in sorted(left_out.items())))
    return Roster(usable, left_out)


def _unfit(said: Any) -> str | None:
    """Why a worker cannot work, if it cannot."""
    if isinstance(said, BaseException) and NOT_THERE.search(repr(said)):
        return (
            f"it has no Lumivox of this version ({said}); install it there: pip install 'lumivox[cluster]=={_native.__version__}'"
        )
    if isinstance(said, BaseException):
        return str(said) or type(said).__name__
    if (there := said.get("version", "an older one")) != _native.__version__:
        return f"it has Lumivox {there}, and this is {_native.__version__}; install the same version on both"
    return None
