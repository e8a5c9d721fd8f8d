"""The settings as types, for the keys of dictionaries. Written by tools/python-types: do not edit."""

from __future__ import annotations

import os
from typing import Literal, Optional, TypedDict, Union

_Path = Union[str, "os.PathLike[str]"]


class StartSettings(TypedDict, total=False):
    """Settings of the prefix `start`."""

    heading: Union[float, Literal['auto'], None]
    """direction of the first camera's view at the first estimate, counter-clockwise from nav's x axis, such as from a
    compass (docs/initialisation.md); auto: nav's axes are those of the initialisation [rad]; default auto"""
    heading_sigma: float
    """sigma of that heading; 0: it defines nav [rad]; default 0"""
    position_x: float
    """of the IMU at the first estimate, in nav, such as on a floor plan [m]; default 0"""
    position_y: float
    """as position_x [m]; default 0"""
    position_z: float
    """as position_x [m]; default 0"""
    position_sigma: float
    """sigma of that position; 0: it defines nav [m]; default 0"""
    in_map: bool
    """heading and position are those in the map of an earlier run (docs/recognition.md): the run begins there, and does
    not search for its place; default false"""
    tilt_sigma: float
    """upper limit of a start's sigma of roll and pitch [rad]; default 0.2"""
    velocity_sigma: float
    """upper limit of a start's sigma of the velocity [m/s]; default 2"""
    accelerometer_bias_sigma: float
    """sigma of the prior of that bias, mean 0 [m/s^2]; default 0.1"""
    gyroscope_bias_sigma: float
    """sigma of the prior of that bias, mean 0 [rad/s]; default 0.1"""
    gravity: float
    """its magnitude [m/s^2]; default 9.80665"""
    inflation: float
    """dynamic initialisation: the information of the window's data is divided by this, because the filter uses them
    again; default 10"""
    static_window: float
    """static initialisation: duration of the standstill [s]; default 0.75"""
    static_noise_factor: float
    """static initialisation: the samples scatter by at most so many times the stated noise; default 6"""
    static_displacement: float
    """static initialisation: half of the tracks move by less than this, beyond their noise [px]; default 0.5"""
    static_velocity_sigma: float
    """sigma of the velocity 0 [m/s]; default 0.02"""
    min_window: float
    """shortest window of a dynamic initialisation, with one camera [s]; default 1"""
    min_stereo_window: float
    """the same where two cameras observe the same tracks [s]; default 0.6"""
    max_window: float
    """longest window: older data are dropped [s]; default 5"""
    attempt_frames: int
    """a start is attempted at every n-th frame; default 5"""
    keyframes: int
    """number of frames of the window that are used; default 20"""
    max_tracks: int
    """maximum number that is used, those with most views; default 60"""
    min_tracks: int
    """minimum number that fits the motion; default 12"""
    min_parallax: float
    """median over the tracks, without the rotation [px]; default 8"""
    min_parallax_angle: float
    """the same as an angle [rad]; default 0.015"""
    max_gravity_deviation: float
    """maximum error of gravity's magnitude, estimated without this constraint [m/s^2]; default 1.5"""
    max_scale_sigma: float
    """posterior sigma of the velocity, relative to the speed; default 0.1"""
    least_velocity_sigma: float
    """a sigma of the velocity that suffices at any speed [m/s]; default 0.03"""
    max_tilt_sigma: float
    """posterior sigma of roll and pitch [rad]; default 0.02"""
    max_misfit: float
    """squared residuals per degree of freedom; default 1.6"""
    min_inliers: float
    """fraction of the observations that fit the motion; default 0.35"""


