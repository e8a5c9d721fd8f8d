#!/usr/bin/env bash
# pyrealsense2 2.59.1 (the SDK of a depth camera), its recorder of ROS 2 .db3 files
#
# Behaviour: the recorder writes sensor_msgs/msg/Imu and images whose header.stamp is the time since the recording
# began at which the sample *arrived*: from 0, with the jitter of the host. The sensor's own time is only in a
# std_msgs/msg/String beside each message, on the topic .../metadata: "...;timestamp=5000000.000000;..." in ms.
#
# A good engineer would guess: header.stamp is the time of the frame, which the API hands out as get_timestamp(), as
# in the .bag files of a ROS driver.
#
# So: take the times from .../metadata, or say that the stamps are arrival times.
. "$(dirname "$0")/lib.sh"
python_with pyrealsense2==2.59.1.11053 numpy==2.2.6
cat > record.py << 'PY'
"""A simulated device: gyroscope samples 5 ms apart from 5000 s on. They arrive in groups of six, 40 ms apart."""
import time
import pyrealsense2 as rs

device = rs.software_device()
sensor = device.add_sensor("Motion Module")
stream = rs.motion_stream()
stream.type, stream.index, stream.uid, stream.fps, stream.fmt = rs.stream.gyro, 0, 1, 200, rs.format.motion_xyz32f
stream.intrinsics = rs.motion_device_intrinsic()
profile = sensor.add_motion_stream(stream).as_motion_stream_profile()
recorder = rs.recorder("walk.db3", device)
recorded = recorder.query_sensors()[0]
recorded.open(recorded.get_stream_profiles()[0])
recorded.start(lambda frame: None)
for k in range(60):
    if k % 6 == 0:
        time.sleep(0.04)
    frame, rate = rs.software_motion_frame(), rs.vector()
    rate.x, rate.y, rate.z = 0.1, 0.2, 0.3
    frame.data, frame.timestamp, frame.domain = rate, 5_000_000.0 + 5 * k, rs.timestamp_domain.hardware_clock
    frame.frame_number, frame.profile = k, profile
    sensor.on_motion_frame(frame)
recorded.stop()
recorded.close()
PY
"$python" record.py
"$python" - << 'PY'
import re, sqlite3, struct
database = sqlite3.connect("walk.db3")
rows = lambda topic: [data for (data,) in database.execute(
    "SELECT m.data FROM messages m JOIN topics t ON t.id = m.topic_id WHERE t.name LIKE ? ORDER BY m.id", (topic,))]
stamps = [s + ns / 1e9 for s, ns in (struct.unpack_from("<iI", data, 4) for data in rows("%/imu/data"))]
times = [float(re.search(rb"[;]timestamp=([0-9.]+)", data)[1]) / 1000 for data in rows("%/imu/metadata")]
steps = lambda t: sorted(b - a for a, b in zip(t, t[1:]))
print(f"  header.stamp: from {stamps[0]:.3f} s, steps {1000 * steps(stamps)[0]:.3f} to {1000 * steps(stamps)[-1]:.1f} ms")
print(f"  metadata:     from {times[0]:.3f} s, steps {1000 * steps(times)[0]:.3f} to {1000 * steps(times)[-1]:.1f} ms")
assert len(stamps) == len(times) == 60
assert stamps[0] < 60 and steps(stamps)[0] < 0.002 and steps(stamps)[-1] > 0.02
assert times[0] == 5000 and abs(steps(times)[0] - 0.005) < 1e-6 and abs(steps(times)[-1] - 0.005) < 1e-6
PY
