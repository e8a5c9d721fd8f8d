#!/usr/bin/env bash
# ds-msp 0.22.2 (double sphere and other wide lens models)
#
# Behaviour: a double sphere lens with xi 0.35 and alpha 0.42 maps directions one to one up to 150.3 degrees from its
# axis. project() calls those beyond 147.3 degrees invalid, by the half-space of the model's paper (Usenko, Demmel &
# Cremers 2018, eq. 43 to 45), although the pixels that it returns for them are right. unproject() calls the same pixels
# valid. So a pixel may have a valid ray that has no valid pixel.
#
# A good engineer would guess: the half-space of the paper is the domain of the model, and a valid ray of a valid pixel
# is projected to this pixel.
#
# So: masks of both functions are no inverse of each other. The limit follows from the derivative of the radius, which
# is positive up to the end.
. "$(dirname "$0")/lib.sh"
python_with ds-msp==0.22.2 numpy==2.2.6
"$python" - << 'PY'
import numpy as np
from ds_msp.models import DoubleSphereModel
lens = DoubleSphereModel(300, 300, 0, 0, 0.35, 0.42)
angle = np.arange(140, 150.2, 0.1)
rays = np.stack([np.sin(np.radians(angle)), 0 * angle, np.cos(np.radians(angle))], -1)
pixels, projected = lens.project(rays)
back, unprojected = lens.unproject(pixels)
off = np.degrees(np.abs(np.arctan2(back[:, 0], back[:, 2]) - np.radians(angle))).max()
print(f"  project: valid up to {angle[projected].max():.1f} of {angle.max():.1f} degrees, and rises in all of them")
print(f"  unproject: valid in all of them, {off:.1e} degrees off")
assert 147 < angle[projected].max() < 147.5 and np.all(np.diff(pixels[:, 0]) > 0)
assert unprojected.all() and off < 1e-6
PY
