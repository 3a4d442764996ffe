"""A chest cut open: its parts by name, each with a look of its own, and a plane that slides through it."""

from dataclasses import replace

import lumivox

scan = lumivox.phantom("torso", 96).patient_alone()
# What is found in a CT by itself; lumivox.load_labels(path) reads a segmentation.
styles = {"body": "opacity:0.4", "lungs": "hide", "airways": lumivox.LabelStyle(color="#c04030")}
plane = lumivox.ClipShape.plane((0, 0, 40), (0, 0, -1))
scene = lumivox.Scene.of(scan, preset="ct-muscle", labels="found", label=styles, clip_shape=plane)
camera = lumivox.Camera.framing(scene, azimuth=25, size=(96, 96))
for number, depth in enumerate((40, 0, -40)):
    # Voxels and labels stay on the GPU: only the shape is another.
    opened = replace(scene.volumes[0], clip_shapes=lumivox.ClipShape.plane((0, 0, depth), (0, 0, -1)))
    image = lumivox.render(replace(scene, volumes=(opened,)), camera=camera, size=(96, 96), samples=4)
    image.save(f"opened-{number}.png")
