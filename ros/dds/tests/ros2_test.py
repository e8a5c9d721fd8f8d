"""The bridge and a node of ROS 2 (rclpy with Fast DDS): what the drivers of a robot publish, and what its
programs subscribe to."""
import array
import os
import tempfile
import unittest
from pathlib import Path

import walk
from PIL import Image

os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'LOCALHOST'


class Node:
    """The drivers, and a subscriber."""

    def __init__(self, domain):
        import rclpy
        from diagnostic_msgs.msg import DiagnosticArray
        from nav_msgs.msg import Odometry
        from rclpy.qos import QoSProfile
        from sensor_msgs import msg
        self.rclpy, self.msg = rclpy, msg
        self.context = rclpy.Context()
        rclpy.init(context=self.context, domain_id=domain)
        self.node = rclpy.create_node('robot', context=self.context)
        self.executor = rclpy.executors.SingleThreadedExecutor(context=self.context)
        self.executor.add_node(self.node)
        deep = QoSProfile(depth=10000)  # reliable, as by default
        self.imu = self.node.create_publisher(msg.Imu, '/imu0', deep)
        self.camera = self.node.create_publisher(msg.Image, '/cam0/image_raw', deep)
        self.found = {'/odometry': [], '/points': [], '/diagnostics': []}
        for topic, kind in (('/odometry', Odometry), ('/points', msg.PointCloud2),
                            ('/diagnostics', DiagnosticArray)):
            self.node.create_subscription(kind, topic, self.found[topic].append, deep)

    def spin(self):
        self.executor.spin_once(timeout_sec=0.005)

    def is_connected(self):
        return (self.imu.get_subscription_count() == 1 and self.camera.get_subscription_count() == 1 and
                all(self.node.count_publishers(topic) == 1 for topic in self.found) and
                walk.is_heard(self.found['/diagnostics']))

    def publish(self, event):
        message = self.msg.Imu() if event[1] == 'imu' else self.msg.Image()
        message.header.stamp.sec, message.header.stamp.nanosec = divmod(event[0], 10**9)
        message.header.frame_id = 'sensor'
        if event[1] == 'imu':
            for field, v in ((message.angular_velocity, event[2]), (message.linear_acceleration, event[3])):
                field.x, field.y, field.z = v
            self.imu.publish(message)
        else:
            picture = Image.open(event[2])
            message.width, message.height = picture.size
            message.encoding, message.step = 'mono8', message.width
            message.data = array.array('B', picture.tobytes())
            self.camera.publish(message)

    def close(self):
        self.executor.shutdown()
        self.node.destroy_node()
        self.rclpy.shutdown(context=self.context)


class RealNode(unittest.TestCase):
    def run_on(self, domain, *more):
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            recording = walk.simulate(folder)
            bridge = walk.Bridge(folder, domain, *more)
            node = Node(domain)
            try:
                self.assertTrue(walk.wait_until(node.is_connected, 20, node.spin), bridge.log.read_text())
                for event in walk.events(recording):
                    node.publish(event)
                    node.spin()
                last = max(t for t, _ in walk.images(recording))
                stamp = lambda m: m.header.stamp.sec * 10**9 + m.header.stamp.nanosec
                odometry = node.found['/odometry']
                # The estimates have the IMU's clock, by the estimated offset.
                arrived = lambda: odometry and stamp(odometry[-1]) > last - 20_000_000
                self.assertTrue(walk.wait_until(arrived, 20, node.spin), bridge.log.read_text())
                walk.wait_until(lambda: node.found['/diagnostics'], 3, node.spin)
                self.assertIn(('/tf', ['tf2_msgs/msg/TFMessage']), node.node.get_topic_names_and_types())
                self.assertEqual(bridge.finish(), 0, bridge.log.read_text())
            finally:
                bridge.kill()
                node.close()
            for file in ('states.csv', 'trajectory.tum', 'landmarks.csv'):
                self.assertEqual((folder / 'bridge' / file).read_bytes(),
                                 (folder / 'command' / file).read_bytes(), file)
            states = walk.states(folder / 'bridge')
            self.assertGreater(len(odometry), 20)
            for message in odometry:
                state = states[stamp(message)]
                self.assertAlmostEqual(message.pose.pose.position.x, float(state['x']), places=12)
                self.assertAlmostEqual(message.pose.covariance[0], float(state['sigma_x'])**2, places=12)
            self.assertGreater(node.found['/points'][-1].width, 20)
            self.assertEqual(node.found['/points'][-1].header.frame_id, 'odom')
            self.assertEqual(node.found['/diagnostics'][-1].status[0].name, 'chasles: robot')

    def test_over_the_loopback(self):
        profile = Path(__file__).resolve().parent.parent / 'loopback_fastdds.xml'
        os.environ['FASTDDS_DEFAULT_PROFILES_FILE'] = str(profile)
        self.run_on(84)

    def test_over_the_addresses_of_the_host(self):
        os.environ.pop('FASTDDS_DEFAULT_PROFILES_FILE', None)
        self.run_on(85, '--network', 'host')


if __name__ == '__main__':
    unittest.main()
