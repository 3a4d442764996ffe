"""An image of the films of its parts: each counts once, in an order that does not depend on who was first."""

from __future__ import annotations

import threading

import numpy as np
import numpy.typing as npt

from lumivox.cluster.parts import Part

Sums = npt.NDArray[np.float32]


class Merge:
    """Sums (planes, rows, columns, 4) of an image, as parts come in, in any order.

    Parts of one tile are added in the order of their ranges: those that come early wait. So the sums are the same to the
    last bit, whichever worker did what, and whichever died meanwhile.
    """

    def __init__(self, size: tuple[int, int], planes: int, parts: list[Part]) -> None:
        width, height = size
        self.sums: Sums = np.zeros((planes, height, width, 4), np.float32)
        self.bytes = 0
        """Bytes of films that came in."""
        self.seconds = 0.0
        """Time spent adding."""
        self._next: dict[int, int] = {part.tile: 0 for part in parts}
        self._waiting: dict[tuple[int, int], tuple[Part, Sums]] = {}
        self._seen: set[int] = set()
        self._lock = threading.Lock()
        self._count = len(parts)

    def add(self, part: Part, sums: Sums) -> bool:
        """Takes the film of a part; ``False``, and nothing, where it was there already."""
        with self._lock:
            if part.index in self._seen:
                return False
            _, _, width, height = part.window
            if sums.shape != (self.sums.shape[0], height, width, 4):
                raise ValueError(f"part {part.index} has sums of shape {sums.shape}")
            self._seen.add(part.index)
            self.bytes += sums.nbytes
            self._waiting[part.tile, part.range] = (part, sums)
            while (there := self._waiting.pop((part.tile, self._next[part.tile]), None)) is not None:
                self._into(self.sums, *there)
                self._next[part.tile] += 1
            return True

    @property
    def done(self) -> bool:
        """Whether every part is there."""
        with self._lock:
            return len(self._seen) == self._count

    def partial(self) -> Sums:
        """The sums of all parts that are there, those that wait, too: a copy."""
        with self._lock:
            sums = self.sums.copy()
            for part, more in self._waiting.values():
                self._into(sums, part, more)
            return sums

    @staticmethod
    def _into(sums: Sums, part: Part, more: Sums) -> None:
        x, y, width, height = part.window
        sums[:, y : y + height, x : x + width] += more
