"""What an image is split into: windows of pixels, and ranges of samples.

Random numbers are a function of pixel and sample, so that whoever traces a part traces what the whole image would have
had there. Sums are of 32 bits, in which order counts: within a pixel, samples are added up in passes of a fixed number,
and passes in order. A part that is **one** pass, or has all passes of its pixels, therefore adds up to the single machine's
film to the last bit; ranges of several passes differ from it by rounding, and by nothing else.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

PASS_OF_GPU = 64
"""Samples of a pass: what keeps a GPU's lanes busy."""

PASS_OF_SOFTWARE = 4
"""Of a device in software, whose dispatches take long."""

LEAST_TILE = 1 << 20
"""Pixels of a tile at least, on a GPU: fewer keep no large one busy (benches/history.md, 'A cluster')."""

SHARE = 3
"""The first tile is as large as what this many times as many workers would have each."""


@dataclass(frozen=True)
class Part:
    """A part of an image: pixels of a window, samples of a range."""

    index: int
    tile: int
    """Which window, in reading order."""
    range: int
    """Which range, from the first samples on."""
    window: tuple[int, int, int, int]
    """Left column, top row, width, height."""
    first_sample: int
    samples: int
    """The sample after its last."""


def split(size: tuple[int, int], samples: int, heights: list[int], ranges: int, pass_samples: int) -> list[Part]:
    """All parts of an image, those of the first samples first.

    Tiles are bands of rows, ``heights`` of them. Ranges are whole passes, as equal as they can be; there are no more of
    them than passes.
    """
    width = size[0]
    passes = math.ceil(samples / pass_samples)
    ranges = max(1, min(ranges, passes))
    ends = [min(samples, passes * i // ranges * pass_samples) for i in range(ranges + 1)]
    parts: list[Part] = []
    for number in range(ranges):
        top = 0
        for tile, height in enumerate(heights):
            window = (0, top, width, height)
            parts.append(Part(len(parts), tile, number, window, ends[number], ends[number + 1]))
            top += height
    return parts


def equal_tiles(size: tuple[int, int], tiles: int) -> list[int]:
    """The heights of so many tiles, one row each at least."""
    height = size[1]
    tiles = max(1, min(tiles, height))
    rows = [height * tile // tiles for tile in range(tiles + 1)]
    return [end - begin for begin, end in itertools.pairwise(rows)]


def usual_tiles(size: tuple[int, int], workers: int, software: bool) -> list[int]:
    """The heights of the tiles of an image unless asked otherwise: large ones first, small ones at the end.

    How long a tile takes is not known before, and who has the last one is waited for: that is a small one. Each is a share
    of the rows that are left (guided self-scheduling: Polychronopoulos and Kuck, 1987).
    """
    width, left = size
    least = 1 if software else max(1, math.ceil(LEAST_TILE / width))
    heights = []
    while left > 0:
        rows = min(left, max(least, math.ceil(left / (SHARE * workers))))
        # The last two are of one size: neither is waited for long.
        rows = math.ceil(left / 2) if least < left <= 2 * least else rows
        heights.append(rows)
        left -= rows
    return heights


def usual_ranges(tiles: int, workers: int) -> int:
    """How many ranges of samples there are unless asked otherwise: 1, or more where tiles alone leave workers idle.

    Twice as many parts as of tiles alone: they are all of one size, and who has the last one is waited for.
    """
    return 1 if tiles >= SHARE * workers or workers == 1 else math.ceil(2 * SHARE * workers / tiles)