class FrontendSettings(TypedDict, total=False):
    """Settings of the prefix `frontend`."""

    corners: Literal['harris', 'shi-tomasi']
    """the measure that ranks corners; default harris"""
    equalisation: Literal['none', 'histogram', 'clahe']
    """of the grey levels, before all other steps; tracking itself is insensitive to gain and offset; default none"""
    mask: str
    """image of a camera's size, black where nothing is to be tracked (a robot's own arm); for a rig one file per
    camera, separated by commas; empty: none; default"""
    max_tracks: int
    """maximum number at a time, shared by the cameras that find tracks; default 150"""
    grid_columns: int
    """of cells over which the tracks are spread; default 10"""
    grid_rows: int
    """of cells over which the tracks are spread; default 6"""
    cells_per_frame: int
    """cells searched for corners in a frame, unless half of the tracks are gone; default 15"""
    min_distance: float
    """of a new corner to every track [px]; default 15"""
    border: float
    """at the image's edge where nothing is tracked [px]; default 8"""
    min_corner_gradient: float
    """a corner's mean (rms) gradient in its weakest direction [grey levels/px]; default 3"""
    window: int
    """side of a track's patch, odd [px]; default 15"""
    levels: int
    """of the image pyramid, each half as large; default 4"""
    predicted_levels: int
    """used where the gyroscope predicts the position of a track; all where that fails; default 1"""
    min_correlation: float
    """minimum correlation of a patch with the one that is found; default 0.9"""
    max_backward_error: float
    """maximum distance of a patch that is followed to the new image and back [px]; default 0.7"""
    max_gap: float
    """tracks end after this time without a usable image (missing, black, saturated) [s]; default 0.5"""
    patch_frames: int
    """a track's patch is kept for so many images while it fits, and searched in every third of them, so that errors of
    single steps do not accumulate; 1 or 2: only each image's patch in the next one; default 30"""
    min_kept_correlation: float
    """minimum correlation of a patch with the one that is kept; otherwise the track ends. Lower where noise lowers it
    between images as well; default 0.95"""
    max_stretch: float
    """a track ends when its patch is longer or shorter by this factor than at its beginning; default 1.6"""
    reject_outliers: bool
    """two-view check of all tracks together; default true"""
    outlier_threshold: float
    """distance to the epipolar line of motion [px]; default 1"""
    stereo: bool
    """find tracks in the other cameras whose views overlap; default true"""
    epipolar_threshold: float
    """distance to the epipolar line of the rig [px]; default 1"""
    min_stereo_depth: float
    """nearest point that is searched [m]; default 0.3"""


class BatchSettings(TypedDict, total=False):
    """Settings of the prefix `batch`."""

    landmarks: Literal['cartesian', 'inverse-depth']
    """form of a landmark: a point of the world, or a ray and an inverse depth in the first keyframe that observes it;
    default inverse-depth"""
    frames_per_keyframe: int
    """every n-th frame is a keyframe; the others are not used; default 1"""
    loops: bool
    """a landmark that returns into view is the same one; false: a new one, as in the filter; default true"""
    inverse_depth_sigma: float
    """prior of an inverse depth: mean 0 with this sigma [1/m]; default 10"""
    min_parallax: float
    """smallest parallax of a landmark; of an anchored one only where the search starts from the filter's estimates
    [rad]; default 0.01"""
    loss: Literal['none', 'huber', 'cauchy']
    """robust loss of a pixel's residual; default huber"""
    loss_width: Union[float, Literal['auto'], None]
    """threshold of that loss, in standard deviations of a pixel; auto: 2.5, 1 with the noise of images, or 0.5 where
    the noise was estimated from stereo tracks (docs/batch.md); default auto"""
    gate: Union[float, Literal['auto'], None]
    """pixels with larger residuals, in standard deviations, after the search has roughly converged are rejected; 0: no
    gate; auto: 5, or 2 with the noise of images; default auto"""
    max_rejections: int
    """a landmark that the gate rejects in so many keyframes in a row is split when its pixels agree again (visual-
    inertial batch only); default 5"""
    covariance_factor: Union[float, Literal['auto'], None]
    """factor of the covariances of a visual-inertial batch or window; auto: measured from the walk of the residuals
    along the tracks, at least 1; 1 with rendered images (docs/covariance.md); default auto"""
    solver: Literal['auto', 'sparse-schur', 'dense-schur', 'sparse-normal']
    """linear solver: landmarks first, or the ordering with the least fill (auto, except for few keyframes); default
    auto"""
    max_iterations: int
    """maximum number of Levenberg-Marquardt steps; default 100"""
    tolerance: float
    """the search has converged when the next step should lower the cost by less than this fraction; default 1e-08"""
    chart: str
    """error chart of the steps; filter: that of the filter's settings; default filter"""
    initial_error: float
    """error that is added to the initial states, as a fraction: drift [rad], scale, depths (studies/convergence.md);
    default 0"""
    seed: int
    """of that error [number]; default 1"""
    window_steps: int
    """maximum number of Gauss-Newton steps of a window per frame; default 2"""
    window_precision: float
    """there are fewer where the window's minimum is predicted to be nearer than this, in standard deviations; 0: by
    batch.tolerance alone; default 0.05"""


