"""Renders the recordings of studies/many.py: walks and flights of an action camera, some of them faulty."""

import concurrent.futures
import dataclasses
import gzip
import pathlib
import random
import re
import shutil
import typing

from studies.program import EUROC, Argument, Json, assignments, chasles, sets

# An action camera: a wide lens and a shutter that rolls.
CAMERA: Json = {"image_width": 640, "image_height": 480, "focal_length": 290, "center_u": 319.5, "center_v": 239.5,
                "distortion": "equidistant", "distortion_1": 0.03, "distortion_2": -0.01, "readout_time": 0.016,
                "frame_rate": 20, "imu_rate": 200, "accelerometer_noise_density": 2e-3,
                "gyroscope_noise_density": 1.7e-4, "exposure_drift": 0.5, "vignetting": 0.3}
SECONDS = 12
# Flights of EuRoC, in pieces.
FLIGHTS = ("MH_01_easy", "V1_01_easy", "V1_02_medium", "V2_01_easy")


def pieces() -> typing.Iterator[list[str]]:
    """Rows of TUM of SECONDS each, one piece of each flight in turn."""
    flights = []
    for name in FLIGHTS:
        with gzip.open(EUROC / f"imu_gt/{name}_gt.csv.gz", "rt") as table:
            rows = [line.split(",") for line in table if line[0].isdigit()]
        times = [int(row[0]) for row in rows]
        tum = [f"{t // 10**9}.{t % 10**9:09d} {' '.join(r[1:4])} {' '.join(r[5:8])} {r[4]}\n"
               for t, r in zip(times, rows)]
        flights.append((times, tum))
    for number in range(1000):
        for times, tum in flights:
            start = times[0] + int((number + 0.5) * SECONDS * 1e9)
            if start + SECONDS * 10**9 <= times[-1]:
                yield [line for time, line in zip(times, tum) if start <= time <= start + SECONDS * 10**9]


def walk(number: int) -> tuple[str, list[Argument], Json]:
    chance = random.Random(number)
    return "walk", [], {"walk_duration": SECONDS, "walking_speed": round(chance.uniform(0.5, 1.5), 2),
                        "yaw_amplitude": round(chance.uniform(0.02, 0.1), 3),
                        "rest_duration": chance.choice((0, 2))}


def table(recording: pathlib.Path, sensor: str, change: typing.Callable[[list[str], float], list[str] | None]) -> None:
    """Changes the rows of mav0/SENSOR/data.csv, given with their second; None leaves a row out."""
    file = recording / "mav0" / sensor / "data.csv"
    head, *rows = file.read_text().splitlines()
    split = [row.split(",") for row in rows]
    first = int(split[0][0])
    changed = (change(row, (int(row[0]) - first) / 1e9) for row in split)
    file.write_text("\n".join([head, *(",".join(row) for row in changed if row is not None)]) + "\n")


def yaml(recording: pathlib.Path, pattern: str, replacement: str) -> None:
    """Changes the calibration of the camera."""
    file = recording / "mav0/cam0/sensor.yaml"
    text, count = re.subn(pattern, replacement, file.read_text())
    assert count == 1, (pattern, file)
    file.write_text(text)


def scaled(row: list[str], columns: slice, factor: float) -> list[str]:
    row[columns] = [repr(float(x) * factor) for x in row[columns]]
    return row


GYROSCOPE, ACCELEROMETER = slice(1, 4), slice(4, 7)


def focal_length(recording: pathlib.Path) -> None:
    yaml(recording, r"intrinsics: \[290, 290", "intrinsics: [319, 319")


def mounting(recording: pathlib.Path) -> None:
    """The camera is turned about its optical axis by 10 degrees."""
    yaml(recording, r"data: \[[^\]]*\]", "data: [0.17343, -0.04922, 0.98358, 0.05, -0.98481, -0.00867, 0.17343, 0.02, "
         "0, -0.99875, -0.04998, 0.03, 0, 0, 0, 1]")


def late_images(recording: pathlib.Path) -> None:
    table(recording, "cam0", lambda row, _: [str(int(row[0]) + 120_000_000), *row[1:]])


def accelerometer_sign(recording: pathlib.Path) -> None:
    table(recording, "imu0", lambda row, _: scaled(row, ACCELEROMETER, -1))


def accelerometer_in_g(recording: pathlib.Path) -> None:
    table(recording, "imu0", lambda row, _: scaled(row, ACCELEROMETER, 1 / 9.80665))


def gyroscope_in_degrees(recording: pathlib.Path) -> None:
    table(recording, "imu0", lambda row, _: scaled(row, GYROSCOPE, 57.29578))


def gyroscope_axes(recording: pathlib.Path) -> None:
    table(recording, "imu0", lambda row, _: [row[0], row[2], row[1], row[3], *row[4:]])


def saturated(recording: pathlib.Path) -> None:
    def change(row: list[str], _: float) -> list[str]:
        row[GYROSCOPE] = [repr(max(-0.15, min(0.15, float(x)))) for x in row[GYROSCOPE]]
        return row

    table(recording, "imu0", change)


def no_samples_for_4_s(recording: pathlib.Path) -> None:
    table(recording, "imu0", lambda row, second: None if 5 < second < 9 else row)


def samples_end_early(recording: pathlib.Path) -> None:
    table(recording, "imu0", lambda row, second: row if second < 5 else None)


def clock_since_boot(recording: pathlib.Path) -> None:
    table(recording, "imu0", lambda row, _: [str(int(row[0]) + 10**15), *row[1:]])


