"""What a CT shows, found by itself: litres of body, lungs and airways, and the patient without the table."""

import lumivox

scan = lumivox.phantom("torso", 96)
labels = scan.segment().labels
assert labels is not None
for name in labels.names:
    if labels.ml(name) > 0.0:
        print(f"{name:16} {labels.ml(name) / 1000.0:6.2f} l")
alone = scan.patient_alone()
print(alone.note)
lumivox.render(alone, preset="ct-bone", azimuth=15, size=(96, 96), samples=4).save("patient.png")
