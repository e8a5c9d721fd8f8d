#!/usr/bin/env bash
# pycolmap 4.2.1 (COLMAP's cameras in Python)
#
# Behaviour: an OPENCV_FISHEYE camera of 200 degrees has pixels beyond 90 degrees from its axis. cam_from_img() gives a
# point at depth 1, whose distance from the axis is tan(angle) up to 90 degrees, and from there on the angle itself in
# radians: the pixel at 90.1 degrees has the ray at 57.5 degrees. img_from_cam() maps this ray to another pixel, 114 px
# nearer to the centre. Rays at 90 degrees and beyond have no pixel (None). The same holds for the other fisheye models.
#
# A good engineer would guess: a pixel whose ray has no point at depth 1 gives None or NaN, as a ray without a pixel
# does, or else a unit ray.
#
# So: pixels beyond 90 degrees must be left out before they reach COLMAP. Otherwise two rings of the image have the same
# rays, without a word.
. "$(dirname "$0")/lib.sh"
python_with pycolmap==4.2.1 numpy==2.4.6
"$python" - << 'PY'
import numpy as np
import pycolmap

camera = pycolmap.Camera(model="OPENCV_FISHEYE", width=740, height=740, params=[200, 200, 370, 370, 0, 0, 0, 0])
for degrees, expected in ((45, 45), (89.9, 89.9), (90.1, 57.547), (100, 60.189)):
    pixel = np.array([370 + 200 * np.radians(degrees), 370])
    x, y = camera.cam_from_img(pixel)
    again = camera.img_from_cam(np.array([x, y, 1.0]))
    ray = np.degrees(np.arctan(x))
    print(f"  pixel at {degrees} degrees: ray at {ray:.3f} degrees, whose pixel is {np.linalg.norm(again - pixel):.1f} px away")
    assert abs(ray - expected) < 1e-3 and (np.linalg.norm(again - pixel) < 1e-6) == (degrees < 90)
angle = np.radians(95)
assert camera.img_from_cam(np.array([np.sin(angle), 0, np.cos(angle)])) is None
print("  ray at 95 degrees: no pixel")
PY
