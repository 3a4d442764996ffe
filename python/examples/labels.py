"""What a CT shows, found by itself: litres of body, lungs and airways, and the patient without the table."""

import numpy as np

import lumivox

scan = lumivox.phantom("torso", 96)
found = scan.segment()
labels = found.labels
assert labels is not None
litres = np.prod(scan.spacing) * 1e-6
for label in labels.labels:
    voxels = int((labels.array == label.value).sum())
    if voxels:
        print(f"{label.name:16} {voxels * litres:6.2f} l")
alone = scan.patient_alone()
print(alone.note)
lumivox.render(alone, preset="ct-bone", azimuth=15, size=(96, 96), samples=4).save("patient.png")
