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
    fact = chasles.check(walk, calibration=True).facts["cam0"]
    assert fact["lens against the motion over its sigma"]["value"] < 4


class Pillow:
    """What numpy and chasles use of an image of Pillow."""

    def __init__(self, mode, values):
        self.mode, self.values = mode, values

    def getbands(self):
        return tuple(self.mode)

    def convert(self, mode):
        assert mode == "RGB"
        return Pillow(mode, self.values[..., :3])

    def __array__(self, dtype=None, copy=None):
        return self.values


def test_images_of_pillow_are_grey_as_files_are(walk, tmp_path):
    rng = numpy.random.default_rng(7)
    colours = rng.integers(0, 256, (240, 320, 3), dtype=numpy.uint8)
    expected = ((colours.astype(int) @ [9797, 19234, 3737]) >> 15).astype(numpy.uint8)
    made = chasles.Recording.from_arrays(**arguments_of(walk, images=lambda i: Pillow(("RGB", "RGBA")[i % 2], colours)))
    assert (made.images(0)[0] == expected).all() and (made.images(1)[0] == expected).all()
    grey = chasles.Recording.from_arrays(**arguments_of(walk, images=lambda i: [Pillow("L", expected)]))
    assert (grey.images(0)[0] == expected).all()
    deep = chasles.Recording.from_arrays(**arguments_of(walk, images=lambda i: Pillow("I;16", expected)))
    with pytest.raises(ValueError, match="mode I;16, expected one of 8 bits"):
        deep.images(0)
    image = pytest.importorskip("PIL.Image").fromarray(colours)
    image.save(tmp_path / "a.png")
    real = chasles.Recording.from_arrays(**arguments_of(walk, images=lambda i: image if i else tmp_path / "a.png"))
    assert (real.images(0)[0] == real.images(1)[0]).all() and (real.images(1)[0] == expected).all()


@pytest.mark.parametrize("image, says", [
    (numpy.zeros((240, 320, 3), numpy.uint8), "found an array (240, 320, 3) of uint8; expected grey"),
    (numpy.zeros((240, 320, 4), numpy.uint8), "the order of the colours is not known: cv2.cvtColor"),
    (numpy.zeros((240, 320), numpy.float32), "found an array (240, 320) of float32; expected grey"),
    (numpy.zeros((240, 320), numpy.uint16), "of uint16; expected grey"),
    (5, "found an object of type int; expected grey"),
    ([numpy.zeros((240, 320), numpy.uint8)] * 2, "frame 0 has 2 images, expected 1"),
])
def test_images_that_are_none_are_one_error_of_one_line(walk, capfd, image, says):
    made = chasles.Recording.from_arrays(**arguments_of(walk, images=lambda i: image))
    for call in (lambda: made.images(0), lambda: chasles.run(made),
                 lambda: chasles.Recording.from_arrays(**arguments_of(walk, images=[image] * len(walk)))):
        with pytest.raises(ValueError) as caught:
            call()
        assert says in str(caught.value) and "\n" not in str(caught.value)
    assert capfd.readouterr().err == ""
    slam = chasles.Slam(walk.cameras[0], walk.imu_noise)
    with pytest.raises(ValueError):
        slam.add_images(0, image)


def test_slam_takes_the_image_of_one_camera_alone(walk):
    slams = chasles.Slam(walk.cameras[0], walk.imu_noise, map=None), chasles.Slam(walk.cameras, walk.imu_noise)
    imu = walk.imu
    for slam, bare in zip(slams, (True, False)):
        slam.add_imu(imu["time"], imu["angular_rate"], imu["specific_force"])
        for i, time in enumerate(walk.frame_times[:20]):
            slam.add_images(int(time), walk.images(i)[0] if bare else walk.images(i))
    assert slams[0].counts == slams[1].counts and slams[0].started == slams[1].started


def test_microseconds_are_an_error(walk):
    with pytest.raises(chasles.InputError, match="expected nanoseconds and at most .* are these microseconds"):
        chasles.Recording.from_arrays(**arguments_of(walk, imu_time=walk.imu["time"] // 1000,
                                                     image_time=walk.frame_times // 1000, truth=None))


def changed(truth, name, values):
    return {**truth, name: values}


@pytest.mark.parametrize("bad, says", [
    (lambda t: changed(t, "position", numpy.where(numpy.arange(len(t["time"]))[:, None] == 5, numpy.nan, t["position"])),
     "truth: row 5 is not finite"),
    (lambda t: changed(t, "time", t["time"][::-1]), "truth: row 1 has the time"),
    (lambda t: changed(t, "time", t["time"][:-1]), "truth: found"),
    (lambda t: changed(t, "position", t["position"][:, :2]), "expected (N,), (N, 3) and (N, 4)"),
    (lambda t: changed(t, "position", "a"), "truth: position: found 'a'"),
    (lambda t: changed(t, "quaternion", 0 * t["quaternion"]), "truth: row 0 has a quaternion of length 0"),
    (lambda t: {"position": t["position"]}, "truth: found columns position"),
    (lambda t: [1, 2], "truth: found [1, 2]"),
    (lambda t: "/none.tum", "/none.tum: no such file"),
])
def test_a_truth_that_is_none_is_an_error_that_names_it(walk, bad, says):
    with pytest.raises(chasles.InputError) as caught:
        chasles.Recording.from_arrays(**arguments_of(walk, truth=bad(walk.truth)))
    assert says in str(caught.value)


def test_a_truth_of_a_file_is_read(walk, tmp_path):
    truth = walk.truth
    rows = numpy.column_stack([truth["time"] * 1e-9, truth["position"], truth["quaternion"]])
    numpy.savetxt(tmp_path / "truth.tum", rows, fmt="%.9f")
    made = chasles.Recording.from_arrays(**arguments_of(walk, truth=tmp_path / "truth.tum"))
    assert (made.truth["time"] == truth["time"]).all() and abs(made.truth["position"] - truth["position"]).max() < 1e-8
