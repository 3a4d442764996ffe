"""A film on all of this machine's GPUs: twelve frames around a head, a picture each, made where they are rendered."""

import lumivox
from lumivox import cluster

scan = lumivox.phantom("head", 48)
scene = lumivox.Scene.of(scan, preset="ct-bone")
cameras = [lumivox.Camera.framing(scene, azimuth, size=(64, 64)) for azimuth in range(0, 360, 30)]
for number, path in cluster.film(scene, cameras, save="turntable-{:03d}.png", size=(64, 64), samples=4):
    print(number, path)
