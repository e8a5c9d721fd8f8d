"""What is right for each input of ../shared/cases/reports: the rules that studies/reports.py applies, and nothing
else. studies/reports.md explains the columns.

A rule reads: name, what is right (for the page), how `chasles run` must end, what it must say, what `chasles check`
must say. The last two are regular expressions for one line of errors, remarks or findings; a "!" before that for
`check` means that it must not say so.

ends      near: exit 0, an error near that of the intact piece, and its frames
          error: exit 1, 2 or 3 with an error that says it
          near or reported: near, or any end with a message that says it
          any: whatever it does, it says it
at        the input that is named, below the folder that the generator makes
like      the run of the intact piece to compare with
moved     (ns, START) -> ns: the time of the truth's pose in this input
healthy   False: `run` must not call itself healthy
lines     no more lines of messages than this"""

import dataclasses
import typing


@dataclasses.dataclass(frozen=True)
class Rule:
    name: str
    right: str
    end: str = "near"
    says: str = ""
    finds: str = ""
    at: str = ""
    like: str = "intact"
    factor: float = 1.5
    moved: typing.Callable = lambda ns, start: ns
    healthy: bool = True
    lines: int = 1000
    arguments: tuple = ()


def read(name, right="read", says="", **more):
    return Rule(name, right, "near", says, **more)


def reported(name, right, says, **more):
    """Rejected, and the message says it; `check` says it too."""
    return Rule(name, right, "error", says, more.pop("finds", says), **more)


def either(name, right, says, **more):
    return Rule(name, right, "near or reported", says, **more)


def shown(name, right, says="", **more):
    return Rule(name, right, "any", says, **more)


# --- the intact piece, to compare with ---------------------------------------------------------------------

INTACT = [Rule("intact", "-", "any"), Rule("intact, mono", "-", "any", arguments=("--cameras", "mono"))]

# --- single files that people hand over --------------------------------------------------------------------

VIDEO, UNKNOWN = "(?i)video|movie|MP4", "no known kind"
FILES = [
    reported("GX010042.MP4", "the error calls it a video", VIDEO),
    reported("rgb.mov", "the error calls it a video", VIDEO),
    reported("VID.insv", "the error calls it a video", VIDEO),
    reported("log_12.ulg", "the error calls it a log of PX4", "(?i)ULog|PX4"),
    reported("00000042.BIN", "the error names the kind, or calls it unknown", f"(?i)ArduPilot|DataFlash|{UNKNOWN}"),
    reported("rec.vrs", "the error calls it VRS", r"\bVRS\b"),
    reported("rec.svo2", "the error calls it a recording of ZED's SDK", "SVO|ZED"),
    reported("rec.svo", "the error calls it a recording of ZED's SDK", "SVO|ZED"),
    reported("MH_01_easy.zip", "the error asks to unpack it", "(?i)unpack|unzip|extract"),
    reported("dataset-room1_512_16.tar", "the error asks to unpack it", "(?i)unpack|tar -x|extract"),
    reported("walk.bag.gz", "read as a bag, which this one is not: the error reports what is wrong with the bag", r"(?i)gzip|\bbag\b|truncated|not closed|first message"),
    reported("old.bag", "the error asks for `rosbag fix`", "rosbag fix"),
    reported("active.bag.active", "read as a bag: the error reports what is missing", "(?i)not closed|reindex|first message|camchain"),
    reported("empty.mcap", "the error calls it empty", "(?i)empty|0 bytes"),
    reported("empty.db3", "the error calls it empty", "(?i)empty|0 bytes"),
    reported("lfs.mcap", "the error calls it a pointer of Git LFS", "LFS"),
    reported("login.bag", "the error calls it a web page", "HTML|(?i:web page)"),
    reported("rec.jsonl", "the error names the kind, or calls it unknown", f"(?i)JSON|{UNKNOWN}"),
    reported("imu.npy", "the error names the kind, or calls it unknown", f"(?i)NumPy|npy|{UNKNOWN}"),
    reported("rec.h5", "the error names the kind, or what it was taken for", r"(?i)HDF5|\.mat file"),
    reported("rec.parquet", "the error names the kind, or calls it unknown", f"(?i)parquet|{UNKNOWN}"),
    reported("oak.rrd", "the error names the kind, or calls it unknown", f"(?i)rerun|rrd|{UNKNOWN}"),
    reported("foxglove.mcap", "the error names the missing calibration, or the schema", "(?i)foxglove|protobuf|camchain"),
    reported("json.mcap", "the error names the missing calibration, or the encoding", "(?i)encoding|serialised|camchain"),
]

