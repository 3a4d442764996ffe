"""What an image is split into: windows of pixels, and ranges of samples.

Random numbers are a function of pixel and sample, so that whoever traces a part traces what the whole image would have
had there. Sums are of 32 bits, in which order counts: within a pixel, samples are added up in passes of a fixed number,
and passes in order. A part that is **one** pass, or has all passes of its pixels, therefore adds up to the single machine's
film to the last bit; ranges of several passes differ from it by rounding, and by nothing else.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

PASS_OF_GPU = 64
"""Samples of a pass: what keeps a GPU's lanes busy."""

PASS_OF_SOFTWARE = 4
"""Of a device in software, whose dispatches take long."""

LEAST_TILE = 1 << 17
"""Pixels of a tile at least, where there are so many: fewer keep no large GPU busy."""

PARTS_OF_WORKER = 4
"""Tiles for each worker: the last one to finish is then late by a fraction of its work."""


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


def split(size: tuple[int, int], samples: int, tiles: int, ranges: int, pass_samples: int) -> list[Part]:
    """All parts of an image, those of the first samples first.

    Ranges are whole passes, as equal as they can be; there are no more of them than passes. Tiles are bands of rows.
    """
    width, height = size
    tiles = max(1, min(tiles, height))
    passes = math.ceil(samples / pass_samples)
    ranges = max(1, min(ranges, passes))
    rows = [height * tile // tiles for tile in range(tiles + 1)]
    ends = [min(samples, passes * i // ranges * pass_samples) for i in range(ranges + 1)]
    parts: list[Part] = []
    for number in range(ranges):
        for tile in range(tiles):
            window = (0, rows[tile], width, rows[tile + 1] - rows[tile])
            parts.append(Part(len(parts), tile, number, window, ends[number], ends[number + 1]))
    return parts


def usual_tiles(size: tuple[int, int], workers: int) -> int:
    """How many tiles an image is split into unless asked otherwise; one worker, too, has several, for a look in between."""
    pixels = size[0] * size[1]
    # So many that each worker has some, and no smaller than keeps it busy, unless workers had none then.
    return max(min(PARTS_OF_WORKER * workers, pixels // LEAST_TILE), workers, 1)
