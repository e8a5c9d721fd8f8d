"""Types of the compiled part of chasles. tools/python-types adds the docstrings and the settings (
        chart: str = ..., landmarks: Literal['cartesian', 'inverse-depth'] = ...,
        init: Literal['multi-view', 'fixed-depth'] = ..., nav_attitude: bool = ..., composition_interval: float = ...,
        first_estimates: Literal['auto', 'true', 'false'] = ..., first_order_transition: bool = ...,
        numeric_jacobians: bool = ..., keep_scale: Literal['auto', 'true', 'false'] = ...,
        pixel_sigma: Union[float, Literal['auto'], None] = ..., track_sigma: Union[float, Literal['auto'], None] = ...,
        track_drift: Union[float, Literal['auto'], None] = ..., match_sigma: Union[float, Literal['auto'], None] = ...,
        imu_noise_scale: Union[float, Literal['auto'], None] = ...,
        vibration_noise: Union[float, Literal['auto'], None] = ..., initial_tilt_sigma: float = ...,
        initial_velocity_sigma: float = ..., initial_accelerometer_bias_sigma: float = ...,
        initial_gyroscope_bias_sigma: float = ...,
        calibrate_extrinsics: Literal['auto', 'false', 'true', 'considered'] = ...,
        initial_extrinsic_rotation_sigma: float = ..., initial_extrinsic_translation_sigma: float = ...,
        calibrate_time_offset: Literal['auto', 'false', 'true', 'considered'] = ...,
        time_offset: Union[float, Literal['auto'], None] = ..., initial_time_offset_sigma: float = ...,
        calibrate_intrinsics: Literal['auto', 'false', 'true', 'considered'] = ..., initial_focal_sigma: float = ...,
        initial_principal_point_sigma: float = ..., initial_distortion_sigma: float = ...,
        readout_time: Union[float, Literal['auto'], None] = ...,
        calibrate_readout: Literal['auto', 'false', 'true', 'considered'] = ..., initial_readout_sigma: float = ...,
        calibrate_imu: Literal['auto', 'false', 'true', 'considered'] = ..., initial_imu_scale_sigma: float = ...,
        initial_imu_misalignment_sigma: float = ..., initial_g_sensitivity_sigma: float = ..., depth_rule: str = ...,
        fixed_depth: float = ..., fixed_depth_sigma: float = ..., inverse_depth: float = ...,
        inverse_depth_sigma: float = ..., guessed_depth_observations: Union[float, Literal['auto'], None] = ...,
        clones: int = ..., frames_per_clone: int = ..., clone_interval: float = ...,
        max_relative_depth_sigma: float = ..., max_total_depth_sigma: float = ..., min_parallax: float = ...,
        min_landmarks: int = ..., settled_depth_sigma: float = ..., zupt_velocity_sigma: float = ...,
        noise_inflation: float = ..., noise_inflation_frames: int = ..., gate: float = ..., max_rejections: int = ...,
        max_landmarks: int = ..., waiting_frames: int = ..., recognise: Literal['none', 'ids', 'appearance'] = ...,
        prior_map: Literal['estimated', 'considered'] = ..., recognisable: int = ...,
        exact_map: Literal['auto', 'true', 'false'] = ..., map_memory: float = ..., start: StartSettings = ...,
        frontend: FrontendSettings = ..., batch: BatchSettings = ...)."""

import os
from typing import Any, Callable, Literal, Mapping, Optional, Sequence, Tuple, Union

from numpy import float64, int64, uint8
from numpy.typing import ArrayLike, NDArray

from ._settings import BatchSettings, FrontendSettings, StartSettings

Path = Union[str, os.PathLike[str]]
Time = Union[int, float]  # int [ns], float [s]
Floats = NDArray[float64]
Ints = NDArray[int64]
_Advance = Callable[[int, int], None]
Image = NDArray[uint8]
_Picture = Any  # an array, the path of a file, an image of Pillow, or None
_Frame = Union[_Picture, Sequence[_Picture]]

