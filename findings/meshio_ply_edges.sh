#!/usr/bin/env bash
# meshio 5.3.5 (meshes and point clouds)
#
# Behaviour: a PLY file with `element edge`, which the format's description names beside vertices and faces, is not
# read. meshio.read does not raise meshio.ReadError, either: it prints a line and raises SystemExit, so that
# `except Exception` does not catch it and a script ends. meshio itself writes lines as faces with two corners.
#
# A good engineer would guess: an element that a reader does not know is skipped, which the format was made for, and a
# reader that cannot read raises its ReadError.
#
# So: offer a PLY without edges.
. "$(dirname "$0")/lib.sh"
python_with meshio==5.3.5 numpy==2.2.6
"$python" - << 'PY'
import meshio
head = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
points = "0 0 0\n1 0 0\n1 1 0\n"
open("points.ply", "w").write(head + "end_header\n" + points)
open("edges.ply", "w").write(head + "element edge 2\nproperty int vertex1\nproperty int vertex2\nend_header\n" + points + "0 1\n1 2\n")
assert len(meshio.read("points.ply").points) == 3
seen = "no exception"
try:
    meshio.read("edges.ply")
except BaseException as error:
    seen = type(error).__name__
print(f"  points.ply: read; edges.ply: {seen}")
assert seen == "SystemExit"
meshio.write("lines.ply", meshio.Mesh([[0, 0, 0], [1, 0, 0], [1, 1, 0]], [("line", [[0, 1], [1, 2]])]), binary=False)
written = open("lines.ply").read()
print("  its own lines:", [line for line in written.splitlines() if line.startswith("element")])
assert "element face 2" in written and "element edge" not in written
PY
