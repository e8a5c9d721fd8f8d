"""Visual-inertial SLAM with an extended Kalman filter that states its uncertainty.

    import chasles

    recording = chasles.simulate("hallway")          # or chasles.read("MH_01")
    run = chasles.run(recording, chart="right-sen3")
    print(run.summary["ate_m"], run.states["position"].shape)
    run.show("run.html")

Times are int64 nanoseconds; where a time is an argument, an int is in nanoseconds and a float in
seconds. Lengths are in metres, angles in radians. `a_T_b` maps coordinates of frame b to frame a.
Quaternions are x y z w. Covariances of poses are of [theta; dp] in world axes: R = Exp(theta) R_hat,
p = p_hat + dp. All arrays are numpy's, and copies; those of a Run are read-only.
"""

from . import _one_line  # first: it wraps what the others import
from ._core import (
    Camera,
    CaptureGuide,
    DivergedError,
    Error,
    Estimate,
    ImuNoise,
    InputError,
    NotInitialisedError,
    PredictedState,
    RealtimeSlam,
    Recording,
    Slam,
    Target,
    UsageError,
    __version__,
)
from . import _copies
from ._arrays import from_arrays as _from_arrays
from ._batch import Batch, batch
from ._calls import compare, monte_carlo, run, simulate
from ._calibrate import CamerasCalibration, Halves, Parameters, calibrate_cameras
from ._calibrate_imu import (
    ImuCamerasCalibration,
    ImuCorrection,
    MotionCalibration,
    StatedParameters,
    calibrate_from_motion,
    calibrate_imu_cameras,
)
from ._executors import RayExecutor
from ._check import Check, Finding, check
from ._functions import command, evaluate, join_imu, main, read, read_run, settings
from ._noise import NoiseCalibration, calibrate_noise
from ._run import Run
from ._settings import FilterArguments, RunArguments, RunSettings, SceneSettings, StreetSettings
from .lab import ChartState, Comparison, FirstSight, Study, register_chart, register_depth_rule

__all__ = [
    "Batch", "Camera", "CamerasCalibration", "CaptureGuide", "ChartState", "Check", "Comparison", "DivergedError", "Error",
    "Estimate", "FilterArguments", "Finding", "FirstSight", "Halves", "ImuCamerasCalibration", "ImuCorrection",
    "ImuNoise", "InputError", "MotionCalibration", "NoiseCalibration", "NotInitialisedError", "Parameters",
    "PredictedState", "RayExecutor", "RealtimeSlam", "Recording", "Run", "RunArguments", "RunSettings", "SceneSettings",
    "Slam", "StatedParameters", "StreetSettings", "Study", "Target", "UsageError", "__version__", "batch",
    "calibrate_cameras", "calibrate_from_motion", "calibrate_imu_cameras", "calibrate_noise", "check", "command",
    "compare", "evaluate", "join_imu", "main", "monte_carlo", "read", "read_run", "register_chart",
    "register_depth_rule", "run", "settings", "simulate",
]

setattr(Recording, "from_arrays", staticmethod(_from_arrays))