__version__: str

class Error(RuntimeError):
    run: Any
class UsageError(Error, ValueError): ...
class InputError(Error, ValueError): ...
class NotInitialisedError(Error): ...
class DivergedError(Error): ...

class Camera:
    """A camera of a rig: z forward, x right, y down."""
    def __init__(self, width: int, height: int, fx: float, fy: float, cx: float, cy: float, distortion: str = ...,
                 coefficients: Sequence[float] = ..., cam_T_imu: ArrayLike = ..., readout_time: float = ...,
                 readout_direction: str = ...) -> None:
        """Intrinsics in pixels; distortion with coefficients: none, radtan (k1 k2 p1 p2 [k3 [k4 k5 k6 [s1 s2 s3 s4]]]), equidistant (k1 k2 k3 k4), ds (xi alpha), eucm (alpha beta), omni (xi [k1 k2 p1 p2]), fov (w), division (lambda), fisheye624 (k0 k1 k2 k3 k4 k5 p0 p1 s0 s1 s2 s3). cam_T_imu (4, 4) maps IMU coordinates to the camera's [m]. readout_time: of a rolling shutter [s], whose image has the time of its first line; readout_direction: down, up, right or left."""
    @property
    def width(self) -> int:
        """[px]"""
    @property
    def height(self) -> int:
        """[px]"""
    @property
    def fx(self) -> float:
        """Focal length [px]."""
    @property
    def fy(self) -> float:
        """Focal length [px]."""
    @property
    def cx(self) -> float:
        """Principal point [px]."""
    @property
    def cy(self) -> float:
        """Principal point [px]."""
    @property
    def distortion(self) -> str:
        """The name of the lens model."""
    @property
    def coefficients(self) -> list[float]:
        """Of the lens model, in its order."""
    @property
    def cam_T_imu(self) -> Floats:
        """(4, 4): maps IMU coordinates to the camera's [m]."""
    @property
    def readout_time(self) -> float:
        """Of a rolling shutter [s]; 0: a global one."""
    @property
    def readout_direction(self) -> str:
        """down, up, right or left."""

class Target:
    """A calibration target of a file (docs/calibration.md), and its corners in images."""
    def __init__(self, path: Path) -> None: ...
    @property
    def corners(self) -> Floats:
        """(N, 3): the corners in the frame of the target [m]; the row is a corner's id."""
    def find(self, image: _Picture) -> Tuple[Ints, Floats]:
        """The ids (K,) of the corners that an image shows and their pixels (K, 2); the centre of the first pixel is (0, 0). An image is grey, (height, width) of uint8, or one of Pillow."""

class CaptureGuide:
    """Says, while views of a target are recorded by any program, which views a calibration would lack. target: a Target, or its corners (N, 3) as for calibrate_cameras [m]. sizes: (width, height) of the images of each camera. lenses: as for calibrate_cameras; a single one is that by which the cameras are estimated."""
    def __init__(self, target: Union[Target, ArrayLike], sizes: Sequence[Tuple[int, int]], lenses: str = ...) -> None: ...
    def add(self, time: Time, camera: int, ids: ArrayLike, pixels: ArrayLike) -> None:
        """A view, as one of calibrate_cameras: time an int [ns] or a float [s], one for all cameras that see the target at an instant; ids (K,), pixels (K, 2). Fewer than four corners show nothing. Raises InputError for a view that cannot be used."""
    @property
    def missing(self) -> list[str]:
        """What is missing, one sentence each, the most important first; empty: it is enough."""
    @property
    def focal_lengths(self) -> list[Optional[Tuple[float, float]]]:
        """Of each camera fx and its standard deviation [px], by its views till now; None where they do not determine it yet."""