# --- folders and tables ------------------------------------------------------------------------------------

DIGITS = "(?i)digits|rounded|spreadsheet|exponent|precision|different time"
FOLDERS = [
    read("imu_seconds", "read"),
    reported("imu_float_ns", "rejected with the reason: times rounded to 10 s", DIGITS),
    either("imu_no_header", "read, or a message that the first line must name the columns", "(?i)expected a line with"),
    read("imu_semicolon", "read"),
    read("imu_tabs", "read"),
    read("imu_quoted", "read"),
    read("imu_spaces", "read"),
    read("imu_mars", "read"),
    either("imu_mars_name", "read, or a message that asks to rename gyro_accel.csv", "(?i)rename"),
    either("imu_fused_ios", "read with gravity added, or a message that `g` is gravity", "(?i)gravity"),
    shown("gravity_removed", "`check` reports that gravity was removed", finds="(?i)gravity"),
    read("sensor_logger", "read from two tables, with a remark", "(?i)interpolat|two tables|Gyroscope.csv|accelerometer"),
    read("two_tables", "read from two tables, with a remark", "(?i)interpolat"),
    reported("imu_excel", "rejected with the reason: times rounded by a spreadsheet", DIGITS),
    either("imu_excel15", "read: 10 µs do not matter", DIGITS),
    read("imu_deg_g", "read in deg/s and g"),
    either("imu_ros2_echo", "read, or a message: what the table lacks", "(?i)head|column"),
    read("imu_bagpy", "read"),
    either("imu_plotjuggler", "read, or a message: the names of columns", "(?i)has the columns"),
    read("images_seconds", "read"),
    reported("images_numbered", "the error asks for the times", r"(?i)times\.(csv|txt)|number"),
    reported("images_frame_n", "the error asks for the times", r"(?i)times\.(csv|txt)"),
    either("images_left_right", "read, or a message: where images belong", "(?i)images/cam0"),
    either("images_flat", "read, or a message: where images belong", "(?i)images/cam0", like="intact, mono"),
    either("images_us", "read, or a message that names are microseconds", "(?i)microsecond"),
    either("times_txt", "read, or a message: what table is expected", r"times\.(txt|csv)"),
    read("times_seconds", "read"),
    reported("uzh_fpv", "the error names the layout or the missing calibration", "(?i)UZH|calibration|camchain"),
    either("uzh_fpv_kalibr", "read, or a message: the command that converts it", "(?i)UZH|left_images.txt"),
    reported("tum_rgbd", "the error reports that there is no gyroscope", "(?i)TUM RGB-?D|gyroscope"),
    either("orbslam_own", "read, or the calibration named", "(?i)ORB-?SLAM|MH.yaml|data.csv", like="intact, mono"),
    either("vins_bag", "read, or the calibration named", "(?i)VINS", at="walk.mcap"),
    either("orb_bag", "read, or the calibration named", "(?i)ORB-?SLAM", at="walk.mcap", like="intact, mono"),
    reported("kitti_like", "the error names what is missing", "(?i)calib|KITTI"),
    either("msd", "read, or the calibration named", "(?i)Basalt|calibration.json"),
    either("basalt_bag", "read, or the calibration named", "(?i)Basalt|calibration.json", at="walk.mcap"),
    read("openvins", "read", at="walk.mcap"),
    shown("openvins_imu_offset", "applied or rejected, and reported", "(?i)time_offset|late|offset", at="walk.mcap"),
    reported("openvins_tg_identity", "the error names Tg", r"\bTg\b", at="walk.mcap"),
    shown("openvins_tg_small", "applied or rejected, and reported", r"\bTg\b|corrected by the IMU.s intrinsics", at="walk.mcap"),
    read("openvins_named_others", "read", at="walk.mcap"),
    read("openvins_subfolder", "read", at="walk.mcap"),
    reported("kalibr_results_txt", "the error names the calibration that is missing", "(?i)camchain|CameraInfo", at="walk.mcap"),
    read("kalibr_camera_only_timeshift", "read"),
]

# --- contents of messages ----------------------------------------------------------------------------------

STAMPS = "(?i)one stamp|same stamp|same time|one time|batch|spread|burst"
SLOW = "(?i)too slow"
SIM = 12_000_000_000  # case_sim_time begins then


def jump(ns):
    """The truth of `jump` in make_messages_bag.py: times from 3 s on are moved."""
    return lambda t, start: t + (ns if t > start + 3_000_000_000 else 0)


