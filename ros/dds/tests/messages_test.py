"""The bytes of the bridge against rosbags, a message stack of ROS 2 that shares nothing with it: rosbags
serialises what the bridge takes, and reads what it gives. Fast DDS carries them (dds_wire)."""
import os
import subprocess
import tempfile
import unittest
from pathlib import Path

import numpy as np
import walk
from PIL import Image
from rosbags.typesys import Stores, get_typestore

DOMAIN = 83
STORE = get_typestore(Stores.ROS2_JAZZY)
TYPES = {'/imu0': 'sensor_msgs/msg/Imu', '/cam0/image_raw': 'sensor_msgs/msg/Image',
         '/odometry': 'nav_msgs/msg/Odometry', '/tf': 'tf2_msgs/msg/TFMessage',
         '/points': 'sensor_msgs/msg/PointCloud2', '/diagnostics': 'diagnostic_msgs/msg/DiagnosticArray'}


def make(name, **fields):
    return STORE.types[name](**fields)


def header(time_ns):
    stamp = make('builtin_interfaces/msg/Time', sec=time_ns // 10**9, nanosec=time_ns % 10**9)
    return make('std_msgs/msg/Header', stamp=stamp, frame_id='sensor')


def vector(v):
    return make('geometry_msgs/msg/Vector3', x=v[0], y=v[1], z=v[2])


def imu(time_ns, rate, force):
    none = np.zeros(9)
    return make('sensor_msgs/msg/Imu', header=header(time_ns), angular_velocity=vector(rate),
                linear_acceleration=vector(force), orientation_covariance=none,
                angular_velocity_covariance=none, linear_acceleration_covariance=none,
                orientation=make('geometry_msgs/msg/Quaternion', x=0., y=0., z=0., w=1.))


def image(time_ns, file):
    pixels = np.asarray(Image.open(file))
    height, width = pixels.shape
    return make('sensor_msgs/msg/Image', header=header(time_ns), height=height, width=width,
                encoding='mono8', is_bigendian=0, step=width, data=pixels.reshape(-1))


def time_of(message_header):
    return message_header.stamp.sec * 10**9 + message_header.stamp.nanosec


class Wire:
    """A participant of Fast DDS: tests/wire.cpp."""

    def __init__(self, domain):
        self.process = subprocess.Popen([os.environ['CHASLES_DDS_WIRE'], str(domain)],
                                        stdin=subprocess.PIPE, stdout=subprocess.PIPE)

    def tell(self, line, content=b''):
        self.process.stdin.write(line.encode() + b'\n' + content)
        self.process.stdin.flush()

    def open(self, verb, topic):
        package, _, name = TYPES[topic].split('/')
        self.tell(f'{verb} rt{topic} {package}::msg::dds_::{name}_')

    def ask(self, line):
        self.tell(line)
        return self.process.stdout.readline().strip() == b'1'

    def send(self, topic, message):
        content = bytes(STORE.serialize_cdr(message, TYPES[topic]))
        self.tell(f'send rt{topic} {len(content)}', content)

    def take(self, topic):
        self.tell(f'take rt{topic}')
        read = self.process.stdout
        contents = [read.read(int(read.readline())) for _ in range(int(read.readline()))]
        for content in contents:
            # Of the same message rosbags makes the same bytes, to the last one.
            message = STORE.deserialize_cdr(content, TYPES[topic])
            again = bytes(STORE.serialize_cdr(message, TYPES[topic]))
            assert again[4:] == content[4:len(again)], f'{topic}: other bytes than those of rosbags'
            assert len(content) - len(again) in range(4), f'{topic}: {len(content)}, {len(again)} bytes'
        return [STORE.deserialize_cdr(content, TYPES[topic]) for content in contents]

    def close(self):
        self.process.stdin.close()
        self.process.wait(20)
        self.process.stdout.close()


class Messages(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.scratch = tempfile.TemporaryDirectory()
        cls.folder = Path(cls.scratch.name)
        recording = walk.simulate(cls.folder)
        bridge = walk.Bridge(cls.folder, DOMAIN, '--points-period', '1e-6')
        wire = Wire(DOMAIN)
        try:
            for topic in ('/imu0', '/cam0/image_raw'):
                wire.open('pub', topic)
            for topic in ('/odometry', '/tf', '/points', '/diagnostics'):
                wire.open('sub', topic)
            assert wire.ask('match 20'), bridge.log.read_text()
            assert walk.wait_until(lambda: walk.is_heard(wire.take('/diagnostics')), 20)
            for event in walk.events(recording):
                if event[1] == 'imu':
                    wire.send('/imu0', imu(event[0], *event[2:]))
                else:
                    wire.send('/cam0/image_raw', image(*event[::2]))
            assert wire.ask('acknowledged 20'), bridge.log.read_text()
            assert bridge.finish() == 0, bridge.log.read_text()
            walk.time.sleep(0.3)
            cls.found = {topic: wire.take(topic)
                         for topic in ('/odometry', '/tf', '/points', '/diagnostics')}
        finally:
            bridge.kill()
            wire.close()
        cls.states = walk.states(cls.folder / 'bridge')

    @classmethod
    def tearDownClass(cls):
        cls.scratch.cleanup()

    def test_the_definitions_are_the_same_in_all_distributions(self):
        for other in (Stores.ROS2_HUMBLE, Stores.ROS2_IRON, Stores.ROS2_JAZZY, Stores.ROS2_KILTED):
            definitions = get_typestore(other).fielddefs
            for name in [*TYPES.values(), 'sensor_msgs/msg/CompressedImage', 'std_msgs/msg/Header',
                         'geometry_msgs/msg/TransformStamped', 'sensor_msgs/msg/PointField',
                         'diagnostic_msgs/msg/DiagnosticStatus']:
                self.assertEqual(definitions[name][1], STORE.fielddefs[name][1], f'{name} of {other}')

    def test_the_run_is_that_of_the_command(self):
        for name in ('states.csv', 'trajectory.tum', 'landmarks.csv'):
            self.assertEqual((self.folder / 'bridge' / name).read_bytes(),
                             (self.folder / 'command' / name).read_bytes(), name)

    def test_odometry(self):
        messages = self.found['/odometry']
        self.assertGreater(len(messages), 20)
        for message in messages:
            state = self.states[time_of(message.header)]
            self.assertEqual((message.header.frame_id, message.child_frame_id), ('odom', 'base_link'))
            pose = message.pose.pose
            for axis in 'xyz':
                self.assertAlmostEqual(getattr(pose.position, axis), float(state[axis]), places=12)
            q = np.array([getattr(pose.orientation, axis) for axis in 'xyzw'])
            expected = np.array([float(state['q' + axis]) for axis in 'xyzw'])
            self.assertLess(min(abs(q - expected).max(), abs(q + expected).max()), 1e-12)
            # ROS has the position first, Chasles the rotation.
            sigmas = np.sqrt(np.diag(message.pose.covariance.reshape(6, 6)))
            names = ['sigma_' + axis for axis in ('x', 'y', 'z', 'rx', 'ry', 'rz')]
            # Of a variance of 0, which may be below it by rounding, the table has no sigma.
            expected_sigmas = np.nan_to_num([float(state[name]) for name in names])
            np.testing.assert_allclose(sigmas, expected_sigmas, rtol=1e-9)
            R = rotation(expected)
            v = R.T @ [float(state['velocity_' + axis]) for axis in 'xyz']
            linear = message.twist.twist.linear
            np.testing.assert_allclose([linear.x, linear.y, linear.z], v, atol=1e-9)

    def test_transforms(self):
        self.assertEqual(len(self.found['/tf']), len(self.found['/odometry']))
        for tf, odometry in zip(self.found['/tf'], self.found['/odometry']):
            transform, = tf.transforms
            self.assertEqual(transform.header, odometry.header)
            self.assertEqual(transform.child_frame_id, odometry.child_frame_id)
            self.assertEqual(transform.transform.rotation, odometry.pose.pose.orientation)
            for axis in 'xyz':
                self.assertEqual(getattr(transform.transform.translation, axis),
                                 getattr(odometry.pose.pose.position, axis))

    def test_points(self):
        cloud = self.found['/points'][-1]
        formats = {7: '<f4', 6: '<u4'}
        layout = np.dtype({'names': [f.name for f in cloud.fields],
                           'formats': [formats[f.datatype] for f in cloud.fields],
                           'offsets': [f.offset for f in cloud.fields], 'itemsize': cloud.point_step})
        points = np.frombuffer(cloud.data.tobytes(), layout)
        self.assertEqual(len(points), cloud.width * cloud.height)
        rows = walk.table(self.folder / 'bridge/landmarks.csv')
        column = rows[0].index
        expected = sorted(tuple(np.float32(row[column(axis)]) for axis in 'xyz') for row in rows[1:])
        self.assertEqual(sorted((p['x'], p['y'], p['z']) for p in points), expected)

    def test_diagnostics(self):
        status, = self.found['/diagnostics'][-1].status
        self.assertEqual(status.name, 'chasles: robot')
        values = {value.key: value.value for value in status.values}
        self.assertEqual(values['frames'], str(len(walk.images(self.folder / 'walk'))))


def rotation(q):
    x, y, z, w = q
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                     [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                     [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])


if __name__ == '__main__':
    unittest.main()
