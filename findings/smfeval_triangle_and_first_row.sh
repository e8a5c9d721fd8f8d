#!/usr/bin/env bash
# smfeval 0.4.0 (SQUARE: trajectories with their covariances)
#
# Behaviour: a row has 21 numbers of the covariance, the lower triangle row by row (c11 c21 c22 c31 ...). A file with
# the upper triangle row by row (c11 c12 c13 ...) passes `smfeval validate`, and `smfeval nees` then prints nan, with
# exit code 0. Only `validate --strict` finds it. The same holds for a first row whose covariance is zero, as every
# estimate has whose gauge is fixed by its first pose: `validate` and `nees` accept it, and `validate --strict`
# refuses the file.
#
# A good engineer would guess: a covariance that is not positive definite is an error of `validate` and of `nees`; a
# first pose that defines the frame is allowed, as the header's GAUGE fixed says.
#
# So: write the lower triangle, leave the first row out, and validate with --strict.
. "$(dirname "$0")/lib.sh"
python_with smfeval==0.4.0 numpy==2.2.6 scipy==1.15.3
cat > files.py << 'PY'
import numpy as np
from scipy.spatial.transform import Rotation

rng = np.random.default_rng(7)
N = 200
A = rng.standard_normal((6, 6))
d = np.sqrt(np.diag(A @ A.T))
sigma = np.array([0.3, 0.1, 0.05, 0.02, 0.01, 0.01])  # m, rad
C = A @ A.T / np.outer(d, d) * np.outer(sigma, sigma)
L = np.linalg.cholesky(C)
lower = lambda C: [C[i, j] for i in range(6) for j in range(i + 1)]
upper = lambda C: [C[i, j] for i in range(6) for j in range(i, 6)]

def row(t, R, p, triangle=()):
    return " ".join(f"{v:.12g}" for v in [t, *p, *Rotation.from_matrix(R).as_quat(), *triangle]) + "\n"

lines = ["FORMAT SQUARE/0.3", "REPRESENTATION gaussian_se3", "POSE_FRAME world", "BODY_FRAME body", "GAUGE fixed",
         "TIMESTAMP_UNIT seconds", "ALGORITHM simulated", "ALGORITHM_VERSION 1", "TANGENT_CONVENTION right_perturbation",
         "TANGENT_ORDER translation_rotation", "ROTATION_PARAM axis_angle"]
files = {name: ["".join(f"#%{line}\n" for line in lines)] for name in ("lower", "upper", "first_row_zero")}
truth = []
for k in range(N):
    t, yaw = 0.1 * k, 0.05 * k
    R, p = Rotation.from_euler("z", yaw).as_matrix(), np.array([8 * np.cos(yaw), 8 * np.sin(yaw), 1.0])
    xi = L @ rng.standard_normal(6) if k else np.zeros(6)
    truth.append(row(t, R @ Rotation.from_rotvec(xi[3:]).as_matrix(), p + R @ xi[:3]))
    files["lower"].append(row(t, R, p, lower(C)))
    files["upper"].append(row(t, R, p, upper(C)))
    files["first_row_zero"].append(row(t, R, p, lower(C if k else 0 * C)))
open("truth.tum", "w").writelines(truth)
for name, rows in files.items():
    open(f"{name}.square", "w").writelines(rows)
PY
"$python" files.py
seen=""
for file in lower upper first_row_zero; do
  valid=0 strict=0
  smfeval validate $file.square > out.txt 2>&1 || valid=$?
  smfeval validate --strict $file.square > strict.txt 2>&1 || strict=$?
  coverage=$(smfeval nees $file.square truth.tum --ref-body-frame body --json | "$python" -c 'import json, sys; print(round(json.load(sys.stdin)["coverage"], 2))')
  echo "  $file: validate exits $valid, validate --strict exits $strict, coverage of nees $coverage"
  seen+="$file $valid $strict $coverage;"
done
grep -h "^strict" strict.txt | sed 's/^/  /'
[[ $seen =~ ^lower\ 0\ 0\ 0\.[89][0-9]*\;upper\ 0\ 2\ nan\;first_row_zero\ 0\ 2\ 0\.[89][0-9]*\;$ ]]
