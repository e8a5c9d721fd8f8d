# A thin front: everything is done by CMake's presets and by tools/.
JOBS ?= $(shell nproc)
export CMAKE_BUILD_PARALLEL_LEVEL ?= $(JOBS)
export CTEST_PARALLEL_LEVEL ?= $(JOBS)

.PHONY: help deps dev-deps build demo test check wheel python package ros1 dds bench table pictures study convergence recordings-consistency docs \
  prose format lint coverage asan fuzz clean
.DEFAULT_GOAL := help

help:     ## this list
	@sed -n 's/^\([a-z0-9-]*\):[^#]*## /  make \1\t/p' Makefile | expand -t 18

deps:     ## installs the Debian or Ubuntu packages that are missing, and src/web/node_modules
	@tools/deps build test

dev-deps: ## the same, and what format, lint, coverage, fuzz and table need
	@tools/deps build test dev

build: deps  ## build/release/bin/chasles, the program alone
	cmake --preset release
	cmake --build --preset program

demo: deps  ## a rendered walk, SLAM from its pixels, a page: out/demo/page.html
	@tools/deps demo
	cmake --preset demo
	cmake --build --preset demo
	@tools/demo

test: deps  ## builds everything; all tests, on the real recordings too where they are at hand
	cmake --workflow --preset release

check:    ## the formatting, the prose, and the quick tests of what is built; before a commit
	@tools/format --check
	@tools/prose
	cmake --build --preset release
	ctest --preset release --label-regex '^quick$$'

wheel: build  ## the Python package, from the objects of `make build`: out/chasles-*.whl for pip install
	@tools/deps wheel
	@tools/wheel

python: wheel  ## the same, and its tests; build/release/python for PYTHONPATH
	@tools/deps python
	ctest --preset release --tests-regex '^Python$$'

package:  ## Debian packages, source tarball, files for conda and vcpkg: out/packages
	@tools/deps build package
	@tools/package

ros1:     ## the node of ROS 1 and its tests (Debian): build/release/ros/ros1/share for ROS_PACKAGE_PATH
	@tools/deps build test ros1
	cmake --preset release -DCHASLES_ROS1=ON
	cmake --build --preset program --target chasles chasles_ros chasles_ros1_test chasles_ros1_messages_test
	ctest --preset release --tests-regex '^Ros1'

dds:      ## the bridge to ROS 2 over DDS and its tests: build/release/bin/chasles_dds
	@tools/deps build test dds
	@tools/ros2-venv
	cmake --preset release -DCHASLES_DDS=ON
	cmake --build --preset program --target chasles chasles_dds dds_player dds_wire dds_test
	ctest --preset release --tests-regex '^(Dds|Ros2)'

bench:    ## ratios of cost, measured in one run; AGAINST=PROGRAM: to another build, by whole runs
ifdef AGAINST
	@tools/deps build
	cmake --preset release
	cmake --build --preset program
	@python3 -m studies.against $(AGAINST)
else
	@tools/deps build test bench
	cmake --preset release -DCHASLES_BENCH=ON
	cmake --build --preset release
	@for bench in build/release/bin/*_bench; do $$bench || exit 1; done
endif

table: build  ## runs all real recordings: fills README.md, docs/results.md, studies/{results,peers}.md
	@python3 -m studies.table $(ARGS)

pictures: build  ## renders two walks: docs/images/run-page.png and loop.png, and their figures in README.md
	@python3 -m studies.pictures

study: build  ## 100 simulated runs of each inertial scene: fills studies/consistency.md
	@python3 -m studies.study

convergence: build  ## the error charts in batch estimation: fills studies/convergence.md
	@python3 -m studies.convergence

recordings-consistency: build  ## errors against sigmas on all recordings: out/recordings-consistency/table.md
	@tools/studies-venv
	@python3 -m studies.recordings_consistency $(ARGS)

docs:     ## the documentation site: out/docs/index.html
	@tools/deps docs
	@tools/docs

prose:    ## checks the prose of all pages: sentences, lines, the passive, the glossary's words
	@tools/deps prose
	@tools/prose

format:   ## clang-format over all sources
	@tools/format

lint:     ## clang-tidy over all sources, or over FILES="..."; mypy over studies/
	@tools/lint $(FILES)

coverage: deps  ## which lines the tests reach: build/coverage/coverage.html
	cmake --workflow --preset coverage
	gcovr --root . --filter src/ --exclude '.*_test\.cpp' --exclude '.*testing\.hpp' \
	  --exclude-throw-branches --gcov-ignore-parse-errors --html-details build/coverage/coverage.html \
	  --print-summary build/coverage > build/coverage/coverage.txt
	@tail -n 3 build/coverage/coverage.txt

asan: deps  ## all tests under the address and undefined-behaviour sanitizers
	cmake --workflow --preset asan

fuzz:     ## libFuzzer on each reader for SECONDS_EACH (60)
	cmake --preset fuzz
	cmake --build --preset fuzz
	@tools/fuzz

clean:    ## removes build/ and out/
	rm -rf build out