class ImuNoise:
    """Noise densities of an IMU, as Allan variances give them."""
    def __init__(self, *, accelerometer_noise_density: float, gyroscope_noise_density: float,
                 accelerometer_random_walk: float, gyroscope_random_walk: float) -> None:
        """Noise densities [m/s^2/sqrt(Hz), rad/s/sqrt(Hz)] and random walks of the biases [m/s^3/sqrt(Hz), rad/s^2/sqrt(Hz)]."""
    @property
    def accelerometer_noise_density(self) -> float:
        """[m/s^2/sqrt(Hz)]"""
    @property
    def gyroscope_noise_density(self) -> float:
        """[rad/s/sqrt(Hz)]"""
    @property
    def accelerometer_random_walk(self) -> float:
        """Of the bias [m/s^3/sqrt(Hz)]."""
    @property
    def gyroscope_random_walk(self) -> float:
        """Of the bias [rad/s^2/sqrt(Hz)]."""

class Recording:
    """The measurements of a recording and, where known, the truth."""
    @property
    def name(self) -> str:
        """Of the recording."""
    @property
    def remarks(self) -> list[str]:
        """What the reader corrected, left out or counted."""
    @property
    def cameras(self) -> list[Camera]:
        """Those of the rig, in its order."""
    @property
    def imu_noise(self) -> Optional[ImuNoise]:
        """As the recording states it, or None."""
    @property
    def imu(self) -> dict[str, NDArray[Any]]:
        """{'time': (N,) int64 [ns], 'specific_force': (N, 3) [m/s^2], 'angular_rate': (N, 3) [rad/s]} in IMU axes."""
    @property
    def frame_times(self) -> Ints:
        """Of images or tracks: (N,) int64 [ns]."""
    @property
    def truth(self) -> dict[str, NDArray[Any]]:
        """world_T_imu: {'time': (N,) int64 [ns], 'position': (N, 3) [m], 'quaternion': (N, 4) x y z w}; empty where unknown, and without the quaternion where it has positions alone."""
    @staticmethod
    def from_arrays(*, imu_time: ArrayLike, angular_rate: ArrayLike, specific_force: ArrayLike, image_time: ArrayLike,
                    images: Union[Sequence[_Frame], NDArray[Any], Callable[[int], _Frame]],
                    cameras: Union[Camera, Sequence[Camera]], imu_noise: Optional[ImuNoise] = ...,
                    truth: Union[Mapping[str, Any], Path, None] = ..., truth_level: Optional[bool] = ...,
                    name: str = ...) -> Recording:
        """A recording of what is in memory. Times are (N,) ints [ns] or floats [s], on one clock, and rise.

        imu_time (N,), angular_rate (N, 3) [rad/s], specific_force (N, 3) [m/s^2]: in IMU axes. image_time (M,). images: of
        each frame one image, or a list with one for each camera; an image is an array (height, width) of uint8, an image of
        Pillow, whose colours become grey as those of files, the path of a file, or None. They are a sequence, an array (M, height, width) or (M, cameras, height, width), or a function
        images(i), which is called when a frame is needed, from any thread. cameras: a Camera, or a list of them. imu_noise:
        a run needs it. truth: columns `time`, `position` and, if known, `quaternion` of world_T_imu, or the path of a file
        as `chasles.read` takes it; truth_level: whether its z axis points up, where that is known.

        Raises InputError for shapes that do not fit, times that do not rise, rates that no sensor has (microseconds as ints)
        and numbers that are not finite. An image of another size than its camera's is an InputError where it is read; of a
        sequence, the first frame is examined at once."""
    def images(self, index: int) -> list[Optional[Image]]:
        """The images of a frame: for each camera an array (height, width) of uint8, or None."""
    def tracks(self, index: int) -> dict[str, NDArray[Any]]:
        """The observations of a frame of tracks: {'landmark': (N,), 'camera': (N,), 'pixel': (N, 2) or, of a rectified pair, (N, 4)}."""
    def __len__(self) -> int: ...

