"""Recordings of arrays, and checks, against the same recording as it was."""

import json
import os
import subprocess

import numpy
import pytest

import chasles

BINARY = os.environ.get("CHASLES_BINARY")
SMALL = {"image_width": 320, "image_height": 240, "focal_length": 180, "center_u": 160, "center_v": 120, "frame_rate": 10,
         "sections": 1, "hall_length": 6}


@pytest.fixture(scope="module")
def walk():
    return chasles.simulate("hallway", images=True, **SMALL)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("walk") / "walk"
    sets = [word for name, value in SMALL.items() for word in ("--set", f"{name}={value}")]
    assert chasles.command("simulate", "hallway", "--images", *sets, "-o", folder, "--quiet") == 0
    return folder


def arguments_of(recording, **others):
    imu = recording.imu
    return {"imu_time": imu["time"], "angular_rate": imu["angular_rate"], "specific_force": imu["specific_force"],
            "image_time": recording.frame_times, "images": recording.images, "cameras": recording.cameras,
            "imu_noise": recording.imu_noise, "truth": recording.truth, **others}


@pytest.mark.parametrize("form", ["function", "list", "array", "paths", "seconds"])
def test_arrays_give_the_run_of_the_recording(walk, folder, form):
    recording = chasles.read(folder)
    pictures = [recording.images(i)[0] for i in range(len(recording))]
    files = sorted((folder / "mav0/cam0/data").glob("*.png"), key=lambda file: int(file.stem))
    assert len(files) == len(recording)
    others = {"function": {}, "list": {"images": [[one] for one in pictures]}, "array": {"images": numpy.stack(pictures)},
              "paths": {"images": files},
              "seconds": {"imu_time": [1e-9 * int(t) for t in recording.imu["time"]],
                          "image_time": [1e-9 * int(t) for t in recording.frame_times], "truth": None}}[form]
    made = chasles.Recording.from_arrays(**arguments_of(recording, **others))
    assert len(made) == len(recording) and numpy.array_equal(made.imu["time"], recording.imu["time"])
    assert numpy.array_equal(made.images(3)[0], recording.images(3)[0])
    assert numpy.array_equal(chasles.run(made).states["position"], chasles.run(recording).states["position"])


def test_errors_of_images_come_out_as_they_are(walk):
    def broken(i):
        if i == 4:
            raise ZeroDivisionError("mine")
        return walk.images(i)

    with pytest.raises(ZeroDivisionError, match="mine"):
        chasles.run(chasles.Recording.from_arrays(**arguments_of(walk, images=broken)))


@pytest.mark.parametrize("change, says", [
    (lambda a: {"images": a["images"][:-1] if isinstance(a["images"], list) else [None]}, "as many"),
    (lambda a: {"imu_time": a["imu_time"][::-1]}, "times that rise"),
    (lambda a: {"imu_time": a["imu_time"][:-1]}, "expected (N,), (N, 3) and (N, 3)"),
    (lambda a: {"specific_force": a["specific_force"] * numpy.nan}, "not finite"),
    (lambda a: {"cameras": []}, "camera"),
    (lambda a: {"image_time": numpy.concatenate([a["image_time"][:1], a["image_time"][:-1]])}, "image_time"),
    (lambda a: {"imu_time": numpy.zeros(0, int), "angular_rate": numpy.zeros((0, 3)), "specific_force": numpy.zeros((0, 3))},
     "0 IMU samples"),
])
def test_arrays_that_do_not_fit_are_errors(walk, change, says):
    arguments = arguments_of(walk)
    with pytest.raises(chasles.Error) as caught:
        chasles.Recording.from_arrays(**{**arguments, **change(arguments)})
    assert says in str(caught.value)


def test_an_image_of_another_size_is_an_error(walk):
    made = chasles.Recording.from_arrays(**arguments_of(walk, images=lambda i: numpy.zeros((10, 20), numpy.uint8)))
    with pytest.raises(chasles.InputError, match="has 20 x 10 pixels, expected 320 x 240"):
        made.images(0)
    none = chasles.Recording.from_arrays(**arguments_of(walk, imu_noise=None))
    with pytest.raises(chasles.InputError, match="no IMU noise"):
        chasles.run(none)


@pytest.mark.skipif(BINARY is None, reason="CHASLES_BINARY names no command")
def test_a_check_is_that_of_the_command(folder):
    done = subprocess.run([BINARY, "check", folder, "--json"], capture_output=True, text=True, timeout=120)
    check = chasles.check(folder)
    assert check.report == json.loads(done.stdout)
    assert check.ok == (done.returncode == 0)
    assert [vars(finding) for finding in check] == check.report["findings"] and len(check) == len(check.findings)
    text = subprocess.run([BINARY, "check", folder], capture_output=True, text=True, timeout=120).stdout
    assert str(check) == text
    assert check and "walk" in repr(check) and check._repr_html_().startswith("<pre>")


def test_a_check_finds_what_is_wrong(walk):
    imu = walk.imu
    degrees = chasles.Recording.from_arrays(**arguments_of(walk, angular_rate=numpy.degrees(imu["angular_rate"])))
    check = chasles.check(degrees)
    assert not check.ok and any(finding.severity == "error" and finding.advice for finding in check.findings)
    assert not any("--" in finding.advice + finding.what for finding in check.findings)
    with pytest.raises(ValueError, match="seconds"):
        chasles.check(walk, seconds=0)