class ReaderSettings(TypedDict, total=False):
    """Settings of the prefix `reader`."""

    stale_pixels: Literal['cut', 'keep']
    """observations of an ECE276A archive that repeat those of the frame before: cut drops them and ends their
    landmarks, keep uses them as recorded; default cut"""
    extrinsics: Literal['auto', 'recorded']
    """cam_T_imu of an ECE276A archive: auto takes the interpretation that agrees with the data, recorded the matrix as
    it is; default auto"""


class FilterSettings(TypedDict, total=False):
    """Settings of the filter with an IMU, by name."""

    chart: str
    """error chart: coordinates of the error state (docs/charts.md); default right-sen3"""
    landmarks: Literal['cartesian', 'inverse-depth']
    """form of a landmark in the state; default inverse-depth"""
    init: Literal['multi-view', 'fixed-depth']
    """landmark initialisation: delayed, after several clones have observed the point, or undelayed, at an assumed
    depth; default multi-view"""
    nav_attitude: bool
    """the world is the first IMU frame, and its attitude relative to gravity is estimated (K&S); false: the world's z
    axis points up; default false"""
    composition_interval: float
    """interval at which the world is moved to the IMU (needs nav_attitude); 0: never [s]; default 0"""
    first_estimates: Literal['auto', 'true', 'false']
    """first-estimates Jacobians (for the chart standard); auto: where extrinsics, intrinsics or a readout are
    estimated; default auto"""
    first_order_transition: bool
    """the covariance is propagated by I + F tau, in the chart's coordinates (K&S, eq. 14, 15; not with right-sen3);
    false: by the exact transition; default false"""
    numeric_jacobians: bool
    """derivatives of a pixel by finite differences in the chart's coordinates (K&S, IV-C; for Cartesian landmarks of
    fixed-depth); false: analytic ones; default false"""
    keep_scale: Literal['auto', 'true', 'false']
    """keeps the scale unobservable by pixels in the covariance (docs/filter.md; not with left-se3); auto: with the
    images of one camera; default auto"""
    pixel_sigma: Union[float, Literal['auto'], None]
    """standard deviation of a pixel [px]; default auto"""
    track_sigma: Union[float, Literal['auto'], None]
    """standard deviation of a pixel in updates, with errors that many tracks share (docs/noise.md); auto: with images
    3, or 4 in batch and window, if no pixel_sigma is stated; else pixel_sigma [px]; default auto"""
    track_drift: Union[float, Literal['auto'], None]
    """density of the random walk by which a tracked point slides over its surface (docs/noise.md); the filter alone has
    it; auto: 2 with images, 0 with tracks [px/sqrt(s)]; default auto"""
    match_sigma: Union[float, Literal['auto'], None]
    """constant error, along a track, of the matches in the cameras after the first (docs/noise.md); auto: 1 with
    images, 0 with tracks [px]; default auto"""
    imu_noise_scale: Union[float, Literal['auto'], None]
    """factor on the IMU's stated noise densities; auto: 3 with images, 1 with tracks and where the stated noise is
    exact; default auto"""
    vibration_noise: Union[float, Literal['auto'], None]
    """factor on the variance that vibration and motion add to the IMU's stated noise (docs/noise.md); auto: 1 with
    images, 0 with tracks and where the stated noise is exact; default auto"""
    initial_tilt_sigma: float
    """initial sigma of roll and pitch [rad]; default 0.002"""
    initial_velocity_sigma: float
    """initial sigma of the velocity [m/s]; default 0.05"""
    initial_accelerometer_bias_sigma: float
    """initial sigma of that bias [m/s^2]; default 0.02"""
    initial_gyroscope_bias_sigma: float
    """initial sigma of that bias [rad/s]; default 0.005236"""
    calibrate_extrinsics: Literal['auto', 'false', 'true', 'considered']
    """estimate the extrinsics of each camera, starting from the recording's calibration; considered: only count their
    uncertainty; auto: false; default false"""
    initial_extrinsic_rotation_sigma: float
    """initial sigma of the rotation about each axis [rad]; default 0.02"""
    initial_extrinsic_translation_sigma: float
    """initial sigma of the translation along each axis [m]; default 0.02"""
    calibrate_time_offset: Literal['auto', 'false', 'true', 'considered']
    """estimate the cameras' time offset, starting from time_offset; considered: only count its uncertainty; auto: the
    filter estimates it with images; default auto"""
    time_offset: Union[float, Literal['auto'], None]
    """added to the time of an image to get the IMU's time (Kalibr: timeshift_cam_imu); auto: 0, or what the tracks of a
    recording show, where that is beyond 10 ms [s]; default auto"""
    initial_time_offset_sigma: float
    """initial sigma of the time offset [s]; default 0.005"""
    calibrate_intrinsics: Literal['auto', 'false', 'true', 'considered']
    """calibrate_extrinsics for focal lengths, principal point and lens of each camera; auto: false; default false"""
    initial_focal_sigma: float
    """initial sigma of a focal length, over itself; default 0.004"""
    initial_principal_point_sigma: float
    """initial sigma of each coordinate of the principal point [px]; default 3"""
    initial_distortion_sigma: float
    """initial sigma of each coefficient of the lens model; of tangential and prism terms a tenth; default 0.01"""
    readout_time: Union[float, Literal['auto'], None]
    """of a rolling shutter, all lines (docs/inertial.md); 0: a global one; below 0: upwards; auto: as the recording
    states it, or else as its images show it [s]; default auto"""
    calibrate_readout: Literal['auto', 'false', 'true', 'considered']
    """calibrate_intrinsics for the readout time of each rolling shutter; auto: if a run measures it beforehand; default
    auto"""
    initial_readout_sigma: float
    """initial sigma of a readout time [s]; default 0.001"""
    calibrate_imu: Literal['auto', 'false', 'true', 'considered']
    """calibrate_extrinsics for scales, misalignments and g-sensitivity of the IMU, on top of its stated intrinsics;
    auto: false; default false"""
    initial_imu_scale_sigma: float
    """initial sigma of the scale of each axis of accelerometer and gyroscope; 0: known; default 0.005"""
    initial_imu_misalignment_sigma: float
    """initial sigma of each angle by which these axes are misaligned; 0: known [rad]; default 0.002"""
    initial_g_sensitivity_sigma: float
    """initial sigma of what a specific force along each axis adds to each angular rate; 0: none [rad/s/(m/s^2)];
    default 0.0002"""
    depth_rule: str
    """depth of an undelayed landmark initialisation: constant, as the next settings have it, or a rule that the program
    has registered (docs/python.md); default constant"""
    fixed_depth: float
    """assumed depth of an undelayed landmark initialisation (K&S: 8) [m]; default 8"""
    fixed_depth_sigma: float
    """sigma of that depth, along the ray [m]; default 3"""
    inverse_depth: float
    """assumed inverse depth of an undelayed landmark initialisation [1/m]; default 0.1"""
    inverse_depth_sigma: float
    """sigma of that inverse depth [1/m]; default 0.5"""
    guessed_depth_observations: Union[float, Literal['auto'], None]
    """the product of the errors of an assumed depth and of the motion adds to the pixel noise, times the number of
    observations, up to this number; 0: not at all; auto: 20 in a filter with images, else 0; default auto"""
    clones: int
    """maximum number of clones for delayed landmark initialisation; default 15"""
    frames_per_clone: int
    """every n-th frame's pose becomes a clone; default 4"""
    clone_interval: float
    """and the pose of the first frame after this time, where frames are rarer or have no image [s]; default 0.2"""
    max_relative_depth_sigma: float
    """a track becomes a landmark when its pixels determine the relative depth to this sigma; default 0.2"""
    max_total_depth_sigma: float
    """and when the relative depth has this sigma with the uncertainty of the poses; default 0.3"""
    min_parallax: float
    """and when its rays differ by this angle (parallax) [rad]; default 0.02"""
    min_landmarks: int
    """while the state has fewer, landmarks are initialised without delay, in anchored inverse depth; default 12"""
    settled_depth_sigma: float
    """an anchored landmark becomes Cartesian when its relative depth has this sigma; 0: never; default 0.03"""
    zupt_velocity_sigma: float
    """sigma of the velocity in a zero-velocity update, for one second of standstill; 0: no zero-velocity updates [m/s];
    default 0.01"""
    noise_inflation: float
    """measurement noise inflation: a young landmark's pixel noise is multiplied by 1 + noise_inflation, decreasing to 1
    over noise_inflation_frames; default 0"""
    noise_inflation_frames: int
    """see noise_inflation; default 20"""
    gate: float
    """of a correct observation to pass the gate; 1: no gate [probability]; default 0.999"""
    max_rejections: int
    """a landmark that the gate rejects so often in a row is retired; default 5"""
    max_landmarks: int
    """maximum number in the state; below 4, with as few min_landmarks: mainly null-space updates; default 50"""
    waiting_frames: int
    """a landmark out of view stays in the state for so many frames; default 0"""
    recognise: Literal['none', 'ids', 'appearance']
    """landmarks that come into view again return into the state with their exact covariance, which closes loops
    (docs/recognition.md): none, those whose ids the tracks have again, or those that look the same in the images of the
    first camera; default none"""
    prior_map: Literal['estimated', 'considered']
    """a map of an earlier run (--map) is estimated further, or considered: no update changes it, while its uncertainty
    counts as before (Schmidt-Kalman filter, docs/recognition.md); default estimated"""
    recognisable: int
    """recognise: most landmarks out of the state that may be recognised by their appearance; beyond, they are thinned
    out; default 1500"""
    exact_map: Literal['auto', 'true', 'false']
    """landmarks out of the state and the poses of the past are estimated given all measurements (docs/map.md); false:
    landmarks keep their last estimate, and there is no smoothed path; auto: a filter does so for a recording; default
    auto"""
    map_memory: float
    """exact_map: bound on the memory; beyond it the oldest landmarks and poses are final; 0: no bound [MB]; default
    1000"""
    batch: BatchSettings