class Estimate:
    """The estimate of a frame."""
    @property
    def time(self) -> int:
        """On the IMU's clock [ns]."""
    @property
    def seconds(self) -> float:
        """On the IMU's clock [s]."""
    @property
    def world_T_imu(self) -> Floats:
        """(4, 4) [m]: maps IMU coordinates to the world's; z points up."""
    @property
    def position(self) -> Floats:
        """(3,) world [m]."""
    @property
    def quaternion(self) -> Floats:
        """(4,) x y z w of world_T_imu."""
    @property
    def velocity(self) -> Optional[Floats]:
        """(3,) world [m/s]."""
    @property
    def accelerometer_bias(self) -> Optional[Floats]:
        """(3,) [m/s^2]."""
    @property
    def gyroscope_bias(self) -> Optional[Floats]:
        """(3,) [rad/s]."""
    @property
    def covariance(self) -> Floats:
        """(n, n) of [theta; dp; dv; biases]: R = Exp(theta) R_hat, p = p_hat + dp, world axes."""
    @property
    def pose_covariance(self) -> Floats:
        """(6, 6) of [theta; dp] [rad, m]."""
    @property
    def map_T_imu(self) -> Optional[Floats]:
        """(4, 4) in the frame of the map, or None."""
    @property
    def world_T_map(self) -> Optional[Floats]:
        """(4, 4) frame of the map in the world (REP 105: odom_T_map), or None."""
    @property
    def health(self) -> str:
        """'ok', 'degraded' or 'lost'."""
    @property
    def nis(self) -> float:
        """Normalised innovation squared of the update."""
    @property
    def nis_dof(self) -> int:
        """Its degrees of freedom; 0: no update."""
    @property
    def observations(self) -> int:
        """Of the frame."""
    @property
    def used(self) -> int:
        """Observations that updated the state."""
    @property
    def rejected(self) -> int:
        """Observations that the gate rejected."""
    @property
    def landmarks(self) -> int:
        """Of the whole map."""

class PredictedState:
    """The motion after the last estimate, by the IMU."""
    @property
    def time(self) -> int:
        """On the IMU's clock [ns]."""
    @property
    def seconds_since_estimate(self) -> float:
        """Time since the last estimate [s]."""
    @property
    def world_T_imu(self) -> Floats:
        """(4, 4) [m]."""
    @property
    def position(self) -> Floats:
        """(3,) world [m]."""
    @property
    def quaternion(self) -> Floats:
        """(4,) x y z w of world_T_imu."""
    @property
    def velocity(self) -> Floats:
        """(3,) world [m/s]."""
    @property
    def angular_rate(self) -> Floats:
        """(3,) IMU axes, without bias [rad/s]."""
    @property
    def covariance(self) -> Floats:
        """(15, 15), as Estimate.covariance."""

