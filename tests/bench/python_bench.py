#!/usr/bin/env python3
"""Processor time and latency of the Python package beside the command, on the same rendered walk.

    PYTHONPATH=build/release/python tests/bench/python_bench.py [CHASLES]

The command decodes the images ahead, on threads of its own; `Slam` gets them as arrays. Ratios are of one run."""

import resource
import statistics
import subprocess
import sys
import tempfile
import time

import chasles

WALK = ["sections=1", "hall_length=20", "frame_rate=20"]


def processor_seconds(who):
    usage = resource.getrusage(who)
    return usage.ru_utime + usage.ru_stime


def measured(who, work):
    started, cpu = time.monotonic(), processor_seconds(who)
    result = work()
    return time.monotonic() - started, processor_seconds(who) - cpu, result


def step_by_step(recording, slam):
    """The estimates, and how long each call with images took [s]."""
    imu, frames = recording.imu, recording.frame_times
    images = [recording.images(k) for k in range(len(frames))]
    ages, estimates, k = [], 0, 0
    started = processor_seconds(resource.RUSAGE_SELF)
    for i, stamp in enumerate(imu["time"]):
        estimates += len(slam.add_imu(int(stamp), imu["angular_rate"][i], imu["specific_force"][i]) or [])
        while k < len(frames) and frames[k] <= stamp:
            called = time.monotonic()
            got = slam.add_images(int(frames[k]), images[k])
            ages.append(time.monotonic() - called)
            estimates += len(got) if isinstance(got, list) else 0
            k += 1
    estimates += len(slam.finish())
    return estimates, ages, processor_seconds(resource.RUSAGE_SELF) - started


def main():
    command = sys.argv[1] if len(sys.argv) > 1 else "build/release/bin/chasles"
    with tempfile.TemporaryDirectory(prefix="chasles-bench-") as folder:
        walk = f"{folder}/walk"
        sets = [word for one in WALK for word in ("--set", one)]
        subprocess.run([command, "simulate", "hallway", "--images", *sets, "-o", walk, "--quiet"], check=True,
                       stdout=subprocess.DEVNULL)
        whole, cpu, _ = measured(
            resource.RUSAGE_CHILDREN,
            lambda: subprocess.run([command, "run", walk, "-o", f"{folder}/run", "--quiet", "--set", "exact_map=false"],
                                   check=True, stdout=subprocess.DEVNULL))
        recording = chasles.read(walk)
        run_wall, run_cpu, _ = measured(resource.RUSAGE_SELF, lambda: chasles.run(recording, exact_map="false"))
        estimates, ages, slam_cpu = step_by_step(recording, chasles.Slam(recording.cameras, recording.imu_noise))
        _, calls, realtime_cpu = step_by_step(
            recording, chasles.RealtimeSlam(recording.cameras, recording.imu_noise, most_images=0))
    n = len(ages)
    print(f"{n} images, {estimates} estimates\n")
    print("                         wall [s]   CPU [s]   CPU / command")
    for name, wall, seconds in (("command", whole, cpu), ("chasles.run", run_wall, run_cpu),
                                ("Slam, step by step", float("nan"), slam_cpu),
                                ("RealtimeSlam", float("nan"), realtime_cpu)):
        print(f"{name:22s} {wall:10.2f} {seconds:9.2f} {seconds / cpu:15.2f}")
    print(f"\nadd_images: median {1e3 * statistics.median(ages):.2f} ms (Slam), "
          f"{1e3 * statistics.median(calls):.3f} ms (RealtimeSlam)")


if __name__ == "__main__":
    main()
