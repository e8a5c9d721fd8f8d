#!/usr/bin/env bash
# trajectopy 5.1.2 (trajectory evaluation)
#
# Behaviour: ATEResult.pos_ate is the *mean* of the position errors. The root mean square, which the TUM benchmark,
# evo and papers call ATE, is pos_dev_rms. With errors that have some outliers the two differ by nearly half.
#
# A good engineer would guess: the figure called ATE is the ATE of the literature.
#
# So: compare pos_dev_rms.
. "$(dirname "$0")/lib.sh"
python_with trajectopy==5.1.2 numpy==2.2.6
export QT_QPA_PLATFORM=offscreen
"$python" - << 'PY'
import numpy as np
import trajectopy
rng, t = np.random.default_rng(0), np.arange(0, 20, 0.1)
error = rng.normal(0, 0.1, (200, 3))
error[::20] += 1  # m
path = np.c_[5 * np.sin(t), 5 * np.cos(t), 0 * t]
def write(name, positions):
    open(name, "w").writelines(f"{s:.6f} {x:.9f} {y:.9f} {z:.9f} 0 0 0 1\n" for s, (x, y, z) in zip(t, positions))
write("truth.tum", path)
write("estimate.tum", path + error)
truth, estimate = (trajectopy.Trajectory.from_file(f"{name}.tum") for name in ("truth", "estimate"))
result = trajectopy.ate(truth, estimate, align=False)
norm = np.linalg.norm(error, axis=1)
mean, rms = norm.mean(), np.sqrt((norm**2).mean())
print(f"  pos_ate {result.pos_ate:.4f} m, pos_dev_rms {result.pos_dev_rms:.4f} m; of the errors: mean {mean:.4f} m, rms {rms:.4f} m")
assert abs(result.pos_ate - mean) < 1e-6 and abs(result.pos_dev_rms - rms) < 1e-6 and rms > 1.5 * mean
PY