class RunSettings(FilterSettings, total=False):
    """Settings of a run, by name: chasles.run(recording, **settings)."""

    mode: Literal['localize', 'map', 'slam']
    """predict only; map along the predicted trajectory, taken as true; or both jointly; default slam"""
    velocity: Literal['measured', 'input']
    """a body velocity measures a velocity in the state, or is the input that is integrated; default measured"""
    hold: Literal['midpoint', 'zero-order']
    """an input velocity over its step: mean of both ends, or the first; default midpoint"""
    velocity_sigma: Union[float, Literal['auto'], None]
    """white noise (sigma) of a velocity sample [m/s]; default auto"""
    rate_sigma: Union[float, Literal['auto'], None]
    """white noise (sigma) of an angular velocity sample [rad/s]; default auto"""
    velocity_relative_sigma: float
    """additional sigma of a velocity sample, relative to the speed; default 0.004"""
    velocity_walk: Union[float, Literal['auto'], None]
    """random walk of the true velocity [m/s/sqrt(s)]; default auto"""
    rate_walk: Union[float, Literal['auto'], None]
    """random walk of the true angular velocity [rad/s/sqrt(s)]; default auto"""
    gyro_bias: bool
    """estimate the bias of the angular velocity; default true"""
    gyro_bias_sigma: Union[float, Literal['auto'], None]
    """initial sigma of that bias [rad/s]; default auto"""
    gyro_bias_walk: Union[float, Literal['auto'], None]
    """random walk of that bias [rad/s/sqrt(s)]; default auto"""
    velocity_scale: bool
    """estimate the scale of the velocity; default false"""
    velocity_scale_sigma: float
    """initial sigma of that scale; default 0.01"""
    velocity_scale_walk: float
    """random walk of that scale [1/sqrt(s)]; default 0"""
    velocity_axes: Literal['auto', 'imu', 'level']
    """axes of the velocities: the IMU's, or level ones with its heading; auto: from their vertical components
    (docs/noise.md); default auto"""
    tilt_sigma: float
    """initial sigma of the IMU's tilt, where velocities are along level axes [rad]; default 0.05"""
    tilt_walk: float
    """random walk of that [rad/sqrt(s)]; default 0.001"""
    velocity_heading_sigma: float
    """initial sigma of the heading of level axes relative to the IMU's [rad]; default 0.0005"""
    velocity_heading_walk: float
    """random walk of that [rad/sqrt(s)]; default 0"""
    initial_pose_sigma: float
    """initial sigma of the pose; 0: the world is the first pose [rad, m]; default 0"""
    stereo_rows: Literal['all', 'mean+disparity', 'mean']
    """rows of (uL, vL, uR, vR) that update the state: all four, means and disparity, or means; default mean"""
    disparity_sigma: Union[float, Literal['auto'], None]
    """sigma of a disparity [px]; default auto"""
    disparity_inflation: Union[float, Literal['auto'], None]
    """factor on that sigma in updates, because a disparity's error hardly changes along a track; default auto"""
    loose_gate: float
    """gate of a frame in which fewer than gate_quorum observations pass `gate` [probability]; default 0.99"""
    gate_quorum: int
    """see loose_gate; default 15"""
    updates_per_frame: int
    """maximum number of observations that update the state, longest unused landmarks first; 0: all; default 20"""
    min_disparity: float
    """no landmark is initialised below it [px]; default 1"""
    waiting_landmarks: int
    """landmarks out of view stay in the state while it has fewer in all; default 24"""
    update_with_first_observation: bool
    """use the observation that initialises a landmark for an update as well (Du; counts it twice); default false"""
    initial_landmark_sigma: Union[float, Literal['auto'], None]
    """fixed and uncorrelated (Du); auto: from the observation and the pose [m]; default auto"""
    compress_map: bool
    """false: one dense covariance over the whole map, whose cost grows with it; default true"""
    start: StartSettings
    frontend: FrontendSettings
    reader: ReaderSettings


