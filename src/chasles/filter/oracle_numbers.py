#!/usr/bin/env python3
"""Writes oracle_numbers_testing.hpp: what oracle_test.cpp needs of the fixtures of an independent numpy
implementation (one case a chart), in the order of this project's errors:

    /usr/bin/python3 src/chasles/filter/oracle_numbers.py ../shared/oracle/fixtures.json \\
        > src/chasles/filter/oracle_numbers_testing.hpp
"""

import json
import sys

import numpy as np

CHARTS = {"std": "standard", "li": "left-se3", "ri": "right-se3", "se2": "right-sen3"}
# Theirs: position, velocity, accelerometer bias, rotation, gyroscope bias, (a frame), landmarks.
ORDER = [9, 10, 11, 0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 13, 14, 21, 22, 23, 24, 25, 26]


def numbers(name, values):
    text = ", ".join(np.format_float_positional(v, unique=True, trim="-", precision=17)
                     for v in np.asarray(values, float).ravel())
    return f"     .{name} = {{{text}}},"


def state(name, s, body_velocity):
    """In the chart left-se3 theirs has the velocity in the body's axes."""
    if body_velocity:
        s = {**s, "v": np.array(s["C"]) @ s["v"]}
    return numbers(name, np.concatenate([np.ravel(s[k]) for k in ("C", "p", "v", "ba", "bg", "Y")]))


def case(c):
    def square(name):
        return np.array(c[name])[np.ix_(ORDER, ORDER)]

    body = c["param"] == "li"
    camera, stereo = c["cam"], c["init_stereo"]
    focal = [camera["fx"], camera["fy"], camera["cx"], camera["cy"], stereo["b"]]
    H = [np.hstack([h["psi"], h["r"], h["Y"]]) for h in c["H"]]
    change, transition = square("M"), square("Phi")
    lines = [
        f'    {{.chart = "{CHARTS[c["param"]]}",',
        state("state", c["state"], body),
        state("next", c["state_next"], body),
        numbers("sample", np.concatenate([c["am"], c["wm"], np.array(c["state"]["Cn"]).T @ c["g"]])),
        numbers("tau", c["tau"])[:-1].replace("{", "").replace("}", "") + ",",
        numbers("error", np.array(c["err"])[ORDER]),
        state("retracted", c["retracted"], body),
        numbers("change", change[:9, :9]),
        numbers("change_landmarks", change[15:, :3]),
        numbers("transition", transition[:15, :15]),
        numbers("transition_landmarks", transition[15:, :15]),
        numbers("camera", np.concatenate([focal, np.ravel(camera["Cbc"]), camera["pbc"]])),
        numbers("pixels", c["z"]),
        numbers("d_pixels", H),
        numbers("seen", stereo["z"]),
        numbers("initialised", stereo["Y"]),
        numbers("d_initialised", np.array(stereo["J"])[:, ORDER[:6]]),
        numbers("initialised_noise", stereo["R"]),
    ]
    return "\n".join(lines) + "}"


def main():
    with open(sys.argv[1], encoding="utf-8") as file:
        cases = json.load(file)
    chosen = {c["param"]: c for c in reversed(cases) if c["gmode"] == "n" and c["param"] in CHARTS}
    print(HEAD)
    print(",\n".join(case(chosen[name]) for name in CHARTS) + "};")
    print("\n// clang-format on\n}  // namespace chasles::test")


HEAD = """#pragma once

#include <array>
#include <string_view>

// Made by oracle_numbers.py, which says how; read by oracle_test.cpp alone. Matrices row by row.

namespace chasles::test {

struct OracleCase {
  std::string_view chart;
  std::array<double, 27> state, next;  ///< R, p, v, biases of f and w, two landmarks
  std::array<double, 9> sample;        ///< f, w, gravity in the world's axes
  double tau;
  std::array<double, 21> error;        ///< rotation, position, velocity, biases, landmarks
  std::array<double, 27> retracted;
  std::array<double, 81> change;  ///< the chart's coordinates by the standard ones
  std::array<double, 18> change_landmarks;  ///< their rows under the rotation
  std::array<double, 225> transition;       ///< from state to next, in the chart
  std::array<double, 90> transition_landmarks;  ///< the landmarks' rows, by the core
  std::array<double, 17> camera;    ///< fx, fy, cx, cy, baseline, imu_T_cam0 as R and p
  std::array<double, 4> pixels;     ///< (u, v) of the two landmarks
  std::array<double, 36> d_pixels;  ///< by rotation, position, landmark: 2 x 9 each
  std::array<double, 3> seen, initialised;   ///< (uL, v, uR), and the landmark that it begins
  std::array<double, 18> d_initialised;      ///< by rotation, position
  std::array<double, 9> initialised_noise;   ///< for 1 px on each of uL, v, uR
};

// clang-format off
inline constexpr OracleCase kOracleCases[] = {"""

main()
