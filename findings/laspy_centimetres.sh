#!/usr/bin/env bash
# laspy 2.6.1 (point clouds as LAS)
#
# Behaviour: laspy.create() and LasHeader() have a scale of 0.01 and an offset of 0. LAS keeps integers, so all
# coordinates are rounded to centimetres, at the moment that they are assigned, without a word.
#
# A good engineer would guess: coordinates that were given as float64 come back to better than a millimetre, since the
# header is made from the data.
#
# So: set header.scales (0.0001 for a small map) and header.offsets before the coordinates.
. "$(dirname "$0")/lib.sh"
python_with laspy==2.6.1 numpy==2.2.6
"$python" - << 'PY'
import laspy, numpy as np
points = np.array([[0.0012, 0.0049, 0.0061], [1.2345, -3.0049, 0.5]])
def error(cloud):
    cloud.x, cloud.y, cloud.z = points.T
    cloud.write("map.las")
    read = laspy.read("map.las")
    return np.abs(np.c_[read.x, read.y, read.z] - points).max()
plain, fine = laspy.create(), laspy.create()
fine.header.scales = [0.0001] * 3
errors = error(plain), error(fine)
print(f"  largest error of a coordinate: {1000 * errors[0]:.2f} mm with the default header, {1000 * errors[1]:.2f} mm with scales of 0.1 mm")
assert errors[0] > 0.004 and errors[1] < 0.0001
PY
