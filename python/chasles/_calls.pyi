"""Types of _calls.py, with all settings. Written by tools/python-types: do not edit."""

from concurrent.futures import Executor as _Executor
from typing import Literal, Mapping, Optional, Union

from ._core import Path as _Path, Recording
from ._run import Run
from ._settings import (
    FilterArguments,
    RunArguments,
    BatchSettings,
    FrontendSettings,
    ReaderSettings,
    StartSettings,
)
from .lab import Comparison, Study


def simulate(
        scene: str = ..., *, run: int = ..., images: bool = ..., progress: Optional[bool] = ...,
        name: str = ..., geometry: Literal['hallway', 'turntable', 'trajectory', 'walk'] = ..., seed: int = ...,
        knot_interval: float = ..., rest_duration: float = ..., start_duration: float = ..., hall_length: float = ...,
        hall_width: float = ..., corridor_width: float = ..., corridor_height: float = ..., imu_height: float = ...,
        sections: int = ..., walking_speed: float = ..., turn_duration: float = ..., step_rate: float = ...,
        bob_amplitude: float = ..., sway_amplitude: float = ..., roll_amplitude: float = ...,
        pitch_amplitude: float = ..., yaw_amplitude: float = ..., wall_density: float = ..., walk_duration: float = ...,
        circle_radius: float = ..., revolutions: float = ..., revolution_duration: float = ...,
        radial_sway: float = ..., vertical_sway: float = ..., gaze_sway: float = ..., cube_edge: float = ...,
        cube_landmarks: int = ..., visible_landmarks: int = ..., landmark_spacing: float = ...,
        landmark_nearest: float = ..., landmark_farthest: float = ..., cameras: int = ...,
        rig: Literal['side-by-side', 'back-to-back', 'ring'] = ..., baseline: float = ..., frame_rate: float = ...,
        focal_length: float = ..., center_u: float = ..., center_v: float = ..., image_width: int = ...,
        image_height: int = ..., camera_x: float = ..., camera_y: float = ..., camera_z: float = ...,
        camera_tilt_x: float = ..., camera_tilt_y: float = ..., camera_tilt_z: float = ...,
        distortion: Literal['none', 'radtan', 'equidistant', 'ds', 'eucm', 'omni', 'fov', 'division', 'fisheye624'] = ...,
        distortion_1: float = ..., distortion_2: float = ..., distortion_3: float = ..., distortion_4: float = ...,
        distortion_5: float = ..., distortion_6: float = ..., distortion_7: float = ..., distortion_8: float = ...,
        distortion_9: float = ..., distortion_10: float = ..., distortion_11: float = ..., distortion_12: float = ...,
        readout_time: float = ..., readout_direction: Literal['down', 'up', 'right', 'left'] = ...,
        landmarks_in_view: int = ..., shortest_track: int = ..., image_border: float = ..., min_range: float = ...,
        max_range: float = ..., occlusion: bool = ..., keep_ids: bool = ..., imu_rate: float = ...,
        imu_convention: Literal['instant', 'interval-mean', 'instant-force'] = ...,
        accelerometer_noise_density: float = ..., gyroscope_noise_density: float = ...,
        accelerometer_random_walk: float = ..., gyroscope_random_walk: float = ...,
        accelerometer_bias_sigma: float = ..., gyroscope_bias_sigma: float = ..., pixel_sigma: float = ...,
        track_drift: float = ..., match_sigma: float = ..., outlier_fraction: float = ...,
        dropped_fraction: float = ..., texel_size: float = ..., texture_period: float = ...,
        texture_changed: float = ..., exposure: float = ..., exposure_drift: float = ..., vignetting: float = ...,
        readout_noise: float = ..., photon_noise: float = ..., exposure_time: float = ..., blur_samples: int = ...,
        route: str = ..., block_length: float = ..., block_width: float = ..., corner_length: float = ...,
        cruise_speed: float = ..., corner_speed: float = ..., acceleration: float = ..., stop_every: int = ...,
        stop_duration: float = ..., road_amplitude: float = ..., road_wavelength: float = ...,
        sway_wavelength: float = ..., street_width: float = ..., facade_height: float = ...,
        features_per_frame: int = ..., track_life: float = ..., min_depth: float = ..., max_depth: float = ...,
        velocities_per_frame: int = ..., linear_sigma: float = ..., angular_sigma: float = ...,
        gyro_bias_x: float = ..., gyro_bias_y: float = ..., gyro_bias_z: float = ..., velocity_scale: float = ...,
        disparity_sigma: float = ..., moving_fraction: float = ..., moving_speed: float = ...,
) -> Recording:
    """A simulated recording: tracks, or rendered images with images=True. Equal scenes with another run have other
    noise. Settings by name, as settings("scene") and, for streets, settings("street") list them. progress: a bar (tqdm),
    True or False; None draws one on a terminal and in a notebook where tqdm is installed. Ctrl-C ends it."""
    ...


