#!/usr/bin/env python3
"""SLAM with a camera and an IMU in real time, with the timing of every image.

    webcam_and_imu.py --calibration calibration.json --camera 0 --imu 5005    a webcam, and an IMU that sends UDP
    webcam_and_imu.py --play MH_01_easy                                       a recording, at the speed it was recorded

The IMU sends lines `time_ns wx wy wz fx fy fz` (angular rate [rad/s], specific force [m/s^2]) to the UDP port on this
machine's loopback. Its times are those of the monotonic clock (CLOCK_MONOTONIC, Python's time.monotonic_ns), by which
the images are stamped here when the camera delivers them; what remains of their delay is estimated
(calibrate_time_offset). calibration.json has the arguments of chasles.Camera and chasles.ImuNoise:

    {"camera": {"width": 640, "height": 480, "fx": 600, "fy": 600, "cx": 320, "cy": 240, "distortion": "radtan",
                "coefficients": [0.1, -0.2, 0, 0], "cam_T_imu": [[...], [...], [...], [0, 0, 0, 1]]},
     "imu": {"accelerometer_noise_density": 0.002, "gyroscope_noise_density": 0.0002,
             "accelerometer_random_walk": 0.0003, "gyroscope_random_walk": 2e-05}}

A sensor's thread never waits for the estimator: an image for which there is no time gives way to a newer one, and is
counted. Each line says how old the image is when its estimate is there, and what was dropped so far.
"""

import argparse
import json
import socket
import sys
import threading
import time

import numpy

import chasles


class Recorded:
    """The sensors of a recording, at the speed at which they were recorded."""

    def __init__(self, recording, speed):
        self.recording, self.speed = recording, speed
        self.cameras, self.noise = recording.cameras, recording.imu_noise
        imu = recording.imu
        frames = recording.frame_times
        # Samples before images of the same time.
        self.order = sorted([(t, 0, i) for i, t in enumerate(imu["time"])] + [(t, 1, i) for i, t in enumerate(frames)])

    def play(self, on_imu, on_images, stop):
        imu = self.recording.imu
        started, first = time.monotonic(), self.order[0][0]
        for stamp, is_image, i in self.order:
            if stop.is_set():
                return
            images = self.recording.images(i) if is_image else None  # decoded before it is due
            due = started + (stamp - first) / 1e9 / self.speed
            time.sleep(max(0.0, due - time.monotonic()))
            if is_image:
                on_images(int(stamp), images)
            else:
                on_imu(int(stamp), imu["angular_rate"][i], imu["specific_force"][i])


class Live:
    """A webcam and an IMU that sends UDP."""

    def __init__(self, calibration, camera, port):
        import cv2  # for the webcam alone: python3-opencv, or pip install opencv-python

        self.cameras = [chasles.Camera(**calibration["camera"])]
        self.noise = chasles.ImuNoise(**calibration["imu"])
        self.port, self.cv2 = port, cv2
        self.video = cv2.VideoCapture(camera)
        if not self.video.isOpened():
            sys.exit(f"camera {camera}: cannot be opened; is it connected, and not in use?")

    def play(self, on_imu, on_images, stop):
        samples = threading.Thread(target=self._samples, args=(on_imu, stop), daemon=True)
        samples.start()
        while not stop.is_set():
            found, image = self.video.read()
            stamp = time.monotonic_ns()
            if not found:
                print("camera: no more images", file=sys.stderr)
                return
            on_images(stamp, [self.cv2.cvtColor(image, self.cv2.COLOR_BGR2GRAY)])

    def _samples(self, on_imu, stop):
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as receiver:
            receiver.bind(("127.0.0.1", self.port))
            receiver.settimeout(0.5)
            while not stop.is_set():
                try:
                    lines = receiver.recv(65536).decode("ascii", "replace")
                except socket.timeout:
                    continue
                for line in lines.splitlines():
                    try:
                        stamp, *values = line.split()
                        values = numpy.array(values, float).reshape(2, 3)
                        on_imu(int(stamp), values[0], values[1])
                    except ValueError:
                        print(f"IMU: found '{line[:80]}', expected: time_ns wx wy wz fx fy fz", file=sys.stderr)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--play", metavar="RECORDING", help="a recording of any kind that chasles reads")
    parser.add_argument("--speed", type=float, default=1, help="of --play: recorded seconds per second")
    parser.add_argument("--stop", type=float, help="of --play: ends after so many recorded seconds")
    parser.add_argument("--camera", type=int, default=0, help="number of the webcam")
    parser.add_argument("--imu", type=int, default=5005, metavar="PORT", help="UDP port of the IMU")
    parser.add_argument("--calibration", metavar="FILE")
    parser.add_argument("--most-images", type=int, default=2, help="that may wait for the estimator")
    options = parser.parse_args()
    if options.play:
        sensors = Recorded(chasles.read(options.play, stop=options.stop), options.speed)
    elif options.calibration:
        with open(options.calibration, encoding="utf-8") as file:
            sensors = Live(json.load(file), options.camera, options.imu)
    else:
        parser.error("expected --play RECORDING, or --calibration FILE for a webcam")

    slam = chasles.RealtimeSlam(sensors.cameras, sensors.noise, most_images=options.most_images)
    arrived = {}  # when an image came, by its stamp

    def on_images(stamp, images):
        arrived[stamp] = time.monotonic()
        slam.add_images(stamp, images)

    stop, ended = threading.Event(), threading.Event()
    failure = []

    def feed():
        try:
            sensors.play(slam.add_imu, on_images, stop)
        except Exception as error:  # reported by the main thread
            failure.append(error)
        finally:
            ended.set()

    thread = threading.Thread(target=feed, daemon=True)
    thread.start()
    ages = []

    def report(estimates):
        now = time.monotonic()
        for e in estimates:
            # An estimated time offset moves the estimate's time a little from the image's stamp.
            stamp = min(arrived, key=lambda t: abs(t - e.time))
            ages.append(now - arrived[stamp])
            for old in [t for t in arrived if t <= stamp]:
                del arrived[old]
            sigma = numpy.sqrt(numpy.diag(e.pose_covariance)[3:])
            x, y, z = e.position
            print(f"{e.seconds:.3f} s  {x:8.3f} {y:8.3f} {z:8.3f} m  +- {sigma.max():.3f} m  {e.health}  "
                  f"{1e3 * ages[-1]:.0f} ms old, {slam.counts['dropped']} dropped", flush=True)

    try:
        while not ended.wait(0.01):
            report(slam.take())
        thread.join()
        report(slam.finish())
    except KeyboardInterrupt:
        stop.set()
    if failure:
        sys.exit(f"error: {failure[0]}")
    counts = slam.counts
    if not ages:
        sys.exit(f"no estimate of {counts['came']} images, {counts['dropped']} dropped: {slam.why_not_started}")
    print(f"{len(ages)} estimates of {counts['came']} images, {counts['dropped']} dropped; age of an estimate: median "
          f"{1e3 * numpy.median(ages):.0f} ms, 99 % below {1e3 * numpy.quantile(ages, 0.99):.0f} ms", flush=True)


if __name__ == "__main__":
    main()
