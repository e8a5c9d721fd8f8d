#!/usr/bin/env bash
# AllanTools 2024.6 (Allan deviations, from which the noise of an IMU is read)
#
# Behaviour: oadev and its relatives take their data for the *phase* of a clock by default (data_type="phase"): they
# difference it once more. A gyroscope's rates, given as they are, yield a noise density that is off by a factor which
# depends on tau (24 at 1 s and 200 Hz), and a slope of -1 in place of -1/2, without a word.
#
# A good engineer would guess: the Allan deviation of a series of rates is that of the numbers given.
#
# So: data_type="freq" for rates and accelerations.
. "$(dirname "$0")/lib.sh"
python_with AllanTools==2024.6 numpy==2.2.6 scipy==1.15.3
"$python" - << 'PY'
import allantools, numpy as np
rate, density = 200.0, 1e-3  # Hz, rad/s/sqrt(Hz)
rates = density * np.sqrt(rate) * np.random.default_rng(1).standard_normal(200_000)
found = {}
for name, more in (("default", {}), ("data_type='freq'", dict(data_type="freq"))):
    _, deviations, _, _ = allantools.oadev(rates, rate=rate, taus=[1.0, 10.0], **more)
    found[name] = deviations[0], np.log10(deviations[1] / deviations[0])
    print(f"  {name}: {found[name][0]:.6f} rad/s/sqrt(Hz) at 1 s (true {density}), slope {found[name][1]:.2f} (true -0.5)")
assert 20 < found["default"][0] / density < 30 and abs(found["default"][1] + 1) < 0.1
assert abs(found["data_type='freq'"][0] / density - 1) < 0.05 and abs(found["data_type='freq'"][1] + 0.5) < 0.1
PY