class Slam:
    """Visual-inertial SLAM step by step. Any thread may call; estimators take turns, and other Python threads go on meanwhile."""
    def __init__(self, cameras: Union[Camera, Sequence[Camera]], noise: Optional[ImuNoise], *, estimator: str = ...,
                 map: Optional[Path] = ...,
        chart: str = ..., landmarks: Literal['cartesian', 'inverse-depth'] = ...,
        init: Literal['multi-view', 'fixed-depth'] = ..., nav_attitude: bool = ..., composition_interval: float = ...,
        first_estimates: Literal['auto', 'true', 'false'] = ..., first_order_transition: bool = ...,
        numeric_jacobians: bool = ..., keep_scale: Literal['auto', 'true', 'false'] = ...,
        pixel_sigma: Union[float, Literal['auto'], None] = ..., track_sigma: Union[float, Literal['auto'], None] = ...,
        track_drift: Union[float, Literal['auto'], None] = ..., match_sigma: Union[float, Literal['auto'], None] = ...,
        imu_noise_scale: Union[float, Literal['auto'], None] = ...,
        vibration_noise: Union[float, Literal['auto'], None] = ..., initial_tilt_sigma: float = ...,
        initial_velocity_sigma: float = ..., initial_accelerometer_bias_sigma: float = ...,
        initial_gyroscope_bias_sigma: float = ...,
        calibrate_extrinsics: Literal['auto', 'false', 'true', 'considered'] = ...,
        initial_extrinsic_rotation_sigma: float = ..., initial_extrinsic_translation_sigma: float = ...,
        calibrate_time_offset: Literal['auto', 'false', 'true', 'considered'] = ...,
        time_offset: Union[float, Literal['auto'], None] = ..., initial_time_offset_sigma: float = ...,
        calibrate_intrinsics: Literal['auto', 'false', 'true', 'considered'] = ..., initial_focal_sigma: float = ...,
        initial_principal_point_sigma: float = ..., initial_distortion_sigma: float = ...,
        readout_time: Union[float, Literal['auto'], None] = ...,
        calibrate_readout: Literal['auto', 'false', 'true', 'considered'] = ..., initial_readout_sigma: float = ...,
        calibrate_imu: Literal['auto', 'false', 'true', 'considered'] = ..., initial_imu_scale_sigma: float = ...,
        initial_imu_misalignment_sigma: float = ..., initial_g_sensitivity_sigma: float = ..., depth_rule: str = ...,
        fixed_depth: float = ..., fixed_depth_sigma: float = ..., inverse_depth: float = ...,
        inverse_depth_sigma: float = ..., guessed_depth_observations: Union[float, Literal['auto'], None] = ...,
        clones: int = ..., frames_per_clone: int = ..., clone_interval: float = ...,
        max_relative_depth_sigma: float = ..., max_total_depth_sigma: float = ..., min_parallax: float = ...,
        min_landmarks: int = ..., settled_depth_sigma: float = ..., zupt_velocity_sigma: float = ...,
        noise_inflation: float = ..., noise_inflation_frames: int = ..., gate: float = ..., max_rejections: int = ...,
        max_landmarks: int = ..., waiting_frames: int = ..., recognise: Literal['none', 'ids', 'appearance'] = ...,
        prior_map: Literal['estimated', 'considered'] = ..., recognisable: int = ...,
        exact_map: Literal['auto', 'true', 'false'] = ..., map_memory: float = ..., start: StartSettings = ...,
        frontend: FrontendSettings = ..., batch: BatchSettings = ...) -> None:
        """cameras: a Camera, or a list of them; noise: ImuNoise; estimator: 'filter', 'window:N' or 'batch'; map: file of a saved map; and settings by name, as chasles.settings() lists them."""
    def add_imu(self, time: Union[Time, NDArray[Any]], angular_rate: ArrayLike,
                specific_force: ArrayLike) -> list[Estimate]:
        """A sample, or (N,) of them. Times are ints [ns] or floats [s]; angular rates [rad/s] and specific forces [m/s^2] in IMU axes: (3,) or (N, 3). Returns the estimates of the images that waited for them."""
    def add_images(self, time: Time, images: Union[Image, Sequence[Any]]) -> list[Estimate]:
        """The images of all cameras at one instant: arrays (height, width) of uint8, images of Pillow, or None; of one camera also its image alone. Returns the estimates that are ready."""
    def predicted(self, time: Time) -> Optional[PredictedState]:
        """The state at a time since the last estimate, by the samples (PredictedState). None before a start, before the last estimate's time, .5 s after the last sample, 5 s after the estimate, where the estimate is lost, and where samples are missing for more than .5 s."""
    def finish(self) -> list[Estimate]:
        """The estimates of the images that still wait, and the end of the Slam, which takes nothing after it. With estimator='batch' they are the final estimates of all frames, which replace those that the other calls have returned."""
    @property
    def started(self) -> bool:
        """Whether there is an estimate."""
    @property
    def why_not_started(self) -> str:
        """The conditions of a start that are not met."""
    @property
    def waiting(self) -> int:
        """Number of images that wait for samples."""
    @property
    def counts(self) -> dict[str, int]:
        """{'samples', 'samples_not_finite', 'samples_late', 'samples_dropped', 'images', 'images_late', 'images_uncovered'}: what came, and what of it gives no estimate: late is what is not later than what was used; uncovered are images without samples until their time."""
    @property
    def landmarks(self) -> dict[str, NDArray[Any]]:
        """{'id': (N,), 'position': (N, 3) world [m], 'covariance': (N, 3, 3), 'observations': (N,)}."""

