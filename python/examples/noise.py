"""How fast noise goes: four times the samples halve it, as a progressive render shows."""

import lumivox

scan = lumivox.phantom("head", 48)
for image in lumivox.progressive(scan, preset="ct-skin", size=(64, 64), samples=32):
    # Before the second sample, nothing is known of it.
    if image.noise is not None:
        print(f"{image.min_samples:4} samples: noise {image.noise:.1%}")
