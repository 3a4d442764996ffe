"""A parameter study on a cluster: how much light comes out of a head, over density and mean cosine of scattering."""

import itertools

import numpy as np

import lumivox
from lumivox import cluster

scan = lumivox.phantom("head", 48)
densities, anisotropies = (0.25, 1.0), (-0.5, 0.0, 0.5)
scenes = [
    lumivox.Scene.of(scan, preset="ct-skin", density=density, anisotropy=g)
    for density, g in itertools.product(densities, anisotropies)
]
table = np.zeros(len(scenes))
# The scan is sent once, whatever the number of scenes.
for number, image in cluster.study(scenes, size=(48, 48), samples=4):
    table[number] = image.radiance.mean()
print("density, g:", anisotropies)
for density, line in zip(densities, table.reshape(len(densities), -1), strict=True):
    print(density, np.round(line, 4))