class RealtimeSlam:
    """Slam on a thread of its own: calls return at once, and images that the estimator has no time for are dropped. Any thread may call."""
    def __init__(self, cameras: Union[Camera, Sequence[Camera]], noise: Optional[ImuNoise], *, estimator: str = ...,
                 map: Optional[Path] = ..., most_images: int = ...,
        chart: str = ..., landmarks: Literal['cartesian', 'inverse-depth'] = ...,
        init: Literal['multi-view', 'fixed-depth'] = ..., nav_attitude: bool = ..., composition_interval: float = ...,
        first_estimates: Literal['auto', 'true', 'false'] = ..., first_order_transition: bool = ...,
        numeric_jacobians: bool = ..., keep_scale: Literal['auto', 'true', 'false'] = ...,
        pixel_sigma: Union[float, Literal['auto'], None] = ..., track_sigma: Union[float, Literal['auto'], None] = ...,
        track_drift: Union[float, Literal['auto'], None] = ..., match_sigma: Union[float, Literal['auto'], None] = ...,
        imu_noise_scale: Union[float, Literal['auto'], None] = ...,
        vibration_noise: Union[float, Literal['auto'], None] = ..., initial_tilt_sigma: float = ...,
        initial_velocity_sigma: float = ..., initial_accelerometer_bias_sigma: float = ...,
        initial_gyroscope_bias_sigma: float = ...,
        calibrate_extrinsics: Literal['auto', 'false', 'true', 'considered'] = ...,
        initial_extrinsic_rotation_sigma: float = ..., initial_extrinsic_translation_sigma: float = ...,
        calibrate_time_offset: Literal['auto', 'false', 'true', 'considered'] = ...,
        time_offset: Union[float, Literal['auto'], None] = ..., initial_time_offset_sigma: float = ...,
        calibrate_intrinsics: Literal['auto', 'false', 'true', 'considered'] = ..., initial_focal_sigma: float = ...,
        initial_principal_point_sigma: float = ..., initial_distortion_sigma: float = ...,
        readout_time: Union[float, Literal['auto'], None] = ...,
        calibrate_readout: Literal['auto', 'false', 'true', 'considered'] = ..., initial_readout_sigma: float = ...,
        calibrate_imu: Literal['auto', 'false', 'true', 'considered'] = ..., initial_imu_scale_sigma: float = ...,
        initial_imu_misalignment_sigma: float = ..., initial_g_sensitivity_sigma: float = ..., depth_rule: str = ...,
        fixed_depth: float = ..., fixed_depth_sigma: float = ..., inverse_depth: float = ...,
        inverse_depth_sigma: float = ..., guessed_depth_observations: Union[float, Literal['auto'], None] = ...,
        clones: int = ..., frames_per_clone: int = ..., clone_interval: float = ...,
        max_relative_depth_sigma: float = ..., max_total_depth_sigma: float = ..., min_parallax: float = ...,
        min_landmarks: int = ..., settled_depth_sigma: float = ..., zupt_velocity_sigma: float = ...,
        noise_inflation: float = ..., noise_inflation_frames: int = ..., gate: float = ..., max_rejections: int = ...,
        max_landmarks: int = ..., waiting_frames: int = ..., recognise: Literal['none', 'ids', 'appearance'] = ...,
        prior_map: Literal['estimated', 'considered'] = ..., recognisable: int = ...,
        exact_map: Literal['auto', 'true', 'false'] = ..., map_memory: float = ..., start: StartSettings = ...,
        frontend: FrontendSettings = ..., batch: BatchSettings = ...) -> None:
        """cameras: a Camera, or a list of them; noise: ImuNoise; estimator: 'filter', 'window:N' or 'batch'; map: file of a saved map; and settings by name, as chasles.settings() lists them."""
    def add_imu(self, time: Union[Time, NDArray[Any]], angular_rate: ArrayLike, specific_force: ArrayLike) -> None:
        """A sample, or (N,) of them. Times are ints [ns] or floats [s]; angular rates [rad/s] and specific forces [m/s^2] in IMU axes: (3,) or (N, 3)."""
    def add_images(self, time: Time, images: Union[Image, Sequence[Any]]) -> int:
        """The images of all cameras at one instant: arrays (height, width) of uint8, images of Pillow, or None; of one camera also its image alone. Where more than most_images wait, the oldest are dropped; returns how many."""
    def take(self) -> list[Estimate]:
        """The estimates since the last call."""
    def predicted(self, time: Time) -> Optional[PredictedState]:
        """The state at a time since the last estimate, by the samples (PredictedState). None before a start, before the last estimate's time, .5 s after the last sample, 5 s after the estimate, where the estimate is lost, and where samples are missing for more than .5 s."""
    def finish(self) -> list[Estimate]:
        """Waits until all that has come is processed; returns the estimates not yet taken. With estimator='batch' the final estimates of all frames follow them and replace them."""
    @property
    def counts(self) -> dict[str, int]:
        """Images: {'came', 'taken', 'dropped', 'waiting'}, and of what was taken those of Slam.counts."""
    @property
    def why_not_started(self) -> str:
        """The conditions of a start that are not met."""
    @property
    def landmarks(self) -> dict[str, NDArray[Any]]:
        """As Slam.landmarks."""

