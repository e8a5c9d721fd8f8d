#!/usr/bin/env bash
# smfeval 0.4.0 (SQUARE: trajectories with their covariances)
#
# Behaviour: `smfeval nees` forms a right perturbation's residual in the body frame, where its covariance is. The
# translation CRPS, the energy score and the interval score of `smfeval score` take the same body-frame covariance for
# one in the axes of the world: one sigma per axis of the world, from the body's diagonal. One and the same belief with
# one and the same truth has the NEES and the coverage unchanged, but another CRPS, if its body frame is turned.
#
# A good engineer would guess: a proper score of a belief does not depend on the body frame in which the belief is
# written, and all scores of one command use the covariance alike.
#
# So: take k and coverage from any file, and the CRPS from one whose body axes are parallel to the world's: estimate
# (1, p), truth (R_truth R_estimate^T, p_truth), covariance R C R^T.
. "$(dirname "$0")/lib.sh"
python_with smfeval==0.4.0 numpy==2.2.6 scipy==1.15.3
cat > belief.py << 'PY'
"""A belief of a body that drives north, uncertain forward alone. `turned` is the same belief and the same truth with
another body frame, whose axes are the world's."""
import numpy as np
from scipy.spatial.transform import Rotation

rng = np.random.default_rng(7)
N = 400
sigma = np.array([0.50, 0.01, 0.01, 0.002, 0.002, 0.002])  # m, rad, axes of the body: forward is uncertain
north = Rotation.from_euler("z", np.pi / 2)

lines = ["FORMAT SQUARE/0.3", "REPRESENTATION gaussian_se3", "POSE_FRAME world", "BODY_FRAME body", "GAUGE fixed",
         "TIMESTAMP_UNIT seconds", "ALGORITHM simulated", "ALGORITHM_VERSION 1", "TANGENT_CONVENTION right_perturbation",
         "TANGENT_ORDER translation_rotation", "ROTATION_PARAM axis_angle"]
files = {name: ["".join(f"#%{line}\n" for line in lines)] for name in ("body", "turned")}
truths = {name: [] for name in files}

def row(t, R, p, C=None):
    numbers = [t, *p, *R.as_quat()]
    if C is not None:
        numbers += [C[i, j] for i in range(6) for j in range(i + 1)]
    return " ".join(f"{v:.12g}" for v in numbers) + "\n"

for k in range(N):
    t, p = 0.1 * k, np.array([0, 0.5 * k, 0])
    xi = sigma * rng.standard_normal(6)
    true_R, true_p = north * Rotation.from_rotvec(xi[3:]), p + north.apply(xi[:3])
    turn = {"body": Rotation.identity(), "turned": north.inv()}
    for name, B in turn.items():  # body_R_other: the other body frame is turned by B in the body
        M = np.kron(np.eye(2), B.inv().as_matrix())
        files[name].append(row(t, north * B, p, M @ np.diag(sigma**2) @ M.T))
        truths[name].append(row(t, true_R * B, true_p))
for name in files:
    open(f"{name}.square", "w").writelines(files[name])
    open(f"{name}.tum", "w").writelines(truths[name])
PY
"$python" belief.py
for name in body turned; do
  smfeval validate --strict $name.square > valid.txt
  smfeval nees $name.square $name.tum --ref-body-frame body --json > $name.nees.json
  smfeval score $name.square $name.tum --ref-body-frame body --json > $name.score.json
done
"$python" - << 'PY'
import json
found = {}
for name in ("body", "turned"):
    nees, score = (json.load(open(f"{name}.{verb}.json")) for verb in ("nees", "score"))
    found[name] = nees["k"], score["calibration"]["coverage"], score["scores"]["translation_crps"]["mean"]
    print("  {}: k {:.3f}, coverage {:.3f}, CRPS {:.4f} m".format(name, *found[name]))
# Of a Gaussian with the right sigma the CRPS is sigma / sqrt(pi) in the mean, here of three axes.
expected = (0.50 + 0.01 + 0.01) / 3 / 3.14159**0.5
print(f"  expected CRPS: {expected:.4f} m")
assert abs(found["body"][0] - found["turned"][0]) < 1e-6 and found["body"][1] == found["turned"][1]
assert abs(found["turned"][2] / expected - 1) < 0.1
assert found["body"][2] > 1.5 * expected
PY