class RunArguments(RunSettings, total=False):
    """Arguments of chasles.run besides the recording, for chasles.compare."""

    estimator: str
    threads: int
    begin: Literal['auto', 'truth']
    as_recorded: bool
    map: Optional[_Path]
    save_map: Optional[_Path]
    keep_images: Optional[int]
    config: Optional[_Path]
    progress: Optional[bool]


class FilterArguments(FilterSettings, total=False):
    """Settings of a filter of chasles.monte_carlo, and its estimator."""

    estimator: str


class SceneSettings(TypedDict, total=False):
    """Settings of a scene with an IMU."""

    name: str
    """name of the recording; default hallway"""
    geometry: Literal['hallway', 'turntable', 'trajectory', 'walk']
    """hallway, turntable, trajectory, or walk; default hallway"""
    seed: int
    """chooses the landmarks and, with the run, all noise; default 1"""
    knot_interval: float
    """of the spline that is the true motion [s]; default 0.05"""
    rest_duration: float
    """standstill before the motion begins [s]; default 0"""
    start_duration: float
    """from standstill to full speed; 0 without rest_duration: in motion from the first sample [s]; default 0"""
    hall_length: float
    """of the centre line's rectangle [m]; default 30"""
    hall_width: float
    """of the centre line's rectangle [m]; default 12"""
    corridor_width: float
    """from wall to wall [m]; default 3"""
    corridor_height: float
    """from floor to ceiling [m]; default 2.8"""
    imu_height: float
    """above the floor [m]; default 1.2"""
    sections: int
    """straight sections that are walked, each with its turn; default 4"""
    walking_speed: float
    """along the centre line [m/s]; default 1.2"""
    turn_duration: float
    """of a turn of 90 degrees [s]; default 1.3"""
    step_rate: float
    """of the walker's steps [Hz]; default 2"""
    bob_amplitude: float
    """up and down with every step [m]; default 0.025"""
    sway_amplitude: float
    """to the sides, with every second step [m]; default 0.02"""
    roll_amplitude: float
    """about the forward axis, every second step [rad]; default 0.015"""
    pitch_amplitude: float
    """about the left axis, every step [rad]; default 0.012"""
    yaw_amplitude: float
    """about the upward axis, every second step [rad]; default 0.03"""
    wall_density: float
    """landmarks on walls, floor and ceiling [1/m^2]; default 4"""
    walk_duration: float
    """of the walk with its standstill; 0: all sections [s]; default 0"""
    circle_radius: float
    """of the circle around the cube's centre [m]; default 8"""
    revolutions: float
    """around the cube; default 2"""
    revolution_duration: float
    """of one revolution [s]; default 17.5"""
    radial_sway: float
    """towards the cube and away from it [m]; default 0.6"""
    vertical_sway: float
    """up and down [m]; default 0.5"""
    gaze_sway: float
    """of the line of sight about the cube's centre [rad]; default 0.03"""
    cube_edge: float
    """of the cube [m]; default 1.5"""
    cube_landmarks: int
    """on its faces; default 40"""
    visible_landmarks: int
    """visible from each part of the path; default 75"""
    landmark_spacing: float
    """between two searches for missing landmarks [s]; default 0.5"""
    landmark_nearest: float
    """depth at which a landmark is placed, least [m]; default 2"""
    landmark_farthest: float
    """depth at which a landmark is placed, most [m]; default 10"""
    cameras: int
    """of the rig; default 1"""
    rig: Literal['side-by-side', 'back-to-back', 'ring']
    """side-by-side; back-to-back: every second camera looks backward; ring: turned by equal angles about the upward
    axis, to the left; default side-by-side"""
    baseline: float
    """between neighbours side by side [m]; default 0.2"""
    frame_rate: float
    """of the frames [Hz]; default 28"""
    focal_length: float
    """fx = fy [px]; default 480"""
    center_u: float
    """principal point, to the right [px]; default 349.5"""
    center_v: float
    """principal point, down [px]; default 270"""
    image_width: int
    """of the images [px]; default 699"""
    image_height: int
    """of the images [px]; default 540"""
    camera_x: float
    """first camera in the IMU frame, forward [m]; default 0.05"""
    camera_y: float
    """first camera in the IMU frame, to the left [m]; default 0.02"""
    camera_z: float
    """first camera in the IMU frame, up [m]; default 0.03"""
    camera_tilt_x: float
    """rotation vector, IMU axes; 0: straight ahead [rad]; default 0"""
    camera_tilt_y: float
    """as camera_tilt_x [rad]; default 0"""
    camera_tilt_z: float
    """as camera_tilt_x [rad]; default 0"""
    distortion: Literal['none', 'radtan', 'equidistant', 'ds', 'eucm', 'omni', 'fov', 'division', 'fisheye624']
    """of the lenses (docs/calibration-conventions.md); default none"""
    distortion_1: float
    """first coefficient of the lens model, in its order; default 0"""
    distortion_2: float
    """second coefficient of the lens model, in its order; default 0"""
    distortion_3: float
    """third coefficient of the lens model, in its order; default 0"""
    distortion_4: float
    """fourth coefficient of the lens model, in its order; default 0"""
    distortion_5: float
    """fifth coefficient of the lens model, in its order; default 0"""
    distortion_6: float
    """sixth coefficient of the lens model, in its order; default 0"""
    distortion_7: float
    """seventh coefficient of the lens model, in its order; default 0"""
    distortion_8: float
    """eighth coefficient of the lens model, in its order; default 0"""
    distortion_9: float
    """ninth coefficient of the lens model, in its order; default 0"""
    distortion_10: float
    """tenth coefficient of the lens model, in its order; default 0"""
    distortion_11: float
    """eleventh coefficient of the lens model, in its order; default 0"""
    distortion_12: float
    """twelfth coefficient of the lens model, in its order; default 0"""
    readout_time: float
    """of a rolling shutter, all lines; the time of an image is that of its first line; 0: a global shutter [s]; default
    0"""
    readout_direction: Literal['down', 'up', 'right', 'left']
    """in which the lines are read: down, up, right or left; default down"""
    landmarks_in_view: int
    """tracks that are kept up at a time; default 35"""
    shortest_track: int
    """no track begins whose landmark leaves the view sooner [frames]; default 5"""
    image_border: float
    """no landmark nearer to the image's edge [px]; default 5"""
    min_range: float
    """no landmark nearer to the camera [m]; default 4"""
    max_range: float
    """no landmark farther from the camera [m]; default 15"""
    occlusion: bool
    """walls and the cube hide what is behind them; default true"""
    keep_ids: bool
    """a landmark that returns keeps its number; default false"""
    imu_rate: float
    """of the IMU's samples [Hz]; default 100"""
    imu_convention: Literal['instant', 'interval-mean', 'instant-force']
    """meaning of a sample: instant, interval-mean or instant-force; default instant"""
    accelerometer_noise_density: float
    """white noise [m/s^2/sqrt(Hz)]; default 0.007355"""
    gyroscope_noise_density: float
    """white noise [rad/s/sqrt(Hz)]; default 9.774e-05"""
    accelerometer_random_walk: float
    """of the bias [m/s^3/sqrt(Hz)]; default 0.0001"""
    gyroscope_random_walk: float
    """of the bias [rad/s^2/sqrt(Hz)]; default 1e-05"""
    accelerometer_bias_sigma: float
    """of the bias at the beginning [m/s^2]; default 0.02"""
    gyroscope_bias_sigma: float
    """of the bias at the beginning [rad/s]; default 0.005236"""
    pixel_sigma: float
    """white noise on each of u and v [px]; default 1"""
    track_drift: float
    """random walk of u and of v along a track, alike in all cameras [px/sqrt(s)]; default 0"""
    match_sigma: float
    """constant error of u and of v along a track, in the second camera [px]; default 0"""
    outlier_fraction: float
    """observations at random positions in the image; default 0"""
    dropped_fraction: float
    """frames without an observation; tracks continue after them; default 0"""
    texel_size: float
    """of the surfaces' textures; larger where there are too many [m]; default 0.005"""
    texture_period: float
    """walls, floors and ceilings look alike, and repeat after this length: identical doors; 0: no two places look alike
    [m]; default 0"""
    texture_changed: float
    """share of every surface that looks otherwise than with 0, in strips of 1 to 3 m: a building that was redecorated
    in part; default 0"""
    exposure: float
    """brightness of the images; default 1"""
    exposure_drift: float
    """by which the brightness wanders, up and down [stops]; default 0"""
    vignetting: float
    """light that the image's corners lack; default 0"""
    readout_noise: float
    """white noise of a pixel, of 256 shades [shades]; default 1"""
    photon_noise: float
    """variance of a pixel a shade of its brightness [shades]; default 0.01"""
    exposure_time: float
    """of each image, which blurs the motion; 0: an instant [s]; default 0"""
    blur_samples: int
    """number of instants averaged in a blurred image; default 8"""