def run(
        recording: Union[Recording, _Path], *,
        estimator: str = ..., threads: int = ..., begin: Literal['auto', 'truth'] = ..., as_recorded: bool = ...,
        map: Optional[_Path] = ..., save_map: Optional[_Path] = ..., keep_images: Optional[int] = ...,
        mode: Optional[str] = ..., config: Optional[_Path] = ..., progress: Optional[bool] = ...,
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
        exact_map: Literal['auto', 'true', 'false'] = ..., map_memory: float = ...,
        velocity: Literal['measured', 'input'] = ..., hold: Literal['midpoint', 'zero-order'] = ...,
        velocity_sigma: Union[float, Literal['auto'], None] = ...,
        rate_sigma: Union[float, Literal['auto'], None] = ..., velocity_relative_sigma: float = ...,
        velocity_walk: Union[float, Literal['auto'], None] = ..., rate_walk: Union[float, Literal['auto'], None] = ...,
        gyro_bias: bool = ..., gyro_bias_sigma: Union[float, Literal['auto'], None] = ...,
        gyro_bias_walk: Union[float, Literal['auto'], None] = ..., velocity_scale: bool = ...,
        velocity_scale_sigma: float = ..., velocity_scale_walk: float = ...,
        velocity_axes: Literal['auto', 'imu', 'level'] = ..., tilt_sigma: float = ..., tilt_walk: float = ...,
        velocity_heading_sigma: float = ..., velocity_heading_walk: float = ..., initial_pose_sigma: float = ...,
        stereo_rows: Literal['all', 'mean+disparity', 'mean'] = ...,
        disparity_sigma: Union[float, Literal['auto'], None] = ...,
        disparity_inflation: Union[float, Literal['auto'], None] = ..., loose_gate: float = ..., gate_quorum: int = ...,
        updates_per_frame: int = ..., min_disparity: float = ..., waiting_landmarks: int = ...,
        update_with_first_observation: bool = ..., initial_landmark_sigma: Union[float, Literal['auto'], None] = ...,
        compress_map: bool = ..., start: StartSettings = ..., frontend: FrontendSettings = ...,
        batch: BatchSettings = ..., reader: ReaderSettings = ...,
) -> Run:
    """Runs an estimator over a recording (Recording, or a path) as `chasles run` does, to the bit, and returns a Run.

    estimator: "filter", "window:N" or "batch". map, save_map: files of maps (docs/recognition.md). begin: "auto", or
    "truth". as_recorded: clock, axes and shutter as stated (docs/cameras.md). progress: a bar (tqdm), True or False; None
    draws one on a terminal and in a notebook where tqdm is installed. Settings by name, as settings() lists them; those
    with a prefix as a dictionary: start={"heading": 0}.
    Raises UsageError for a setting that does not exist, with the nearest one, or that cannot be used;
    NotInitialisedError where the run never started, with the conditions that are not met. Where the map cannot be
    saved, the Run is the attribute `run` of the error. Ctrl-C ends it with KeyboardInterrupt. Other threads run
    meanwhile."""
    ...


def compare(
        recording: Union[Recording, _Path], estimators: Mapping[str, RunArguments], *,
        estimator: str = ..., threads: int = ..., begin: Literal['auto', 'truth'] = ..., as_recorded: bool = ...,
        map: Optional[_Path] = ..., save_map: Optional[_Path] = ..., keep_images: Optional[int] = ...,
        mode: Optional[str] = ..., config: Optional[_Path] = ..., progress: Optional[bool] = ...,
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
        exact_map: Literal['auto', 'true', 'false'] = ..., map_memory: float = ...,
        velocity: Literal['measured', 'input'] = ..., hold: Literal['midpoint', 'zero-order'] = ...,
        velocity_sigma: Union[float, Literal['auto'], None] = ...,
        rate_sigma: Union[float, Literal['auto'], None] = ..., velocity_relative_sigma: float = ...,
        velocity_walk: Union[float, Literal['auto'], None] = ..., rate_walk: Union[float, Literal['auto'], None] = ...,
        gyro_bias: bool = ..., gyro_bias_sigma: Union[float, Literal['auto'], None] = ...,
        gyro_bias_walk: Union[float, Literal['auto'], None] = ..., velocity_scale: bool = ...,
        velocity_scale_sigma: float = ..., velocity_scale_walk: float = ...,
        velocity_axes: Literal['auto', 'imu', 'level'] = ..., tilt_sigma: float = ..., tilt_walk: float = ...,
        velocity_heading_sigma: float = ..., velocity_heading_walk: float = ..., initial_pose_sigma: float = ...,
        stereo_rows: Literal['all', 'mean+disparity', 'mean'] = ...,
        disparity_sigma: Union[float, Literal['auto'], None] = ...,
        disparity_inflation: Union[float, Literal['auto'], None] = ..., loose_gate: float = ..., gate_quorum: int = ...,
        updates_per_frame: int = ..., min_disparity: float = ..., waiting_landmarks: int = ...,
        update_with_first_observation: bool = ..., initial_landmark_sigma: Union[float, Literal['auto'], None] = ...,
        compress_map: bool = ..., start: StartSettings = ..., frontend: FrontendSettings = ...,
        batch: BatchSettings = ..., reader: ReaderSettings = ...,
) -> Comparison:
    """Runs several estimators over a recording (Recording, or a path) and returns a Comparison.

    estimators: {name: {argument of chasles.run: value}}; common: arguments of all of them."""
    ...


