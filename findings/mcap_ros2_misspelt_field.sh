#!/usr/bin/env bash
# mcap-ros2-support 0.6.0 (writes ROS 2 messages into MCAP files from Python)
#
# Behaviour: Writer.write_message takes a message as a dictionary. A key that the definition does not have is ignored
# without a word, and a field that is missing becomes 0. An IMU message with the key "angular_velocty" is written with
# a gyroscope of zeros. Without log_time= the message gets the time of the writing, whatever its header says.
#
# A good engineer would guess: an unknown key is an error.
#
# So: check a converted recording for a sensor of zeros.
. "$(dirname "$0")/lib.sh"
python_with mcap-ros2-support==0.6.0 mcap==1.6.0
"$python" - << 'PY'
import time
from mcap_ros2.reader import read_ros2_messages
from mcap_ros2.writer import Writer
RULE = "=" * 80
DEFINITION = f"""std_msgs/Header header
geometry_msgs/Vector3 angular_velocity
geometry_msgs/Vector3 linear_acceleration
{RULE}
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
{RULE}
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
{RULE}
MSG: geometry_msgs/Vector3
float64 x
float64 y
float64 z
"""
with open("walk.mcap", "wb") as file:
    writer = Writer(file)
    schema = writer.register_msgdef("sensor_msgs/msg/Imu", DEFINITION)
    writer.write_message("/imu", schema, {
        "header": {"stamp": {"sec": 100, "nanosec": 0}, "frame_id": "imu"},
        "angular_velocty": {"x": 0.1, "y": 0.2, "z": 0.3},  # the letter i is missing
        "linear_acceleration": {"x": 0.0, "y": 0.0, "z": 9.81}})
    writer.finish()
(message,) = read_ros2_messages("walk.mcap")
rate, stamp = message.ros_msg.angular_velocity, message.ros_msg.header.stamp.sec
print(f"  angular_velocity ({rate.x}, {rate.y}, {rate.z}); stamp {stamp} s, log time {message.log_time_ns / 1e9:.0f} s")
assert (rate.x, rate.y, rate.z) == (0, 0, 0) and message.ros_msg.linear_acceleration.z == 9.81
assert stamp == 100 and abs(message.log_time_ns / 1e9 - time.time()) < 600
PY
