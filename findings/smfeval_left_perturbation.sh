#!/usr/bin/env bash
# smfeval 0.4.0 (SQUARE: trajectories with their covariances)
#
# Behaviour: a file may declare TANGENT_CONVENTION left_perturbation, T = Exp(xi) T_mean. `smfeval` reads it, but
# forms its residual as for a right perturbation, T_mean^-1 T, and compares that with the covariance as it stands. One
# and the same belief, written in both conventions, has a coverage near its nominal 0.90 as "right" and a clearly lower
# one as "left".
#
# A good engineer would guess: the header exists so that both conventions mean the same; either can be written.
#
# So: write right perturbations.
. "$(dirname "$0")/lib.sh"
python_with smfeval==0.4.0 numpy==2.2.6 scipy==1.15.3
cat > belief.py << 'PY'
"""A belief on a walk of 400 poses. Its errors are drawn from it, in the body frame; `left` is the same belief, as
Ad(T) C Ad(T)^T."""
import numpy as np
from scipy.spatial.transform import Rotation

rng = np.random.default_rng(7)
N = 400
sigma = np.array([0.30, 0.03, 0.03, 0.002, 0.002, 0.01])  # m, rad: forward is uncertain
hat = lambda v: np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])

def adjoint(R, p):
    return np.block([[R, hat(p) @ R], [np.zeros((3, 3)), R]])

def row(t, R, p, C=None):
    numbers = [t, *p, *Rotation.from_matrix(R).as_quat()]
    if C is not None:
        numbers += [C[i, j] for i in range(6) for j in range(i + 1)]
    return " ".join(f"{v:.12g}" for v in numbers) + "\n"

def header(convention):
    lines = ["FORMAT SQUARE/0.3", "REPRESENTATION gaussian_se3", "POSE_FRAME world", "BODY_FRAME body", "GAUGE fixed",
             "TIMESTAMP_UNIT seconds", "ALGORITHM simulated", "ALGORITHM_VERSION 1", f"TANGENT_CONVENTION {convention}",
             "TANGENT_ORDER translation_rotation", "ROTATION_PARAM axis_angle"]
    return "".join(f"#%{line}\n" for line in lines)

truth, files = [], {"right": [header("right_perturbation")], "left": [header("left_perturbation")]}
for k in range(N):
    t, yaw = 0.1 * k, 0.05 * k
    R, p = Rotation.from_euler("z", yaw).as_matrix(), np.array([8 * np.cos(yaw), 8 * np.sin(yaw), 1.0])
    C = np.diag(sigma**2)
    xi = sigma * rng.standard_normal(6)
    truth.append(row(t, R @ Rotation.from_rotvec(xi[3:]).as_matrix(), p + R @ xi[:3]))
    Ad = adjoint(R, p)
    files["right"].append(row(t, R, p, C))
    files["left"].append(row(t, R, p, Ad @ C @ Ad.T))
open("truth.tum", "w").writelines(truth)
for name, lines in files.items():
    open(f"{name}.square", "w").writelines(lines)
PY
"$python" belief.py
for side in right left; do
  smfeval nees $side.square truth.tum --ref-body-frame body --json > $side.json
done
"$python" - << 'PY'
import json
right, left = (json.load(open(f"{side}.json")) for side in ("right", "left"))
for name, verdict in (("right", right), ("left", left)):
    print(f"  {name}: coverage {verdict['coverage']:.3f} of 0.90, NEES {verdict['anees']['anees']:.2f} of 3, {verdict['anees']['verdict']}")
assert abs(right["coverage"] - 0.9) < 0.04 and right["anees"]["verdict"] == "consistent"
assert left["coverage"] < 0.75 and left["anees"]["verdict"] == "optimistic"
PY
