#!/usr/bin/python3
"""The node chasles_ros, with Debian's roscore, rosbag, roslaunch and tf2, against `chasles run` on the same
bags and against the truth of rendered walks."""
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import numpy as np
import rospy
import tf2_ros
from sensor_msgs import point_cloud2
from std_srvs.srv import Trigger

from recordings import Walk, rotation_of, run, states_of
from ros import HERE, Listener, Master, Process, node, play, wait_for

WARN, ERROR = 1, 2
SAME_FILES = ['states.csv', 'trajectory.tum', 'landmarks.csv', 'smoothed.csv', 'trajectory_smoothed.tum',
              'map.ply']
BASE_T_IMU = np.array([[0, -1, 0, 0.3], [1, 0, 0, -0.2], [0, 0, 1, 0.1], [0, 0, 0, 1.0]])


def pose_of(message):
    """4 x 4, of a geometry_msgs/Pose."""
    p, q = message.position, message.orientation
    T = np.eye(4)
    T[:3, :3] = rotation_of(q.w, q.x, q.y, q.z)
    T[:3, 3] = p.x, p.y, p.z
    return T


def yaw_of(R):
    """The rotation about z that is nearest to R."""
    yaw = np.arctan2(R[1, 0] - R[0, 1], R[0, 0] + R[1, 1])
    return rotation_of(np.cos(yaw / 2), 0, 0, np.sin(yaw / 2))


def vector_of(v):
    return np.array([v.x, v.y, v.z])


def ns_of(message):
    return message.header.stamp.to_nsec()


def commands_of_page(section):
    """The commands of ROS and of ros/ros1/ in a section of docs/ros.md."""
    page = (HERE.parents[2] / 'docs' / 'ros.md').read_text(encoding='utf8')
    text = page.split(f'\n## {section}\n')[1].split('\n## ')[0]
    blocks = re.findall(r'```sh\n(.*?)```', text, re.DOTALL)
    lines = '\n'.join(blocks).replace('\\\n', ' ').splitlines()
    return [line for line in lines if line.startswith(('ros/ros1/', 'roslaunch', 'rosbag', 'rosservice'))]


class NodeTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = Path(tempfile.mkdtemp())
        cls.addClassCleanup(shutil.rmtree, cls.folder)
        cls.walk = Walk(cls.folder / 'scene')
        cls.bag = cls.walk.bag(cls.folder / 'walk', late_ms=30)
        cls.expected = run(cls.bag, cls.folder / 'expected', '--save-map', cls.folder / 'expected.map')
        cls.master = Master()
        cls.addClassCleanup(cls.master.end)

    def expect_same_run(self, folder, expected=None):
        for name in SAME_FILES:
            self.assertEqual((folder / name).read_bytes(), ((expected or self.expected) / name).read_bytes(), name)

    def tf(self):
        buffer = tf2_ros.Buffer(rospy.Duration(100))
        self.addCleanup(tf2_ros.TransformListener(buffer).unregister)
        return buffer

    def call(self, service):
        rospy.wait_for_service(f'/chasles/{service}', 10)
        return rospy.ServiceProxy(f'/chasles/{service}', Trigger)()

    def parameters(self, bag=None, output='out', **more):
        """For node(): those of a run of a bag."""
        return {'calibration': (bag or self.bag).parent, 'output': self.folder / output,
                'lossless': True, 'name': 'walk', **more}

    # The commands of docs/ros.md, in a folder like the repository's; the scene is a smaller one.
    def test_the_commands_of_the_page_give_the_bytes_of_the_command(self):
        convert, launch, rosbag, rosservice = commands_of_page('A bag')
        place = self.folder / 'page'
        (place / 'out').mkdir(parents=True)
        (place / 'ros').mkdir()
        (place / 'hallway').symlink_to(self.folder / 'scene')
        (place / 'ros/ros1').symlink_to(HERE.parent)

        def shell(command):
            return subprocess.run(['bash', '-c', command], cwd=place, check=True, timeout=60,
                                  capture_output=True, text=True).stdout

        shell(convert)
        expected = run(place / 'walk/walk.bag', place / 'expected', '--save-map', place / 'expected.map')
        walk = self.walk.shifted(0)
        tf = self.tf()
        with Listener() as listener, Process(['bash', '-c', 'exec ' + launch.rstrip(' &')],
                                             cwd=place) as launched:
            listener.wait_for_node()
            shell(rosbag)
            # Without those whose stamp is 0.
            level, message, values = listener.wait_for_counts(samples=walk.samples - 1,
                                                              frames_taken=walk.frames - 1)
            self.assertIn('success: True', shell(rosservice))
            launched.interrupt()
            self.assertEqual((level, values['health'], values['started']), (0, 'ok', 'yes'), message)
            self.assertGreater(float(values['latency worst [ms]']), 0)
            self.expect_same_run(place / 'out/run', expected)
            self.assertEqual((place / 'out/walk.map').read_bytes(), (place / 'expected.map').read_bytes())
            states = states_of(expected)
            self.check_odometry(listener, walk, int(states['time_ns'][0]))
            self.check_frames(listener, states)
            self.check_tf(tf, listener)

    # At the rate of the IMU, within its own sigmas of the truth.
    def check_odometry(self, listener, walk, start):
        odometry = listener['odometry']
        stamps = [ns_of(o) for o in odometry]
        self.assertTrue(np.all(np.diff(stamps) > 0))
        # All samples after the start, except those that came before it was estimated.
        self.assertGreater(len(odometry), 0.8 * walk.samples * np.mean(walk.times >= start))
        pairs = [(o, walk.truth_at(ns)) for o, ns in zip(odometry, stamps) if walk.truth_at(ns)]
        self.assertGreater(len(pairs), 0.04 * len(odometry))  # a frame is at each 20th sample
        first, (p_first, R_first, _) = pairs[0]
        T_first = pose_of(first.pose.pose)
        world = yaw_of(R_first @ T_first[:3, :3].T)
        outside = np.zeros(2)
        for o, (p_true, R_true, v_true) in pairs:
            self.assertEqual((o.header.frame_id, o.child_frame_id), ('odom', 'base_link'))
            P = np.array(o.pose.covariance).reshape(6, 6)
            Q = np.array(o.twist.covariance).reshape(6, 6)
            self.assertTrue(np.all(np.linalg.eigvalsh(P) > 0) and np.all(np.linalg.eigvalsh(Q) > 0))
            moved = world @ (pose_of(o.pose.pose)[:3, 3] - T_first[:3, 3])
            errors = [p_true - p_first - moved, R_true.T @ v_true - vector_of(o.twist.twist.linear)]
            for i, C in enumerate((P[:3, :3], Q[:3, :3])):
                outside[i] += np.linalg.norm(errors[i]) > 3 * np.sqrt(np.trace(C))
        self.assertLessEqual(outside.max(), 1, outside)
        self.check_rates(odometry)

    # The angular velocity is that by which the orientation turns.
    def check_rates(self, odometry):
        errors = []
        for a, b in zip(odometry, odometry[1:]):
            dt = (ns_of(b) - ns_of(a)) * 1e-9
            if dt > 0.011:
                continue
            turn = pose_of(a.pose.pose)[:3, :3].T @ pose_of(b.pose.pose)[:3, :3]
            vee = np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]]) / 2
            mean = (vector_of(a.twist.twist.angular) + vector_of(b.twist.twist.angular)) / 2
            errors.append(np.linalg.norm(vee / dt - mean))
        self.assertLess(np.median(errors), 5e-3)

    # Those of frames are the rows of states.csv.
    def check_frames(self, listener, states):
        row_of = {int(t): i for i, t in enumerate(states['time_ns'])}
        columns = ['x', 'y', 'z', 'rx', 'ry', 'rz']
        poses = listener['pose']
        self.assertEqual([ns_of(p) for p in poses], sorted(row_of))
        for message in poses + listener['frame_odometry']:
            i = row_of[ns_of(message)]
            p = message.pose.pose.position
            self.assertEqual([p.x, p.y, p.z], [float(states[c][i]) for c in 'xyz'])
            P = np.array(message.pose.covariance).reshape(6, 6)
            sigma = [float(states[f'sigma_{name}'][i]) for name in columns]
            np.testing.assert_allclose(np.sqrt(np.diag(P)), sigma, rtol=1e-12)
            of_rx_z = float(states['cov_05'][i])
            self.assertAlmostEqual(P[3, 2], of_rx_z, delta=1e-12 + 1e-9 * abs(of_rx_z))
        self.assertGreater(len(listener['frame_odometry']), 0.8 * len(poses))
        path = listener['path'][-1]
        self.assertEqual(path.poses[0].header.stamp.to_nsec(), min(row_of))
        self.assertGreater(len(path.poses), 0.7 * len(poses))
        points = np.array(list(point_cloud2.read_points(listener['points'][-1])))
        self.assertEqual(points.shape[1], 4)
        self.assertGreater(len(points), 50)
        self.assertTrue(np.all(points[:, 3] > 0))

    def check_tf(self, tf, listener):
        odometry = listener['odometry'][len(listener['odometry']) // 2]
        T = tf.lookup_transform('odom', 'base_link', odometry.header.stamp).transform
        expected = odometry.pose.pose
        np.testing.assert_allclose(vector_of(T.translation), vector_of(expected.position), atol=1e-9)
        identity = tf.lookup_transform('map', 'odom', odometry.header.stamp).transform
        self.assertEqual((identity.rotation.w, identity.translation.x), (1, 0))

    def test_a_bag_that_is_played_again_begins_the_run_anew(self):
        with Listener() as listener, node(**self.parameters(output='again')) as chasles:
            listener.wait_for_node()
            play(self.bag)
            listener.wait_for_counts(samples=self.walk.samples, frames_taken=self.walk.frames)
            self.assertTrue(self.call('reset').success)
            listener.wait_for_counts(resets=1)
            self.assertEqual(listener.status()[2]['samples'], '0')
            for _ in range(2):  # the second time the clock jumps back
                play(self.bag, rate=8)
            # Each topic jumps by itself.
            listener.wait_for_counts(resets=2, samples=self.walk.samples - 10, frames=self.walk.frames - 3)
            self.assertEqual(chasles.interrupt(), 0, chasles.text())
            self.assertIn('jumped back: the run begins anew', chasles.text())
            self.assertIn('reset was called', chasles.text())
            last = [states_of(f)['time_ns'][-1] for f in (self.folder / 'again', self.expected)]
            self.assertEqual(*last)

    def test_a_stereo_pair_as_compressed_images(self):
        walk = Walk(self.folder / 'stereo_scene', cameras=2)
        bag = walk.bag(self.folder / 'stereo', name='stereo', compressed=True, late_ms=40)
        expected = run(bag, self.folder / 'stereo_expected')
        parameters = self.parameters(bag, output='stereo_out', image_transport='compressed')
        with Listener() as listener, node(**parameters) as chasles:
            listener.wait_for_node()
            play(bag)
            listener.wait_for_counts(samples=walk.samples, frames_taken=walk.frames)
            self.assertEqual(chasles.interrupt(), 0, chasles.text())
        self.expect_same_run(self.folder / 'stereo_out', expected)

    # CameraInfo and /tf_static instead of Kalibr's chain, a base apart from the IMU, and settings.
    def test_topics_calibrate_the_cameras(self):
        bag = self.walk.bag(self.folder / 'info', chain=False, calibrated=True, base_T_imu=BASE_T_IMU)
        expected = run(bag, self.folder / 'info_expected', '--set', 'start.heading=0.25')
        parameters = self.parameters(bag, output='info_out', imu_topic='/imu0',
                                     camera_topics=['/cam0/image_raw'], start={'heading': 0.25})
        with Listener() as listener, node(**parameters) as chasles:
            listener.wait_for_node()
            level, message, _ = wait_for(listener.status, 10, 'a diagnosis')
            self.assertEqual(level, WARN)
            self.assertIn('the cameras are not calibrated yet', message)
            play(bag)
            listener.wait_for_counts(samples=self.walk.samples, frames_taken=self.walk.frames)
            self.assertEqual(chasles.interrupt(), 0, chasles.text())
        self.expect_same_run(self.folder / 'info_out', expected)
        states = states_of(expected)
        row = {int(t): i for i, t in enumerate(states['time_ns'])}[ns_of(listener['pose'][-1])]
        T = np.eye(4)
        T[:3, 3] = [float(states[c][row]) for c in 'xyz']
        T[:3, :3] = rotation_of(*[float(states[f'q{c}'][row]) for c in 'wxyz'])
        np.testing.assert_allclose(pose_of(listener['pose'][-1].pose.pose),
                                   T @ np.linalg.inv(BASE_T_IMU), atol=1e-9)

    def test_a_place_in_a_map_is_the_transform_from_map_to_odom(self):
        tf = self.tf()
        # With one camera, so small images have too few landmarks to search with.
        walk = Walk(self.folder / 'known_scene', cameras=2)
        bag = walk.bag(self.folder / 'known_walk')
        known = self.folder / 'known.map'
        run(bag, self.folder / 'known', '--save-map', known)
        expected = run(bag, self.folder / 'placed', '--map', known)
        parameters = self.parameters(bag, output='placed_out', map=known)
        with Listener() as listener, node(**parameters) as chasles:
            listener.wait_for_node()
            play(bag)
            values = listener.wait_for_counts(samples=walk.samples, frames_taken=walk.frames)[2]
            self.assertEqual(values['place in the map'], 'found')
            wait_for(lambda: listener['pose_in_map'], 10, 'a pose in the map')
            pose = listener['pose_in_map'][-1]
            self.assertEqual(pose.header.frame_id, 'map')
            odom = {ns_of(p): p for p in listener['pose']}[ns_of(pose)]
            # tf at the samples after the last frame; the transform moves by little from frame to frame.
            T = tf.lookup_transform('map', 'odom', rospy.Time(0)).transform
            map_T_odom = np.eye(4)
            map_T_odom[:3, :3] = rotation_of(T.rotation.w, T.rotation.x, T.rotation.y, T.rotation.z)
            map_T_odom[:3, 3] = vector_of(T.translation)
            np.testing.assert_allclose(map_T_odom @ pose_of(odom.pose.pose), pose_of(pose.pose.pose),
                                       atol=0.02)
            self.assertEqual(chasles.interrupt(), 0, chasles.text())
        for name in ['states.csv', 'in_map.csv']:
            self.assertEqual((self.folder / 'placed_out' / name).read_bytes(), (expected / name).read_bytes())

    # A depth camera's driver: two topics for the IMU.
    def test_an_accelerometer_and_a_gyroscope_apart_give_the_bytes_of_the_command(self):
        bag = self.walk.bag_with_imu_apart(self.folder / 'apart')
        expected = run(bag, self.folder / 'apart_expected')
        with Listener() as listener, node(**self.parameters(bag, 'apart_out', imu_topic='/gyro',
                                                            accelerometer_topic='/accel')) as chasles:
            listener.wait_for_node()
            play(bag)
            values = listener.wait_for_counts(gyroscope_samples=self.walk.samples - 1,
                                              frames_taken=self.walk.frames - 2)[2]
            self.assertEqual(chasles.interrupt(), 0, chasles.text())
            self.assertLess(int(values['gyroscope samples not joined']), 3)
            self.assertGreater(len(listener['odometry']), 100)
        self.expect_same_run(self.folder / 'apart_out', expected)

    def test_axes_that_differ_end_the_node(self):
        R = np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1.0]])
        bag = self.walk.bag_with_imu_apart(self.folder / 'turned', R)
        parameters = self.parameters(bag, 'turned_out', imu_topic='/gyro', accelerometer_topic='/accel')
        with Listener() as listener, node(**parameters) as chasles:
            listener.wait_for_node()
            play(bag)
            self.assertEqual(chasles.process.wait(20), 1)
            self.assertIn('turned by 90 deg', chasles.text())
        # The reader of bags turns them.
        states = states_of(run(bag, self.folder / 'turned_expected'))
        self.assertGreater(len(states['time_ns']), 0.8 * self.walk.frames)

    # A driver's faults: no stamps, damaged images, another type.
    def test_damaged_messages_are_counted_and_the_run_goes_on(self):
        from sensor_msgs.msg import CompressedImage, Imu
        with Listener() as listener, node(**self.parameters(output='damaged', image_transport='compressed')) as chasles:
            listener.wait_for_node()
            images = rospy.Publisher('/cam0/image_raw/compressed', CompressedImage, queue_size=10)
            samples = rospy.Publisher('/imu0', Imu, queue_size=10)
            for publisher in (images, samples):
                wait_for(publisher.get_num_connections, 10, 'the node')
            image = CompressedImage(format='png', data=b'no picture')
            image.header.stamp = rospy.Time(1000)
            images.publish(image)
            samples.publish(Imu())
            values = listener.wait_for_counts(images_not_decoded=1, messages_without_a_stamp=1)[2]
            self.assertEqual(values['samples'], '0')
            for publisher in (images, samples):
                publisher.unregister()
            chasles.interrupt()
            self.assertIn('topic /cam0/image_raw/compressed at 1000000000000 ns', chasles.text())

    def test_a_topic_of_another_type_is_reported(self):
        from sensor_msgs.msg import Image
        with Listener() as listener, node(**self.parameters(output='type')) as chasles:
            listener.wait_for_node()
            wrong = rospy.Publisher('/imu0', Image, queue_size=10)
            wait_for(wrong.get_num_connections, 10, 'the node')
            wrong.publish(Image())
            wait_for(lambda: 'expected sensor_msgs/Imu' in chasles.text(), 10, 'the report')
            wrong.unregister()
            chasles.interrupt()

    def expect_failure(self, parameters, *parts):
        with node(**parameters) as chasles:
            self.assertEqual(chasles.process.wait(20), 1)
            for part in parts:
                self.assertIn(part, chasles.text())

    def test_parameters_that_cannot_be_used_end_the_node(self):
        self.expect_failure({}, '~calibration is missing')
        self.expect_failure(self.parameters(lossles=True),
                            "~lossles: unknown parameter; did you mean 'lossless'?")
        self.expect_failure(self.parameters(start={'headin': 1}),
                            "~start/headin: unknown parameter; did you mean 'start/heading'?")
        self.expect_failure(self.parameters(chart='none'), "chart: found 'none'")
        self.expect_failure(self.parameters(estimator='batch'), "estimator: found 'batch', expected filter")
        self.expect_failure({'calibration': '/none'}, '/none: there is no such file')
        self.expect_failure(self.parameters(map='/none.map'), '/none.map')


if __name__ == '__main__':
    unittest.main(argv=sys.argv, verbosity=2, warnings='ignore')  # rospy's own
