#!/usr/bin/env bash
# evo 1.38.1 (trajectory evaluation)
#
# Behaviour: `--sync_method interpolation` interpolates the denser trajectory, be it the truth or the
# estimate, at the times of the other. --t_max_diff (10 ms) still holds: a pose that has no pose of the other within
# it is left out, although it lies between two of them. A truth at 10 Hz and estimates halfway between its poses give
# "no matching timestamps", and with jitter the figures are those of the poses that happened to be near.
#
# A good engineer would guess: evo takes nearest poses alone, as it did for years; and with interpolation, that every
# pose between two others counts.
#
# So: give --t_max_diff half the truth's interval with --sync_method interpolation.
. "$(dirname "$0")/lib.sh"
python_with evo==1.38.1
export HOME=$work  # evo keeps its settings there
"$python" - << 'PY'
import numpy as np
def write(name, times):
    open(name, "w").writelines(f"{t:.6f} {np.sin(t):.9f} {np.cos(t):.9f} 0 0 0 0 1\n" for t in times)
write("truth.tum", np.arange(0, 20, 0.1))
write("halfway.tum", np.arange(0.5, 19, 0.5) + 0.05)
write("jitter.tum", np.arange(0.5, 19, 0.5) + np.random.default_rng(3).uniform(-0.05, 0.05, 37))
PY
ape() {
  { evo_ape tum truth.tum "$@" -v 2>&1 || true; } | awk '/Found [0-9]+ of/ {pairs = $2} /rmse/ {rmse = $2} /no matching/ {none = 1}
    END {print none ? "no matching timestamps" : pairs " pairs, rmse " rmse " m"}'
}
nearest=$(ape halfway.tum --sync_method nearest_time --t_max_diff 0.06)
interpolated=$(ape halfway.tum --sync_method interpolation --t_max_diff 0.06)
default=$(ape halfway.tum --sync_method interpolation)
jitter=$(ape jitter.tum --sync_method interpolation)
echo "  halfway, nearest_time --t_max_diff 0.06:   $nearest"
echo "  halfway, interpolation --t_max_diff 0.06:  $interpolated"
echo "  halfway, interpolation:                    $default"
echo "  37 poses with jitter, interpolation:       $jitter"
[[ $nearest == "37 pairs, rmse 0.0499"* || $nearest == "37 pairs, rmse 0.05"* ]]
[[ $interpolated == "37 pairs, rmse 0.001"* ]]
[[ $default == "no matching timestamps" ]]
pairs=${jitter%% *}
((pairs > 0 && pairs < 15))