class StreetSettings(TypedDict, total=False):
    """Settings of a street."""

    name: str
    """name of the recording; default street"""
    seed: int
    """chooses all random numbers: landmarks and noise; default 1"""
    route: str
    """turn at each crossing: L, R, or S straight on; default LLLSRRR"""
    block_length: float
    """between crossings along x, the first direction of travel [m]; default 100"""
    block_width: float
    """between crossings along y [m]; default 80"""
    corner_length: float
    """length of the path of a turn of 90 degrees [m]; default 20"""
    cruise_speed: float
    """speed between the corners [m/s]; default 8"""
    corner_speed: float
    """speed in the corners [m/s]; default 4"""
    acceleration: float
    """mean of a change of speed; the peak is 35/16 of it [m/s^2]; default 1.5"""
    stop_every: int
    """stop before every n-th turn; 0: never [corners]; default 3"""
    stop_duration: float
    """how long a stop lasts [s]; default 3"""
    road_amplitude: float
    """height of the road's waves [m]; default 0.15"""
    road_wavelength: float
    """length of the road's waves [m]; default 60"""
    roll_amplitude: float
    """swaying about the forward axis [rad]; default 0.02"""
    pitch_amplitude: float
    """swaying about the left axis [rad]; default 0.015"""
    sway_wavelength: float
    """distance travelled during one period of the swaying [m]; default 25"""
    street_width: float
    """from facade to facade [m]; default 20"""
    facade_height: float
    """of the buildings, above the road's mean [m]; default 9"""
    imu_height: float
    """of the IMU above the road [m]; default 0.93"""
    focal_length: float
    """fx = fy [px]; default 707.0912"""
    center_u: float
    """principal point, to the right [px]; default 601.8873"""
    center_v: float
    """principal point, down [px]; default 183.1104"""
    image_width: int
    """of both images [px]; default 1241"""
    image_height: int
    """of both images [px]; default 376"""
    baseline: float
    """from the left camera to the right one [m]; default 0.53715"""
    camera_x: float
    """left camera in the IMU frame, forward [m]; default 1.1439"""
    camera_y: float
    """left camera in the IMU frame, to the left [m]; default -0.3127"""
    camera_z: float
    """left camera in the IMU frame, up [m]; default 0.7265"""
    camera_tilt_x: float
    """rotation vector, IMU axes; 0: straight ahead [rad]; default -0.0068"""
    camera_tilt_y: float
    """as camera_tilt_x [rad]; default 0.0085"""
    camera_tilt_z: float
    """as camera_tilt_x [rad]; default -0.0011"""
    frame_rate: float
    """of the frames [Hz]; default 10"""
    features_per_frame: int
    """tracks that are kept up at a time; default 70"""
    track_life: float
    """mean of a track's life, were its landmark always in view [s]; default 8"""
    shortest_track: int
    """a track starts only if its landmark stays in view for so long [frames]; default 5"""
    image_border: float
    """no feature nearer to the image's edge [px]; default 5"""
    min_depth: float
    """no feature nearer to the left camera [m]; default 2.5"""
    max_depth: float
    """no feature farther from the left camera [m]; default 60"""
    velocities_per_frame: int
    """body velocities a frame, at equal distances in time; default 1"""
    linear_sigma: float
    """white noise on each component, a sample [m/s]; default 0.5"""
    angular_sigma: float
    """white noise on each component, a sample [rad/s]; default 0.05"""
    gyro_bias_x: float
    """constant error of the angular velocity [rad/s]; default 0.003"""
    gyro_bias_y: float
    """as gyro_bias_x [rad/s]; default -0.004"""
    gyro_bias_z: float
    """as gyro_bias_x [rad/s]; default 0.007"""
    velocity_scale: float
    """measured linear velocity over the true one; default 1"""
    pixel_sigma: float
    """white noise on each of uL, vL, uR, vR [px]; default 0.5"""
    disparity_sigma: float
    """error of uL - uR that stays constant along a track [px]; default 0"""
    outlier_fraction: float
    """observations at random positions in the images; default 0.02"""
    moving_fraction: float
    """tracks on objects that move along the street; default 0"""
    moving_speed: float
    """of such objects [m/s]; default 6"""
    dropped_fraction: float
    """frames without an observation; all tracks end there; default 0"""