def covered(recording: pathlib.Path) -> None:
    """The camera looks at nothing for the last 7 seconds."""
    images = sorted((recording / "mav0/cam0/data").iterdir(), key=lambda image: int(image.stem))
    black = recording / "black.png"
    black.write_bytes(BLACK)
    for image in images[-7 * CAMERA["frame_rate"]:]:
        shutil.copyfile(black, image)
    black.unlink()


def frozen(recording: pathlib.Path) -> None:
    """The same image for 4 seconds, with new times."""
    images = sorted((recording / "mav0/cam0/data").iterdir(), key=lambda image: int(image.stem))
    for image in images[101:181]:
        shutil.copyfile(images[100], image)


def torn(recording: pathlib.Path) -> None:
    for image in sorted((recording / "mav0/cam0/data").iterdir())[::2]:
        image.write_bytes(image.read_bytes()[:1000])


def few_images(recording: pathlib.Path) -> None:
    table(recording, "cam0", lambda row, second: row if int(second * CAMERA["frame_rate"]) % 20 == 0 else None)


def no_images(recording: pathlib.Path) -> None:
    shutil.rmtree(recording / "mav0/cam0/data")


def no_calibration(recording: pathlib.Path) -> None:
    (recording / "mav0/cam0/sensor.yaml").unlink()


def other_size(recording: pathlib.Path) -> None:
    yaml(recording, r"resolution: \[640, 480\]", "resolution: [1280, 960]")


def table_cut(recording: pathlib.Path) -> None:
    file = recording / "mav0/imu0/data.csv"
    text = file.read_text()
    file.write_text(text[:len(text) // 2])


def empty_table(recording: pathlib.Path) -> None:
    (recording / "mav0/imu0/data.csv").write_text("")


def black_png() -> bytes:
    import struct
    import zlib
    width, height = CAMERA["image_width"], CAMERA["image_height"]

    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0))
            + chunk(b"IDAT", zlib.compress((b"\0" + bytes(width)) * height)) + chunk(b"IEND", b""))


BLACK = black_png()


# Words of `reasons` for several reasons of the program.
KINDS = {"check": ("check_error", "check_warning"), "coverage": ("coverage", "few_estimates"),
         "health": ("degraded", "lost")}


@dataclasses.dataclass(frozen=True)
class Fault:
    make: typing.Callable[[pathlib.Path], None]
    reasons: tuple[str, ...]  # of a verdict that is right: one of these

    def is_named(self, record: Json) -> bool:
        """Whether one of the reasons is right."""
        found = {one["reason"] for one in record["reasons"]}
        return any(found & set(KINDS.get(name, (name,))) for name in self.reasons)


FAULTS = (
    Fault(focal_length, ("check", "calibration", "innovations")),
    Fault(mounting, ("check", "calibration")),
    Fault(late_images, ("check", "calibration")),
    Fault(accelerometer_sign, ("check", "not_initialised")),
    Fault(accelerometer_in_g, ("check", "not_initialised")),
    Fault(gyroscope_in_degrees, ("check", "not_initialised")),
    Fault(gyroscope_axes, ("check", "not_initialised")),
    Fault(saturated, ("check", "imu")),
    Fault(no_samples_for_4_s, ("check", "imu", "coverage")),
    Fault(samples_end_early, ("check", "coverage")),
    Fault(clock_since_boot, ("unreadable",)),
    Fault(covered, ("check", "coverage", "health", "uncertain")),
    Fault(frozen, ("check", "health", "innovations")),
    Fault(torn, ("check", "images")),
    Fault(few_images, ("check", "not_initialised")),
    Fault(no_images, ("unreadable",)),
    Fault(no_calibration, ("unreadable",)),
    Fault(other_size, ("unreadable",)),
    Fault(table_cut, ("check", "coverage")),
    Fault(empty_table, ("unreadable",)),
)


def fault_of(number: int) -> Fault | None:
    """Every tenth recording is faulty, each in its own way: walks and flights in turn."""
    return FAULTS[number // 10 % len(FAULTS)] if number % 20 in (4, 17) else None


def make(folder: pathlib.Path, number: int, path: list[str]) -> pathlib.Path:
    """Recording NUMBER, unless it is there: even ones walk, odd ones fly along the path."""
    recording = folder / f"{'walk' if number % 2 == 0 else 'flight'}-{number:03d}"
    if recording.exists():
        return recording
    part = recording.with_suffix(".part")
    shutil.rmtree(part, ignore_errors=True)
    tum = folder / f"{number}.tum"
    scene, more, settings = walk(number)
    if number % 2 == 1:
        tum.write_text("".join(path))
        scene, more, settings = "trajectory", ["--path", tum], {}
    chasles("simulate", scene, *more, *sets(*assignments(CAMERA | settings | {"seed": number + 1})), "--images",
            "--run", number, "--threads", 1, "--quiet", "-o", part)
    # As of a calibration of people: right, and not stated to be exact.
    yaml(part, r"# The images[^\n]*\ncalibration_is_exact: true\n", "")
    if fault := fault_of(number):
        fault.make(part)
    tum.unlink(missing_ok=True)
    part.rename(recording)
    return recording


def make_all(folder: pathlib.Path, count: int, workers: int) -> list[pathlib.Path]:
    folder.mkdir(parents=True, exist_ok=True)
    paths = list(pieces())
    with concurrent.futures.ThreadPoolExecutor(workers) as pool:
        return list(pool.map(lambda i: make(folder, i, paths[i // 2 % len(paths)]), range(count)))
