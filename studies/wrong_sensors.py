"""Simulated recordings whose calibration or IMU is wrong by known errors. Needs NumPy."""

import pathlib
import typing

import numpy

from studies.arrays import Array

# Sigmas of the errors of the stated calibration: rotation [rad], position [m], focal length [1], principal point [px],
# coefficients of the lens [1], readout [s] and clock [s].
TURN, SHIFT, FOCAL, CENTRE, DISTORTION, READOUT, CLOCK = 0.0035, 0.005, 0.004, 3.0, 0.01, 0.001, 0.003
TANGENTIAL = 0.1  # of the sigma of a radial coefficient (slam/inertial_calibration.cpp)
# The default sigmas of the IMU: scale [1], misalignment [rad], g-sensitivity [rad/s/(m/s^2)].
SCALE, MISALIGNMENT, G_SENSITIVITY = 0.005, 0.002, 0.0002


class Wrong:
    """Writes errors into the calibration of a recording with one camera, and knows the true parameters."""

    def __init__(self, recording: pathlib.Path, seed: int) -> None:
        self.draw = numpy.random.default_rng(seed)
        text = (recording / "calibration.yaml").read_text()
        begin = text.index("    cam_T_imu:")
        rows = [line.split("[")[1].rstrip("]") for line in text[begin:].splitlines()[1:5]]
        cam_T_imu = numpy.array([[float(x) for x in row.split(",")] for row in rows])
        imu_T_cam = numpy.linalg.inv(cam_T_imu)
        turn, shift = self.normal(3, TURN), self.normal(3, SHIFT)
        stated = numpy.eye(4)
        stated[:3, :3], stated[:3, 3] = exp(turn) @ imu_T_cam[:3, :3], imu_T_cam[:3, 3] + shift
        self.true = {f"imu_T_cam0_turned_{axis}": -x for axis, x in zip("xyz", turn)}
        self.true |= {f"imu_T_cam0_{axis}": x for axis, x in zip("xyz", imu_T_cam[:3, 3])}
        listed = "".join(f"      - [{', '.join(map(repr, row.tolist()))}]\n" for row in numpy.linalg.inv(stated))
        text = text[:begin] + "    cam_T_imu:\n" + listed + text[text.index("    readout_time"):]
        text = self.change(text, "intrinsics", ("fx", "fy", "cx", "cy"),
                           lambda x: (FOCAL * x[0], FOCAL * x[1], CENTRE, CENTRE))
        text = self.change(text, "distortion_coeffs", ("k1", "k2", "p1", "p2"),
                           lambda _: (DISTORTION, DISTORTION, TANGENTIAL * DISTORTION, TANGENTIAL * DISTORTION))
        text = self.change(text, "readout_time", ("readout_time",), lambda _: (READOUT,))
        (recording / "calibration.yaml").write_text(text)
        self.true["time_offset"] = 0.0
        self.clock = float(self.normal(1, CLOCK)[0])

    def normal(self, count: int, sigma: float) -> Array:
        return sigma * self.draw.standard_normal(count)

    def change(self, text: str, key: str, names: typing.Sequence[str],
               sigmas: typing.Callable[[list[float]], typing.Sequence[float]]) -> str:
        begin = text.index(f"    {key}: ")
        line = text[begin:text.index("\n", begin)]
        values = [float(x) for x in line.split(": ")[1].strip("[]").split(",")]
        self.true |= {f"cam0_{name}": value for name, value in zip(names, values)}
        moved = [value + float(self.normal(1, sigma)[0]) for value, sigma in zip(values, sigmas(values))]
        number_text = repr(moved[0]) if len(moved) == 1 else f"[{', '.join(map(repr, moved))}]"
        return text.replace(line, f"    {key}: {number_text}")


def exp(turn: Array) -> Array:
    angle = float(numpy.linalg.norm(turn))
    x, y, z = turn / angle
    K = numpy.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    R: Array = numpy.eye(3) + numpy.sin(angle) * K + (1 - numpy.cos(angle)) * K @ K
    return R


class WrongImu:
    """Gives the IMU of a recording errors of scale, misalignment and g-sensitivity, which it knows."""

    def __init__(self, recording: pathlib.Path, seed: int, scale_alone: bool) -> None:
        draw = numpy.random.default_rng(seed)
        force, rate = (SCALE * numpy.diag(draw.standard_normal(3)) for _ in range(2))
        others = 0 if scale_alone else 1
        force[numpy.tril_indices(3, -1)] = others * MISALIGNMENT * draw.standard_normal(3)
        rate[~numpy.eye(3, dtype=bool)] = others * MISALIGNMENT * draw.standard_normal(6)
        of_force = others * G_SENSITIVITY * draw.standard_normal((3, 3))
        self.true: dict[str, float] = {}
        for i, x in enumerate("xyz"):
            for j, y in enumerate("xyz"):
                kind = f"scale_{x}" if i == j else f"misalignment_{x}_{y}"
                self.true |= {f"accelerometer_{kind}": force[i, j], f"gyroscope_{kind}": rate[i, j],
                              f"g_sensitivity_{x}_{y}": of_force[i, j]}
        table = recording / "imu.csv"
        header, *lines = table.read_text().splitlines()
        times = [line.split(",")[0] for line in lines]
        samples = numpy.array([[float(x) for x in line.split(",")[1:]] for line in lines])
        w, f = samples[:, :3], samples[:, 3:]
        measured = numpy.hstack([(w + f @ of_force.T) @ numpy.linalg.inv(numpy.eye(3) + rate).T,
                                 f @ numpy.linalg.inv(numpy.eye(3) + force).T])
        rows = (",".join([time, *map(repr, row)]) for time, row in zip(times, measured.tolist()))
        table.write_text("\n".join([header, *rows, ""]))