MESSAGES = [
    read("nan_covariance", "read"),
    reported("orientation_only", "the error reports that there are no rates and accelerations", "(?i)orientation|attitude|all zero|only zeros"),
    shown("gravity_removed", "`check` reports that gravity was removed", finds="(?i)gravity"),
    either("two_imus", "read, or asked to choose one", "(?i)topic"),
    read("imu_50hz", "read"),
    reported("imu_20hz", "the error reports that the IMU is too slow", SLOW),
    reported("imu_0p2hz", "the error reports that the IMU is too slow", SLOW),
    read("imu_dropped_bursts", "read"),
    read("imu_batches", "spread over the interval, with a remark", STAMPS),
    read("imu_pairs", "spread over the interval, with a remark", STAMPS),
    shown("imu_jitter", "run, or a message", finds="(?i)jitter|interval|stamp|rotate"),
    shown("frd", "`check` finds the axes", finds="(?i)axes|frame|rotat|turn"),
    read("sim_time", "read", moved=lambda t, start: t - start + SIM),
    shown("clock_back_0p7", "an error or a remark", "(?i)back|order|clock|restart", moved=jump(-700_000_000)),
    shown("clock_forward_1h", "an error or a remark", "(?i)gap|pause|clock|restart", moved=jump(3600_000_000_000)),
    shown("clock_back_5s", "an error or a remark", "(?i)back|order|clock|restart", moved=jump(-5_000_000_000)),
    shown("clock_forward_0p3", "an error or a remark", "(?i)gap|pause|clock|restart|without", moved=jump(300_000_000)),
    read("zero_some_stamps", "read without these images, with a remark", "(?i)stamp"),
    read("jpeg", "read"),
    read("jpeg_long", "read"),
    read("jpeg_mono", "read"),
    read("jpeg_progressive", "read"),
    read("jpeg_empty_format", "read"),
    read("png_long", "read"),
    reported("h264", "decoded, or the format in one line (this one is no video)", "(?i)h264|h\\.264", lines=4),
    either("webp", "decoded, or the format in one line", "(?i)webp", lines=4),
    reported("ffmpeg_packets", "the error names the format (this one is no video)", "(?i)ffmpeg|h264", lines=4),
    read("compressed_depth_beside", "read"),
    read("padded_rows", "read"),
    read("mono16_big", "read"),
    read("mono16_10bit", "read"),
    read("yuyv", "read"),
    read("yuyv_ros1_name", "read"),
    either("mono10", "read, or the encoding named", "mono10"),
    either("32fc1", "read, or the encoding named", "32FC1"),
    read("8sc1", "read"),
    either("rgb_unnamed", "read, or the encoding named", "(?i)encoding"),
    reported("half_size", "the error has both sizes", "376"),
    read("raw_and_compressed", "the complete topic, with a remark", "compressed"),
    read("repeated_frames", "read once"),
]

# --- containers --------------------------------------------------------------------------------------------

ROS2 = [
    read("zstd_file", "read", at="walk"),
    read("zstd_unpacked", "the plain file is read", at="walk"),
    read("zstd_unpacked_only", "read", at="walk"),
    read("zstd_message_mcap", "read", at="walk"),
    either("zstd_message_db3_lone", "read, or a message that the messages are compressed", "(?i)zstd|compressed", at="walk"),
    read("reindexed", "read", at="walk"),
    read("no_message_index", "read", at="walk.mcap"),
    read("unchunked", "read", at="walk.mcap"),
    read("no_summary", "read", at="walk.mcap"),
    read("lz4", "read", at="walk.mcap"),
    read("truncated_in_summary", "read: no message is lost", at="walk.mcap"),
    shown("truncated_midchunk", "read to the end that is there, with a remark", "(?i)truncated|incomplete|cut|end", at="walk.mcap"),
    shown("truncated_unchunked", "read to the end that is there, with a remark", "(?i)truncated|incomplete|cut|end", at="walk.mcap"),
    read("log_time_rollover", "read", at="walk.mcap"),
    read("log_time_zero", "read", at="walk.mcap"),
    read("wal", "read", at="walk"),
    reported("wal_lost", "the error calls the database damaged or names the file -wal", "(?i)-wal|damaged", at="walk"),
    either("wal_readonly", "read, or the reason reported", "(?i)-wal|permission|read-only|write", at="walk"),
    read("iron_db3", "read", at="walk"),
    read("split_missing_part", "what is there is read, with a remark on each missing file", "walk_[02]", at="walk"),
    either("parent_folder", "read, or a message: which folder to give", "give that one", at="rec"),
    either("metadata_file", "read, or a message: which folder to give", "give the folder", at="walk/metadata.yaml"),
    read("ros2idl", "read", at="walk.mcap"),
    read("empty_schema", "read", at="walk.mcap"),
    read("type_name_old", "read", at="walk.mcap"),
    read("zstd_no_metadata", "read", at="walk"),
    read("no_metadata", "read", at="walk"),
    read("folder_in_paths", "read", at="walk"),
]

