"""Recordings for the tests: rendered walks, as bags with Kalibr's files, and what `chasles run` makes of
them."""
import copy
import csv
import importlib.util
import subprocess
from importlib.machinery import SourceFileLoader
from pathlib import Path

import numpy as np
import rosbag
import rospy
from geometry_msgs.msg import TransformStamped, Vector3
from tf2_msgs.msg import TFMessage

from ros import CHASLES, HERE

loader = SourceFileLoader('euroc_to_bag', str(HERE.parent / 'scripts' / 'euroc-to-bag'))
euroc = importlib.util.module_from_spec(importlib.util.spec_from_loader(loader.name, loader))
loader.exec_module(euroc)

SHIFT_NS = 1_000 * 10**9
SCENE = {'sections': 1, 'hall_length': 8, 'hall_width': 6, 'rest_duration': 1, 'start_duration': 0.5,
         'frame_rate': 15, 'focal_length': 200, 'image_width': 320, 'image_height': 240,
         'center_u': 159.5, 'center_v': 119.5}


def rotation_of(w, x, y, z):
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                     [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                     [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])


class Walk:
    """A rendered walk in `folder`: EuRoC's format, and its truth."""

    def __init__(self, folder, **settings):
        scene = [f'--set={name}={value}' for name, value in {**SCENE, **settings}.items()]
        subprocess.run([CHASLES, 'simulate', 'hallway', '--images', *scene, '-o', folder], check=True,
                       stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.recording = euroc.Recording(Path(folder), shift_ns=SHIFT_NS)
        self.samples = len(euroc.rows_of(self.recording.mav / 'imu0'))
        self.frames = len(euroc.rows_of(self.recording.mav / 'cam0'))
        rows = np.array(euroc.rows_of(self.recording.mav / 'state_groundtruth_estimate0'), dtype=float)
        self.times = rows[:, 0].astype(np.int64) + SHIFT_NS
        self.positions, self.velocities = rows[:, 1:4], rows[:, 8:11]
        self.rotations = [rotation_of(*row[4:8]) for row in rows]

    def shifted(self, shift_ns):
        """The same with stamps that are shifted by so much against those of the folder."""
        other = copy.copy(self)
        other.times = self.times - SHIFT_NS + shift_ns
        return other

    def bag(self, folder, name='walk', chain=True, **options):
        folder.mkdir()
        euroc.write_kalibr(self.recording, folder, chain)
        euroc.write(self.recording, folder / f'{name}.bag', **options)
        return folder / f'{name}.bag'

    def bag_with_imu_apart(self, folder, R=None, **options):
        """The gyroscope on /gyro, and every second sample of the accelerometer on /accel. R: by /tf_static, the
        axes of the accelerometer are turned by it against those of the gyroscope."""
        whole = self.bag(folder, 'whole', **options)
        with rosbag.Bag(str(whole)) as source, rosbag.Bag(str(folder / 'walk.bag'), 'w') as out:
            count, turned = 0, R is None
            for topic, message, stamp in source.read_messages():
                if not turned:
                    turned = True
                    out.write('/tf_static', self.turn_of_accelerometer(R), stamp)
                if topic != '/imu0':
                    out.write(topic, message, stamp)
                    continue
                rate, force = copy.deepcopy(message), copy.deepcopy(message)
                rate.linear_acceleration = Vector3()
                force.angular_velocity = Vector3()
                if R is not None:
                    force.header.frame_id = 'accel'
                    a = force.linear_acceleration
                    a.x, a.y, a.z = R.T @ np.array([a.x, a.y, a.z])
                out.write('/gyro', rate, stamp)
                if count % 2 == 0:
                    out.write('/accel', force, stamp)
                count += 1
        whole.unlink()
        return folder / 'walk.bag'

    @staticmethod
    def turn_of_accelerometer(R):
        one = TransformStamped(child_frame_id='accel')
        one.header.frame_id = euroc.IMU_FRAME
        q = one.transform.rotation
        q.x, q.y, q.z, q.w = euroc.quaternion_of(R)
        return TFMessage([one])

    def truth_at(self, ns):
        """Position, rotation and velocity at a time of the truth, that of a frame; None at others."""
        i = int(np.searchsorted(self.times, ns))
        if i == len(self.times) or self.times[i] != ns:
            return None
        return self.positions[i], self.rotations[i], self.velocities[i]


def run(bag, folder, *options):
    """`chasles run` on the bag."""
    subprocess.run([CHASLES, 'run', bag, '-o', folder, '--quiet', *options], check=True,
                   stdout=subprocess.DEVNULL, timeout=120)
    return folder


def states_of(folder):
    """states.csv as a dictionary of columns."""
    with open(folder / 'states.csv', encoding='ascii') as file:
        rows = list(csv.reader(file))
    return {name: [row[i] for row in rows[1:]] for i, name in enumerate(rows[0])}
