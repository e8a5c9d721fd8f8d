#!/usr/bin/env bash
# OpenCV 4.10.0 and 5.0.0 (opencv-contrib-python-headless: corners of calibration boards)
#
# Behaviour: the corners that CharucoDetector of 4.10.0 finds are half a pixel too far right and down, if the centre of
# the first pixel is (0, 0). findChessboardCorners with cornerSubPix is not off, on a checkerboard with the same corners,
# and neither is cornerSubPix on the very same image. 4.13.0 is as 4.10.0; 4.14.0 and 5.0.0 are right (opencv/opencv
# issue 25539). Corners of markers refined by CORNER_REFINE_APRILTAG are off by nearly half a pixel in 4.10.0 and 5.0.0
# alike; those refined by CORNER_REFINE_SUBPIX are not.
#
# A good engineer would guess: all corners of one library have one origin, and a detector has it in all versions.
#
# So: ask for the version with ChArUco corners, and subtract 0.5 from those of 4.10 to 4.13. A calibration absorbs the
# offset in its principal point, so that residuals do not show it.
. "$(dirname "$0")/lib.sh"
cat > board.py << 'PY'
import cv2, numpy as np
aruco, columns, rows = cv2.aruco, 8, 6
print(f"  OpenCV {cv2.__version__}")
dictionary = aruco.getPredefinedDictionary(aruco.DICT_4X4_50)
board = aruco.CharucoBoard((columns, rows), 1.0, 0.7, dictionary)
markers = {int(i): np.asarray(o, float)[:, :2] for i, o in zip(board.getIds().ravel(), board.getObjPoints())}

def grey_of(x, y, with_markers):
    i, j = np.floor(x).astype(int), np.floor(y).astype(int)
    grey = np.where((i >= 0) & (j >= 0) & (i < columns) & (j < rows) & ((i + j) % 2 == 0), 25.0, 230.0)
    for number, corners in markers.items() if with_markers else ():
        a, b = (x - corners[0, 0]) / 0.7, (y - corners[0, 1]) / 0.7
        inside = (a >= 0) & (a < 1) & (b >= 0) & (b < 1)
        bits = dictionary.generateImageMarker(number, 6)
        grey[inside] = np.where(bits[(6 * b[inside]).astype(int), (6 * a[inside]).astype(int)], 230.0, 25.0)
    return grey

def render(H, width, height, with_markers, n=8):
    """Pixel (u, v) is the mean of n x n samples within half a pixel of (u, v)."""
    part = (np.arange(n) + 0.5) / n - 0.5
    u, v = ((np.arange(size)[:, None] + part).ravel() for size in (width, height))
    x, y, w = np.linalg.inv(H) @ np.stack([c.ravel() for c in (*np.meshgrid(u, v), np.ones((v.size, u.size)))])
    grey = grey_of(x / w, y / w, with_markers)
    return np.rint(grey.reshape(height, n, width, n).mean((1, 3))).astype(np.uint8)

def project(H, points):
    q = np.c_[points, np.ones(len(points))] @ H.T
    return q[:, :2] / q[:, 2:]

def subpix(image, corners):
    start = np.ascontiguousarray(corners.reshape(-1, 1, 2), np.float32)
    return cv2.cornerSubPix(image, start, (4, 4), (-1, -1), (3, 50, 1e-4)).reshape(-1, 2)

names = ("ChArUco", "cornerSubPix, same image", "checkerboard", "markers, subpix", "markers, apriltag")
off = {name: [] for name in names}
rng = np.random.default_rng(1)
for width, height in ((480, 360), (481, 361), (480, 361)):
    at = np.array([[0, 0], [columns, 0], [columns, rows], [0, rows]], float)
    to = np.array([[50, 40], [width - 50, 40], [width - 50, height - 40], [50, height - 40]]) + rng.uniform(-20, 20, (4, 2))
    A = [r for (x, y), (u, v) in zip(at, to)
         for r in ([x, y, 1, 0, 0, 0, -u * x, -u * y], [0, 0, 0, x, y, 1, -v * x, -v * y])]
    H = np.append(np.linalg.solve(A, to.ravel()), 1).reshape(3, 3)
    truth = project(H, np.asarray(board.getChessboardCorners())[:, :2])
    image, plain = (render(H, width, height, marked) for marked in (True, False))
    corners, ids = aruco.CharucoDetector(board).detectBoard(image)[:2]
    corners, ids = corners.reshape(-1, 2), ids.ravel()
    off["ChArUco"].append(corners - truth[ids])
    off["cornerSubPix, same image"].append(subpix(image, corners) - truth[ids])
    found, corners = cv2.findChessboardCorners(plain, (columns - 1, rows - 1))
    assert found
    corners = subpix(plain, corners)
    nearest = np.linalg.norm(corners[:, None] - truth, axis=2).argmin(1)
    assert len(set(nearest)) == len(truth)
    off["checkerboard"].append(corners - truth[nearest])
    for name, method in (("subpix", aruco.CORNER_REFINE_SUBPIX), ("apriltag", aruco.CORNER_REFINE_APRILTAG)):
        parameters = aruco.DetectorParameters()
        parameters.cornerRefinementMethod = method
        quads, ids, _ = aruco.ArucoDetector(dictionary, parameters).detectMarkers(image)
        off[f"markers, {name}"].append(np.concatenate(
            [q.reshape(4, 2) - project(H, markers[int(i)]) for q, i in zip(quads, ids.ravel())]))
mean = {}
for name in names:
    each = np.array([d.mean(0) for d in off[name]])
    everything = np.concatenate(off[name])
    mean[name] = everything.mean(0)
    print(f"  {name}: {len(everything)} corners, off by {mean[name][0]:+.3f}, {mean[name][1]:+.3f} px in the mean,"
          f" {each.min():+.3f} to {each.max():+.3f} by image")
assert np.all(abs(mean["ChArUco"] - (0.5 if cv2.__version__ == "4.10.0" else 0)) < 0.05)
assert all(np.all(abs(mean[name]) < 0.05) for name in ("cornerSubPix, same image", "checkerboard", "markers, subpix"))
assert np.all(abs(mean["markers, apriltag"] - 0.47) < 0.08)
PY
for version in 4.10.0.84 5.0.0.93; do
  python_with opencv-contrib-python-headless==$version numpy==2.2.6
  timeout 120 nice -n 10 "$python" board.py
done
