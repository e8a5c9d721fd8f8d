"""A simulated walk, the bridge beside a test, and the run folders, for the tests in Python."""
import csv
import os
import signal
import subprocess
import time
from pathlib import Path

CHASLES = os.environ['CHASLES_BINARY']
BRIDGE = os.environ['CHASLES_DDS_BINARY']
SCENE = ('sections=1 hall_length=6 rest_duration=1 frame_rate=10 focal_length=160 image_width=240 '
         'image_height=180 center_u=119.5 center_v=89.5').split()


def simulate(folder):
    sets = [part for text in SCENE for part in ('--set', text)]
    subprocess.run([CHASLES, 'simulate', 'hallway', '--images', '-o', folder / 'walk', '--quiet', *sets],
                   check=True, timeout=60)
    for sensor in ('cam0', 'imu0', 'state_groundtruth_estimate0'):
        begin_later(folder / 'walk/mav0' / sensor / 'data.csv')
    subprocess.run([CHASLES, 'run', folder / 'walk', '-o', folder / 'command', '--quiet'], check=True,
                   timeout=60)
    return folder / 'walk'


def begin_later(file):
    """A stamp of 0 is none, and the simulated time begins there: the walk is one second later."""
    def later(line):
        time_ns, rest = line.split(',', 1)
        return line if line.startswith('#') else f'{int(time_ns) + 10**9},{rest}'
    file.write_text(''.join(map(later, file.read_text().splitlines(keepends=True))))


def table(file):
    with open(file, newline='') as stream:
        return list(csv.reader(line for line in stream if not line.startswith('#')))


def images(walk):
    """(time in ns, file) of cam0."""
    return [(int(row[0]), walk / 'mav0/cam0/data' / row[1].strip())
            for row in table(walk / 'mav0/cam0/data.csv')]


def samples(walk):
    """(time in ns, angular rate, specific force)."""
    rows = table(walk / 'mav0/imu0/data.csv')
    return [(int(row[0]), [float(x) for x in row[1:4]], [float(x) for x in row[4:7]]) for row in rows]


def events(walk):
    """All of both in order of time: (time, 'imu', rate, force) and (time, 'image', file)."""
    every = [(t, 'imu', w, a) for t, w, a in samples(walk)]
    every += [(t, 'image', file) for t, file in images(walk)]
    return sorted(every, key=lambda event: (event[0], event[1]))


def states(run):
    """The rows of states.csv by time in ns, each a dictionary."""
    with open(run / 'states.csv', newline='') as stream:
        return {int(row['time_ns']): row for row in csv.DictReader(stream)}


class Bridge:
    """chasles_dds beside the test."""

    def __init__(self, folder, domain, *more):
        self.log = folder / 'log.txt'
        with open(self.log, 'w') as log:
            self.process = subprocess.Popen(
                [BRIDGE, folder / 'walk', '--domain', str(domain), '--reliable', '--lossless', '-o',
                 folder / 'bridge', *more], stdout=log, stderr=log)

    def finish(self):
        self.process.send_signal(signal.SIGINT)
        return self.process.wait(30)

    def kill(self):
        if self.process.poll() is None:
            self.process.kill()
            self.process.wait()


def is_heard(diagnostics):
    """Whether the bridge hears the topics, by its last diagnostics: peers find each other at times of their
    own."""
    if not diagnostics:
        return False
    values = {value.key: value.value for value in diagnostics[-1].status[0].values}
    return all(values.get('publishers of ' + topic) == '1' for topic in ('/imu0', '/cam0/image_raw'))


def wait_until(condition, seconds, step=lambda: time.sleep(0.02)):
    end = time.monotonic() + seconds
    while not condition():
        if time.monotonic() > end:
            return False
        step()
    return True