# --- topics of a depth camera's driver ---------------------------------------------------------------------

TWO_TOPICS = "(?i)interpolat"
REALSENSE = [
    read("separate", "read from two topics, with a remark", TWO_TOPICS),
    read("separate_named", "read from two topics, with a remark", TWO_TOPICS),
    read("separate_tf", "read from two topics, with a remark", TWO_TOPICS),
    read("united_interp", "read"),
    read("united_copy", "read", factor=2),
    read("all_streams", "read from two topics, with a remark: the calibration names the cameras", TWO_TOPICS),
    read("all_streams_united", "read"),
]

# --- rectified images --------------------------------------------------------------------------------------

RECTIFIED = [read(name, "read") for name in ("convention", "own_frames", "own_frames_p0", "own_raw_frames", "own_raw_frames_p0",
                                             "zed_names", "own_frames_raw_and_rect", "realsense")]

# --- CameraInfo and /tf_static -----------------------------------------------------------------------------

LENS = "(?i)rational|kannala|coefficients"
INFO = [
    read("plain"),
    read("radtan_name"),
    shown("empty_model", "health and `check` blame the lens", finds="(?i)lens|distortion", healthy=False),
    either("empty_model_with_d", "read, or the model named", "distortion model"),
    reported("uncalibrated", "the error reports that the camera is not calibrated", "(?i)not calibrated|uncalibrated|calibrat"),
    shown("no_d", "health and `check` blame the lens", finds="(?i)lens|distortion", healthy=False),
    read("rational_padded"),
    read("rational_14_padded"),
    read("d12_plumb_bob"),
    either("rational_true", "read, or the model named", LENS),
    either("kannala", "read, or the model named", LENS),
    shown("fisheye", "the lens is not a fisheye: health and `check` blame the lens", finds="(?i)lens|distortion", healthy=False),
    either("brown_conrady", "read, or the model named", "distortion model"),
    reported("no_tf", "the error asks for the transform", "(?i)tf_static|transform"),
    read("tf_not_static", "the constant /tf is read, with a remark", "/tf"),
    reported("tf_one_camera", "the error names the frame without a transform", "right_optical"),
    read("tf_body_frames"),
    read("tf_many_messages"),
    read("slash_frames"),
    either("imu_frame_empty", "read, or the empty frame named", "(?i)frame"),
    read("tf_in_the_end"),
    read("info_once"),
    read("info_zero_stamp"),
    either("info_size_zero", "read, or the field named", "width|size"),
    read("namespace"),
    read("color_and_mono"),
    read("noise_named_otherwise"),
    reported("no_noise", "the error asks for the noise", "(?i)noise"),
    read("roi"),
]

# --- what sensors do ---------------------------------------------------------------------------------------

SENSORS = [
    shown("rolling_30ms", "`check` does not call it an offset", finds="!stamped (late|early)"),
    shown("rolling_15ms", "`check` does not call it an offset", finds="!stamped (late|early)"),
    read("projector", "as the intact piece", factor=3),
    read("projector_alternate", "as the intact piece", factor=3),
    shown("lens_misnamed", "`check` blames the lens, and `run` is not healthy", finds="(?i)lens|distortion", healthy=False),
    read("latency_95ms", "started with the offset that `check` measures, reported", r"(?i)late.*9[3-7]|9[3-7].*late",
         finds=r"9[3-7](\.\d)? ms", factor=3, moved=lambda t, start: t),
    shown("image_jitter", "`check` finds the jitter", finds="(?i)jitter|interval|late"),
    shown("stereo_async", "`check` finds it", finds="(?i)apart|epipolar|second camera|cam1"),
    read("alternate_exposure", "as the intact piece", factor=3),
    read("exposure_steps", "as the intact piece", factor=3),
    read("drops_50", "as the intact piece; `check` does not call it jitter", factor=4, finds="!jitter"),
    shown("drops_80", "`check` does not call it jitter", finds="!jitter"),
    read("border", "as the intact piece", factor=3),
    shown("stabilised", "`check` finds it", finds="(?i)rotate|stabilis|gyroscope"),
]

