"""ros2 launch chasles_ros2 chasles.launch.py calibration:=/path/to/camchain-imucam.yaml"""
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node


def generate_launch_description():
    arguments = {
        'calibration': ('', 'file or folder: camchain-imucam.yaml with imu.yaml, or calibration.yaml'),
        'imu': ('', 'topic of sensor_msgs/msg/Imu; empty: the one that the calibration names, or /imu0'),
        'accelerometer': ('', 'topic of an accelerometer of its own; imu is that of the gyroscope then'),
        'rate': ('images', 'of the odometry: images or samples'),
        'output': ('', 'folder for the run, as chasles run -o'),
    }
    return LaunchDescription(
        [DeclareLaunchArgument(name, default_value=value, description=text)
         for name, (value, text) in arguments.items()] +
        [Node(package='chasles_ros2', executable='chasles_node', name='chasles', output='screen',
              parameters=[{name: LaunchConfiguration(name) for name in arguments}])])