class ChartState:
    """The parts of a state that an error chart moves."""
    R: Floats
    p: Floats
    v: Floats
    points: Floats
    def __init__(self, R: ArrayLike, p: ArrayLike, v: ArrayLike, points: ArrayLike) -> None: ...

class FirstSight:
    """A point that is seen for the first time."""
    @property
    def pixel(self) -> Floats:
        """(2,) [px]."""
    @property
    def camera(self) -> int:
        """Index of the camera."""
    @property
    def inverse(self) -> bool:
        """Whether the landmark has an inverse depth [1/m] or a depth [m]."""
    @property
    def world_T_camera(self) -> Floats:
        """(4, 4) [m]."""
    @property
    def ray(self) -> Floats:
        """(3,): (x/z, y/z, 1) in the camera's axes."""
    @property
    def points(self) -> Floats:
        """(N, 3): landmarks of the state, world [m]."""

class Run:
    """The results of a run."""
    @property
    def name(self) -> str:
        """(arg0: chasles._core.Run) -> str"""
    @property
    def states(self) -> dict[str, Any]:
        """(arg0: chasles._core.Run) -> dict"""
    @property
    def smoothed(self) -> dict[str, NDArray[Any]]:
        """(arg0: chasles._core.Run) -> dict"""
    @property
    def in_map(self) -> dict[str, NDArray[Any]]:
        """(arg0: chasles._core.Run) -> dict"""
    @property
    def landmarks(self) -> dict[str, NDArray[Any]]:
        """(arg0: chasles._core.Run) -> dict"""
    @property
    def truth(self) -> dict[str, NDArray[Any]]:
        """(arg0: chasles._core.Run) -> dict"""
    def _states_at(self, times: ArrayLike, smoothed: bool, longest_gap: float) -> dict[str, Any]: ...
    @property
    def _summary(self) -> str: ...
    @property
    def _frame_times(self) -> Ints: ...
    @property
    def _level(self) -> bool: ...
    def _check_map(self) -> None: ...
    def save(self, folder: Path) -> None: ...
    def page(self) -> str: ...

def evaluate(time: ArrayLike, position: ArrayLike, quaternion: ArrayLike, truth_time: ArrayLike,
             truth_position: ArrayLike, truth_quaternion: ArrayLike, pose_covariance: Optional[ArrayLike], chart: str,
             level: bool) -> dict[str, Optional[float]]: ...
