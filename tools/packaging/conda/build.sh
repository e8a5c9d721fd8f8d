#!/usr/bin/env bash
set -euo pipefail

# shellcheck disable=SC2086,SC2154 # conda-build sets them; CMAKE_ARGS is a list of words
cmake ${CMAKE_ARGS} -G Ninja -S . -B build \
  -DCMAKE_BUILD_TYPE=Release \
  -DCHASLES_SHARED=ON \
  -DCHASLES_TESTS=OFF \
  -DCHASLES_PYTHON=ON \
  -DPython_EXECUTABLE="${PYTHON}" \
  -DCHASLES_PYTHON_DIR="${SP_DIR}"
cmake --build build --parallel "${CPU_COUNT}"
cmake --install build
