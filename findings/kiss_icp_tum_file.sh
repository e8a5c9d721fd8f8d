#!/usr/bin/env bash
# kiss-icp 1.3.0 (lidar odometry)
#
# Behaviour: the trajectory in TUM format has four decimals for all its columns: times of 0.1 ms, and quaternions that
# resolve 0.01 deg and are not of unit length. For a folder of clouds its times are the numbers of the frames, as
# seconds, although the files are named by their stamps. The file in KITTI's format beside it has all digits.
#
# A good engineer would guess: both files hold the same poses, and a TUM file has times.
#
# So: take the rotations of the KITTI file, and the times of the file names.
. "$(dirname "$0")/lib.sh"
python_with kiss-icp==1.3.0 numpy==2.2.6 scipy==1.15.3
cat > frames.py << 'PY'
"""Six scans of a room of 20 m x 16 m x 6 m, 0.1 s apart, as KITTI's .bin."""
import os
import numpy as np
from scipy.spatial.transform import Rotation
rng, n, size = np.random.default_rng(1), 20000, np.array([10.0, 8.0, 3.0])
wall = rng.uniform(-1, 1, (n, 3)) * size
side = rng.integers(0, 3, n)
wall[np.arange(n), side] = rng.choice([-1, 1], n) * size[side]
os.mkdir("scans")
for k in range(6):
    R, p = Rotation.from_euler("z", 0.3 * k, degrees=True).as_matrix(), np.array([0.21 * k, 0.05 * k, 0])
    scan = np.c_[(wall - p) @ R, np.zeros(n)].astype(np.float32)
    scan.tofile(f"scans/{1403636584763555584 + k * 100_000_000}.bin")
PY
"$python" frames.py
kiss_icp_out_dir=out kiss_icp_pipeline scans > log.txt 2>&1
"$python" - << 'PY'
import glob
import numpy as np
tum, kitti = (sorted(glob.glob(f"out/2*/scans_poses_{kind}.txt"))[0] for kind in ("tum", "kitti"))
lines = open(tum).read().splitlines()
rows, matrices = np.loadtxt(tum), np.loadtxt(kitti).reshape(-1, 3, 4)
length = np.linalg.norm(rows[:, 4:], axis=1)
print(f"  {lines[-1]}")
print(f"  times {rows[:, 0].tolist()}; lengths of quaternions off by up to {np.abs(length - 1).max():.0e}; "
      f"rotations of the KITTI file orthogonal to {max(np.abs(R @ R.T - np.eye(3)).max() for R in matrices[:, :, :3]):.0e}")
assert rows[:, 0].tolist() == [0, 1, 2, 3, 4, 5]
assert all(len(cell.split(".")[1]) == 4 for line in lines for cell in line.split())
assert np.abs(length - 1).max() > 1e-6 and max(np.abs(R @ R.T - np.eye(3)).max() for R in matrices[:, :, :3]) < 1e-12
PY
