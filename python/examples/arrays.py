"""numpy in, numpy out: a volume of an array, a look of its own, and the layers of light that come back."""

import numpy as np

import lumivox

# A ball of 40 mm that gets denser inwards; axes z, y, x, values in HU.
z, y, x = np.mgrid[-1:1:48j, -1:1:48j, -1:1:48j]
radius = np.sqrt(x**2 + y**2 + z**2)
hu = np.where(radius < 0.9, 1200 * (1 - radius), -1000).astype(np.int16)
volume = lumivox.Volume.from_array(hu, spacing=(1, 1, 1), modality="CT")
assert volume.array.base is not None, "a view: nothing is copied on the way back"

look = lumivox.TransferFunction(
    opacity=[(100, 0.0), (300, 0.05), (900, 1.0)],
    color=[(100, (0.9, 0.5, 0.2)), (900, (1.0, 0.95, 0.85))],
)
image = lumivox.render(volume, transfer_function=look, density=2, environment="gradient", size=(96, 96), samples=16, layers=True)
print("radiance", image.radiance.shape, "alpha up to", image.alpha.max())
print("nearest", image.depth.min(), "mm; standard error up to", np.sqrt(image.variance.max()))
image.save("arrays.exr")
