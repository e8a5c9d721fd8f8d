#!/usr/bin/env bash
# trimesh 5.2.0 (meshes and point clouds)
#
# Behaviour: PointCloud.export writes PLY (and GLB) vertices as 32-bit floats without a word, although the cloud holds
# 64-bit ones and PLY has "double". Coordinates of a map grid (4500000.123 m) lose 12 cm. Its XYZ and OBJ are exact.
#
# A good engineer would guess: a format that can hold the numbers gets them.
#
# So: subtract an origin before the export, or write "property double".
. "$(dirname "$0")/lib.sh"
python_with trimesh==5.2.0 numpy==2.2.6
"$python" - << 'PY'
import numpy as np, trimesh
points = np.array([[4500000.123, 500000.456, 100.789], [4500001.123, 500000.456, 100.789]])
errors = {}
for kind in ("ply", "xyz"):
    trimesh.PointCloud(points).export(f"map.{kind}")
    errors[kind] = np.abs(np.asarray(trimesh.load(f"map.{kind}").vertices) - points).max()
head = open("map.ply", "rb").read(300).split(b"end_header")[0].decode().split("\n")
print("  " + ", ".join(line for line in head if line.startswith("property")) + f"; error {errors['ply']:.3f} m, xyz {errors['xyz']:.6f} m")
assert errors["ply"] > 0.1 and errors["xyz"] < 1e-6 and "property float x" in head
PY
