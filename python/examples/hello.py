"""Five lines to a picture: a scan, a look, a file."""

import lumivox

scan = lumivox.phantom("head", 64)
image = lumivox.render(scan, preset="ct-bone", azimuth=35, size=(160, 160), samples=16)
image.save("hello.png")
