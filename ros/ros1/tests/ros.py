"""For the tests: a master of ROS 1 on a free port of the loopback device, processes, and what a node
publishes."""
import os
import signal
import socket
import subprocess
import tempfile
import time
from pathlib import Path

import rospy
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseWithCovarianceStamped
from nav_msgs.msg import Odometry, Path as RosPath
from sensor_msgs.msg import PointCloud2

HERE = Path(__file__).resolve().parent
CHASLES = os.environ['CHASLES_BINARY']
NODE = os.environ['CHASLES_ROS']


def wait_for(condition, seconds, what):
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        result = condition()
        if result:
            return result
        time.sleep(0.02)
    raise AssertionError(f'{what}: not within {seconds} s')


class Process:
    """A process with its children, and its output in a file. It ends with the object's `with`."""

    def __init__(self, arguments, cwd=None):
        self.log = tempfile.TemporaryFile('w+')
        self.process = subprocess.Popen([str(a) for a in arguments], stdout=self.log, stderr=self.log,
                                        cwd=cwd, start_new_session=True)

    def __enter__(self):
        return self

    # roscore and roslaunch end their children, which have groups of their own, on Ctrl-C alone.
    def __exit__(self, *_):
        if self.process.poll() is None:
            try:
                self.interrupt(15)
            except subprocess.TimeoutExpired:
                os.killpg(self.process.pid, signal.SIGKILL)
                self.process.wait()

    def interrupt(self, seconds=30):
        """Ctrl-C; returns the exit code."""
        self.process.send_signal(signal.SIGINT)
        return self.process.wait(seconds)

    def text(self):
        self.log.seek(0)
        return self.log.read()


class Master:
    def __init__(self):
        with socket.socket() as free:
            free.bind(('127.0.0.1', 0))
            port = free.getsockname()[1]
        self.home = tempfile.TemporaryDirectory()
        package = Path(NODE).parent  # build/.../ros1/share/chasles_ros
        os.environ.update(ROS_MASTER_URI=f'http://127.0.0.1:{port}', ROS_IP='127.0.0.1',
                          ROS_HOME=self.home.name, ROS_LOG_DIR=self.home.name,
                          ROS_PACKAGE_PATH=f'{package.parent}:/usr/share')
        os.environ.pop('ROS_HOSTNAME', None)
        self.process = Process(['roscore', '-p', port])
        wait_for(self.is_up, 20, 'roscore')
        rospy.init_node('test', disable_signals=True)

    @staticmethod
    def is_up():
        try:
            return rospy.get_master().getPid()
        except OSError:
            return False

    def end(self):
        rospy.signal_shutdown('the tests are over')
        self.process.__exit__()
        self.home.cleanup()


class Listener:
    """The messages of a node named `chasles`."""

    def __init__(self):
        self.messages = {}
        self.subscribers = [self.subscribe(f'/chasles/{name}', kind) for name, kind in
                            [('odometry', Odometry), ('frame_odometry', Odometry),
                             ('pose', PoseWithCovarianceStamped),
                             ('pose_in_map', PoseWithCovarianceStamped), ('path', RosPath),
                             ('points', PointCloud2)]]
        self.subscribers.append(self.subscribe('/diagnostics', DiagnosticArray))

    def __enter__(self):
        return self

    def __exit__(self, *_):
        for subscriber in self.subscribers:
            subscriber.unregister()

    def subscribe(self, topic, kind):
        kept = self.messages.setdefault(topic.split('/')[-1], [])
        return rospy.Subscriber(topic, kind, kept.append, tcp_nodelay=True)

    def __getitem__(self, name):
        return self.messages[name]

    def status(self):
        """The last one: (level, message, values)."""
        if not self['diagnostics']:
            return None
        status = self['diagnostics'][-1].status[0]
        return status.level, status.message, {v.key: v.value for v in status.values}

    def wait_for_counts(self, seconds=60, **counts):
        """Waits until the node states them: wait_for_counts(samples=100, frames=10)."""
        def there():
            status = self.status()
            return status and all(float(status[2].get(name.replace('_', ' '), -1)) >= count
                                  for name, count in counts.items()) and status
        try:
            return wait_for(there, seconds, f'the node takes {counts}')
        except AssertionError as error:
            raise AssertionError(f'{error}; its last status: {self.status()}')

    def wait_for_node(self, seconds=30):
        """Waits until every publisher of the node is connected, so that no message is lost."""
        wait_for(lambda: all(s.get_num_connections() > 0 for s in self.subscribers), seconds,
                 'the node')


def node(**parameters):
    """The node with these private parameters; a nested dictionary is a group."""
    if rospy.has_param('/chasles'):
        rospy.delete_param('/chasles')
    if parameters:
        rospy.set_param('/chasles', {name: str(value) if isinstance(value, Path) else value
                                     for name, value in parameters.items()})
    return Process([NODE])


def play(bag, rate=4):
    arguments = ['rosbag', 'play', '--quiet', '--wait-for-subscribers', '--queue=100000', f'--rate={rate}', bag]
    subprocess.run([str(a) for a in arguments], check=True, timeout=60, stdout=subprocess.DEVNULL)
