#!/usr/bin/env python3
"""Writes inertial_oracle_numbers_testing.hpp: what inertial_oracle_test.cpp needs of the fixtures of an
independent numpy implementation (one case a chart), in the order of this project's errors:

    /usr/bin/python3 src/chasles/filter/inertial_oracle_numbers.py ../shared/oracle/fixtures.json \\
        > src/chasles/filter/inertial_oracle_numbers_testing.hpp
"""

import json
import sys

import numpy as np

CHARTS = {"std": "standard", "li": "left-se3", "ri": "right-se3", "se2": "right-sen3"}
# Theirs: position, velocity, accelerometer bias, rotation, gyroscope bias, position and rotation of
# the world in nav, landmarks. Ours: rotation first, nav before the biases.
ORDER = [9, 10, 11, 0, 1, 2, 3, 4, 5, 18, 19, 20, 15, 16, 17, 6, 7, 8, 12, 13, 14, 21, 22, 23, 24, 25, 26]


def numbers(name, values):
    text = ", ".join(np.format_float_positional(v, unique=True, trim="-", precision=17)
                     for v in np.asarray(values, float).ravel())
    return f"     .{name} = {{{text}}},"


def state(name, s, body_velocity):
    """In the chart left-se3 theirs has the velocity in the body's axes."""
    if body_velocity:
        s = {**s, "v": np.array(s["C"]) @ s["v"]}
    return numbers(name, np.concatenate(
        [np.ravel(s[k]) for k in ("C", "p", "v", "Cn", "pn", "ba", "bg", "Y")]))


def case(c):
    def square(name):
        return np.array(c[name])[np.ix_(ORDER, ORDER)]

    body = c["param"] == "li"
    camera, mono, aid = c["cam"], c["init_mono"], c["aid"]
    H = [np.hstack([h["psi"], h["r"], h["Y"]]) for h in c["H"]]
    G = np.array(c["G"])[ORDER]
    lines = [
        f'    {{.chart = "{CHARTS[c["param"]]}",',
        state("state", c["state"], body),
        numbers("sample", np.concatenate([c["am"], c["wm"], c["g"]])),
        numbers("error", np.array(c["err"])[ORDER]),
        state("retracted", c["retracted"], body),
        numbers("F", square("F")),
        numbers("G", G[:, :6]),
        state("composed", c["composed"], body),
        numbers("J_compose", square("J_compose")),
        numbers("camera", np.concatenate([[camera[k] for k in ("fx", "fy", "cx", "cy")],
                                          np.ravel(camera["Cbc"]), camera["pbc"]])),
        numbers("pixels", c["z"]),
        numbers("d_pixels", H),
        numbers("mono", np.concatenate([mono["uv"], [mono[k] for k in ("depth", "sig_px", "sig_d")]])),
        numbers("initialised", mono["Y"]),
        numbers("d_initialised", np.array(mono["J"])[:, ORDER[:6]]),
        numbers("initialised_noise", mono["R"]),
        numbers("anchor", np.concatenate([np.ravel(aid["Ca"]), aid["pa"]])),
        numbers("inverse_depth", aid["a"]),
        numbers("anchored_pixel", aid["z"]),
        numbers("d_anchored_pixel", np.hstack([aid[k] for k in ("Hpsi", "Hr", "Hpsia", "Hra", "Ha")])),
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

// Made by inertial_oracle_numbers.py, which says how; read by inertial_oracle_test.cpp alone.
// Matrices row by row.

namespace chasles::test {

struct InertialOracleCase {
  std::string_view chart;
  std::array<double, 39> state;  ///< pose R, p; v; nav_T_world R, p; biases of f and w; two landmarks
  std::array<double, 9> sample;  ///< f, w, gravity in nav
  std::array<double, 27> error;  ///< as State says: core with nav_T_world, landmarks
  std::array<double, 39> retracted;
  std::array<double, 729> F;  ///< continuous, in the chart
  std::array<double, 162> G;  ///< by white noise of f and w
  std::array<double, 39> composed;
  std::array<double, 729> J_compose;  ///< in the chart
  std::array<double, 16> camera;      ///< fx, fy, cx, cy, imu_T_cam as R and p
  std::array<double, 4> pixels;       ///< (u, v) of the two landmarks
  std::array<double, 36> d_pixels;    ///< by rotation, position, landmark: 2 x 9 each
  std::array<double, 5> mono;         ///< (u, v), depth, sigmas of pixel and depth
  std::array<double, 3> initialised;        ///< the landmark that they begin
  std::array<double, 18> d_initialised;     ///< by rotation, position
  std::array<double, 9> initialised_noise;
  std::array<double, 12> anchor;           ///< a clone, R and p
  std::array<double, 3> inverse_depth;     ///< of a landmark anchored on it
  std::array<double, 2> anchored_pixel;
  std::array<double, 30> d_anchored_pixel;  ///< by pose, clone (rotation, position), inverse depth
};

// clang-format off
inline constexpr InertialOracleCase kInertialOracleCases[] = {"""

main()