# --- files of the truth ------------------------------------------------------------------------------------

@dataclasses.dataclass(frozen=True)
class TruthRule:
    """`chasles evaluate RUN FILE`. same: exit 0 and the figures of the plain truth; reported: a message says it, with
    figures or as an error; same or reported: either. attitude: False where the file has none, so that the figures of the
    attitude and of the pose must be left out. says: also needed with "same"."""
    name: str
    right: str
    end: str = "same"
    says: str = ""
    attitude: bool = True


CLOCK = r"(?i)clock|\b(late|early)\b|time offset"
POSITIONS = dict(end="same", attitude=False)
TRUTHS = [
    TruthRule("relative_time.tum", "a message that no time is common", "reported", "(?i)overlap|span|0 poses"),
    TruthRule("offset_37s.tum", "a message that no time is common, or that the clock is 37 s off", "reported", r"(?i)overlap|span|0 poses|\b37"),
    TruthRule("off20.tum", "a message that the truth's clock is 20 ms off", "reported", CLOCK),
    TruthRule("off50.tum", "a message that the truth's clock is 50 ms off", "reported", CLOCK),
    TruthRule("off100.tum", "a message that the truth's clock is 100 ms off", "reported", CLOCK),
    TruthRule("offset_0p2s.tum", "a message that the truth's clock is 200 ms off", "reported", CLOCK),
    TruthRule("unsorted.tum", "sorted, or a message", "same or reported", "(?i)order|sort|increas"),
    TruthRule("two_files_joined.tum", "read, or a message", "same or reported", "(?i)order|sort|increas|twice|repeat"),
    TruthRule("duplicates.tum", "read once, or a message", "same or reported", "(?i)order|twice|repeat|duplicate|increas"),
    TruthRule("nan_rows.tum", "read without these rows, or a message", "same or reported", "(?i)finite|nan|not a number|lost"),
    TruthRule("zero_quaternion.tum", "positions alone, or a message", "same or reported", "(?i)quaternion|attitude|lost", attitude=False),
    TruthRule("positions.txt", "positions alone, reported", "same", "(?i)position|attitude", attitude=False),
    TruthRule("identity_quaternion.tum", "positions alone, reported", "same", "(?i)attitude|position", attitude=False),
    TruthRule("wxyz.tum", "a message that w comes first", "reported", r"(?i)\bw\b|wxyz|real part|order of the quaternion|quaternion"),
    TruthRule("kitti.txt", "a message that there are no times", "reported", "(?i)KITTI|time|column"),
    TruthRule("euler_degrees.txt", "a message that angles are no quaternion", "reported", "(?i)column|quaternion|angle|euler"),
    TruthRule("millimetres.tum", "a message that the unit is millimetres", "reported", "(?i)millimet|scale|unit"),
    TruthRule("rounded.tum", "the same figures, or a message", "same or reported", "(?i)round|digits|decimal"),
    TruthRule("sparse_1hz.tum", "figures at fewer times, or a message", "same or reported", "(?i)gap|sparse|interval|apart"),
    TruthRule("of_cam0.tum", "a message that the poses are of the camera", "reported", "(?i)cam0|camera"),
    TruthRule("inverse.tum", "a message that the poses are inverse", "reported", "(?i)invers"),
    TruthRule("x_up.tum", "a message that another axis points up", "reported", r"(?i)\bx\b.*\bup|axis|level|tilt|leans"),
    TruthRule("openvins_state.txt", "read, or a message: the order of columns", "same or reported", "(?i)openvins|invers|quaternion|column|order"),
    TruthRule("comma_decimal.csv", "read, or a message", "same or reported", "(?i)comma|;|semicolon"),
    TruthRule("truth.mcap", "read, or a message: the command that converts it", "same or reported", "PoseStamped|/gt"),
]

# --- all of them -------------------------------------------------------------------------------------------

GROUPS = {  # {group: (script, rules)}
    "files": ("make_files.py", FILES), "folders": ("make_folders.py", FOLDERS),
    "messages": ("make_messages_bag.py", MESSAGES), "ros2_bags": ("make_ros2_bags.py", ROS2),
    "realsense": ("make_realsense_bag.py", REALSENSE), "rectified": ("make_rectified_bag.py", RECTIFIED),
    "camera_info": ("make_camera_info_bag.py", INFO), "sensors": ("make_sensors.py", SENSORS),
}