def truth_errors(time: ArrayLike, position: ArrayLike, quaternion: ArrayLike, truth_time: ArrayLike,
                 truth_position: ArrayLike, truth_quaternion: ArrayLike, pose_covariance: Optional[ArrayLike],
                 chart: str, level: bool) -> str: ...
def align(time: ArrayLike, position: ArrayLike, quaternion: ArrayLike, truth_time: ArrayLike, truth_position: ArrayLike,
          truth_quaternion: ArrayLike, alignment: str) -> dict[str, Any]: ...
def chart_names() -> list[str]: ...
def in_python(message: str) -> str: ...
def settings(kind: str) -> dict[str, dict[str, str]]: ...
def read(path: Path, *, start: Optional[float] = ..., stop: Optional[float] = ..., backwards: bool = ...,
         cameras: str = ..., truth: Path = ..., truth_level: str = ..., pairing: str = ...,
         max_truth_gap: Optional[float] = ..., truth_time_offset: str = ..., truth_frame: str = ...,
         truth_scale: Optional[float] = ..., truth_inverse: bool = ...) -> Recording: ...
def join_imu(gyro_time: Any, angular_rate: Any, accel_time: Any, specific_force: Any) -> dict[str, Any]: ...
def run(recording: Recording, path: Path, progress: Optional[_Advance], /, **arguments: Any) -> Run: ...
def calibrate_cameras(corners: ArrayLike, times: Sequence[Any], cameras: Sequence[int], ids: Sequence[Sequence[int]],
                      pixels: Sequence[ArrayLike], sizes: Sequence[Tuple[int, int]], lenses: Sequence[str],
                      start: Sequence[Camera], bend: bool) -> Tuple[str, list[Camera], dict[str, NDArray[Any]], dict[str, NDArray[Any]]]: ...
def calibrate_imu_cameras(corners: ArrayLike, times: Sequence[Any], cameras: Sequence[int], ids: Sequence[Sequence[int]],
                          pixels: Sequence[ArrayLike], sizes: Sequence[Tuple[int, int]], lenses: Sequence[str],
                          start: Sequence[Camera], bend: bool, imu: Recording, noise: ImuNoise, gravity: float,
                          rolling: bool, exact_imu: bool
                          ) -> Tuple[str, list[Camera], dict[str, NDArray[Any]], dict[str, NDArray[Any]], Floats, Floats]: ...
def calibrate_from_motion(recording: Recording, from_nothing: bool) -> Tuple[str, list[Camera], float, str]: ...
def check(recording: Recording, seconds: float, calibration: bool, progress: Optional[_Advance]) -> Tuple[str, str]: ...
def calibrate_noise(recording: Recording, start: Optional[float], stop: Optional[float], standstill: bool
                    ) -> Tuple[str, str, str, str, dict[str, dict[str, Floats]]]: ...
def recording_of_imu(time: NDArray[Any], specific_force: ArrayLike, angular_rate: ArrayLike) -> Recording: ...
def read_for_imu(path: Path) -> Recording: ...
def errors(run: Run, truth_time: ArrayLike, truth_position: ArrayLike, truth_quaternion: ArrayLike,
           chart: str, attitudes: bool) -> dict[str, NDArray[Any]]: ...
def recording_of(name: str, imu_time: NDArray[Any], angular_rate: ArrayLike, specific_force: ArrayLike,
                 image_time: NDArray[Any], images: Callable[[int], Sequence[Any]], check_first: bool,
                 cameras: Sequence[Camera], imu_noise: Optional[ImuNoise], truth_time: NDArray[Any],
                 truth_position: ArrayLike, truth_quaternion: ArrayLike, truth_level: Optional[bool],
                 truth_file: Path) -> Recording: ...
def read_run(folder: Path) -> Run: ...
def page(runs: Sequence[Tuple[str, Run]]) -> str: ...
def register_chart(name: str, chart: Any) -> None: ...
def register_depth_rule(name: str, rule: Callable[[FirstSight], Optional[Tuple[float, float]]]) -> None: ...