def monte_carlo(
        scene: str, filters: Mapping[str, FilterArguments], *, runs: int, first: int = ...,
        workers: int = ..., folder: Optional[_Path] = ..., executor: Optional[_Executor] = ...,
        attempts: int = ..., progress: Optional[bool] = ...,
        name: str = ..., geometry: Literal['hallway', 'turntable', 'trajectory', 'walk'] = ..., seed: int = ...,
        knot_interval: float = ..., rest_duration: float = ..., start_duration: float = ..., hall_length: float = ...,
        hall_width: float = ..., corridor_width: float = ..., corridor_height: float = ..., imu_height: float = ...,
        sections: int = ..., walking_speed: float = ..., turn_duration: float = ..., step_rate: float = ...,
        bob_amplitude: float = ..., sway_amplitude: float = ..., roll_amplitude: float = ...,
        pitch_amplitude: float = ..., yaw_amplitude: float = ..., wall_density: float = ..., walk_duration: float = ...,
        circle_radius: float = ..., revolutions: float = ..., revolution_duration: float = ...,
        radial_sway: float = ..., vertical_sway: float = ..., gaze_sway: float = ..., cube_edge: float = ...,
        cube_landmarks: int = ..., visible_landmarks: int = ..., landmark_spacing: float = ...,
        landmark_nearest: float = ..., landmark_farthest: float = ..., cameras: int = ...,
        rig: Literal['side-by-side', 'back-to-back', 'ring'] = ..., baseline: float = ..., frame_rate: float = ...,
        focal_length: float = ..., center_u: float = ..., center_v: float = ..., image_width: int = ...,
        image_height: int = ..., camera_x: float = ..., camera_y: float = ..., camera_z: float = ...,
        camera_tilt_x: float = ..., camera_tilt_y: float = ..., camera_tilt_z: float = ...,
        distortion: Literal['none', 'radtan', 'equidistant', 'ds', 'eucm', 'omni', 'fov', 'division', 'fisheye624'] = ...,
        distortion_1: float = ..., distortion_2: float = ..., distortion_3: float = ..., distortion_4: float = ...,
        distortion_5: float = ..., distortion_6: float = ..., distortion_7: float = ..., distortion_8: float = ...,
        distortion_9: float = ..., distortion_10: float = ..., distortion_11: float = ..., distortion_12: float = ...,
        readout_time: float = ..., readout_direction: Literal['down', 'up', 'right', 'left'] = ...,
        landmarks_in_view: int = ..., shortest_track: int = ..., image_border: float = ..., min_range: float = ...,
        max_range: float = ..., occlusion: bool = ..., keep_ids: bool = ..., imu_rate: float = ...,
        imu_convention: Literal['instant', 'interval-mean', 'instant-force'] = ...,
        accelerometer_noise_density: float = ..., gyroscope_noise_density: float = ...,
        accelerometer_random_walk: float = ..., gyroscope_random_walk: float = ...,
        accelerometer_bias_sigma: float = ..., gyroscope_bias_sigma: float = ..., pixel_sigma: float = ...,
        track_drift: float = ..., match_sigma: float = ..., outlier_fraction: float = ...,
        dropped_fraction: float = ..., texel_size: float = ..., texture_period: float = ...,
        texture_changed: float = ..., exposure: float = ..., exposure_drift: float = ..., vignetting: float = ...,
        readout_noise: float = ..., photon_noise: float = ..., exposure_time: float = ..., blur_samples: int = ...,
        route: str = ..., block_length: float = ..., block_width: float = ..., corner_length: float = ...,
        cruise_speed: float = ..., corner_speed: float = ..., acceleration: float = ..., stop_every: int = ...,
        stop_duration: float = ..., road_amplitude: float = ..., road_wavelength: float = ...,
        sway_wavelength: float = ..., street_width: float = ..., facade_height: float = ...,
        features_per_frame: int = ..., track_life: float = ..., min_depth: float = ..., max_depth: float = ...,
        velocities_per_frame: int = ..., linear_sigma: float = ..., angular_sigma: float = ...,
        gyro_bias_x: float = ..., gyro_bias_y: float = ..., gyro_bias_z: float = ..., velocity_scale: float = ...,
        disparity_sigma: float = ..., moving_fraction: float = ..., moving_speed: float = ...,
) -> Study:
    """Executes `runs` runs of a scene through all filters, and returns a Study. In each run all filters have the same
    landmarks, noise and initial errors.

    filters: {name: {setting: value}}, with "estimator" among the settings. settings: those of the scene. folder: where
    the study is kept, as `chasles montecarlo -o` does; a temporary one if none is given. workers: processes; 1 where a
    chart or depth rule is written in Python. executor: any concurrent.futures.Executor instead of them, as for `batch`;
    the bytes are the same. progress: a bar, as in `run`. Ctrl-C ends it with KeyboardInterrupt."""
    ...
