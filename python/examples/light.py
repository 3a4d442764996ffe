"""One scan in three lights: the studio, a sky with a sun, a lamp beside the face."""

import lumivox

scan = lumivox.phantom("head", 64)
sky = lumivox.Environment("gradient", strength=0.5)
lights = {
    "studio": {"environment": "studio"},
    "sun": {"environment": sky, "light": lumivox.Sun(azimuth=60, elevation=30, strength=2)},
    "lamp": {
        "environment": lumivox.Environment("uniform", strength=0.05),
        "light": lumivox.PointLight(position=(250, 50, 250), intensity=(0.5, 0.4, 0.3), radius=30),
    },
}
scene = lumivox.Scene.of(scan, preset="ct-skin")
camera = lumivox.Camera.framing(scene, azimuth=25)
for name, light in lights.items():
    image = lumivox.render(scan, preset="ct-skin", camera=camera, size=(96, 96), samples=8, denoise=True, **light)
    image.save(f"light-{name}.png")
