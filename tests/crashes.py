#!/usr/bin/env python3
"""tests/crashes.py [POINTS [SEED]]: ends runs at random points and looks at their run folders. POINTS
(default 1000) are divided between kill -9, a full disk and a power cut, with and without an earlier run
in the folder. Afterwards the folder must be the earlier run, the new run, or have neither; a `growing/`
in it must be readable. $CHASLES is the program, $CHASLES_FAULTS the library of tests/fault_shim.cpp
(default: those of the build in build/release).

The power cut is simulated from the log of a run's file operations. Names follow a journal: after a cut
there is a prefix of the changes that has at least those before the last fsync of their folder. The
content of a file is what its last fsync covered, and of the rest nothing, a part, or zeros."""

import json
import os
import random
import shutil
import struct
import subprocess
import sys
import tempfile
import zlib

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
CHASLES = os.environ.get("CHASLES", os.path.join(ROOT, "build/release/bin/chasles"))
SHIM = os.environ.get("CHASLES_FAULTS", os.path.join(ROOT, "build/release/tests/libfault_shim.so"))
TIMINGS = ("timing.csv", "timing.json")


def chasles(*words, **more):
    environment = {**os.environ, **{name: str(value) for name, value in more.items()}}
    return subprocess.run([CHASLES, *words], env=environment, capture_output=True, text=True)


def contents(folder):
    """The files of a folder without its subfolders for work in progress."""
    found = {}
    for where, folders, files in os.walk(folder):
        folders[:] = [name for name in folders if name not in ("growing", ".writing", ".written")]
        for name in files:
            if name == ".chasles-probe":  # whether the folder can be written
                continue
            path = os.path.join(where, name)
            with open(path, "rb") as file:
                found[os.path.relpath(path, folder)] = file.read()
    return found


def without_timing(files):
    return {name: data for name, data in files.items() if name not in TIMINGS}


class Disk:
    """What a folder's file operations leave after a power cut."""

    def __init__(self, before):
        self.files = {}  # name: number of the file
        self.now, self.kept = [], []  # content of each file: present, and on the disk
        self.names = []  # changes of names: (operation, arguments)
        self.certain = 0  # so many of them are on the disk
        for name, data in before.items():
            self.files[name] = self.create(data, data)
        self.first = dict(self.files)

    def create(self, data=b"", kept=b""):
        self.now.append(data)
        self.kept.append(kept)
        return len(self.now) - 1

    def apply(self, kind, name, more):
        if kind in "ca" and (kind == "c" or name not in self.files):
            # A truncated file counts as a new one: its old content may be lost.
            self.change("link", name, self.create())
        elif kind == "w":
            self.now[self.files[name]] += more
        elif kind == "s" and name in self.files:
            self.kept[self.files[name]] = self.now[self.files[name]]
        elif kind == "s":
            self.certain = len(self.names)
        elif kind == "r":
            self.change("move", name, more.decode())
        elif kind == "u":
            self.change("unlink", name, None)

    def change(self, *step):
        self.names.append(step)
        self.play(self.files, step)

    @staticmethod
    def play(files, step):
        kind, name, to = step
        if kind == "link":
            files[name] = to
        elif kind == "unlink":
            files.pop(name, None)
        else:
            for old in [f for f in files if f == name or f.startswith(name + "/")]:
                files[to + old[len(name):]] = files.pop(old)

    def after_cut(self, draw):
        files = dict(self.first)
        for step in self.names[: draw.randint(self.certain, len(self.names))]:
            self.play(files, step)
        result = {}
        for name, number in files.items():
            rest = self.now[number][len(self.kept[number]):]
            part = rest[: draw.randint(0, len(rest))]
            result[name] = self.kept[number] + draw.choice((b"", part, rest, bytes(len(part))))
        return result


def operations(log, out):
    """(kind, path below the folder, second path or bytes) of each operation."""
    with open(log, "rb") as file:
        data = file.read()
    at = 0

    def text():
        nonlocal at
        (size,) = struct.unpack_from("<I", data, at)
        at += 4 + size
        return data[at - size : at]

    while at < len(data):
        kind = chr(data[at])
        at += 1
        name, more = text().decode(), text()
        if kind == "r":
            more = os.path.relpath(more.decode(), out).encode()
        yield kind, os.path.relpath(name, out), more


def write(files, folder):
    for name, data in files.items():
        path = os.path.join(folder, name)
        os.makedirs(os.path.dirname(path), exist_ok=True)
        with open(path, "wb") as file:
            file.write(data)


class Trials:
    def __init__(self, work, draw):
        self.work, self.draw = work, draw
        self.out = os.path.join(work, "out")
        self.recording = os.path.join(work, "recording")
        made = chasles("simulate", "street", "-o", self.recording, "--set", "route=LS",
                       "--set", "features_per_frame=20", "--quiet")
        assert made.returncode == 0, made.stderr
        self.old = self.reference("old", "--set", "gate=0.7")
        self.new = self.reference("new")
        self.outcomes = {}

    def run(self, *more, **environment):
        words = ("run", self.recording, "-o", self.out, "--quiet", "--stop", "8", *more)
        return chasles(*words, LD_PRELOAD=SHIM, FAULT_ROOT=self.out, FAULT_CLOCK=100, **environment)

    def reference(self, name, *settings):
        shutil.rmtree(self.out, ignore_errors=True)
        done = self.run(*settings)
        assert done.returncode == 0, done.stderr
        return contents(self.out)

    def start(self, earlier):
        shutil.rmtree(self.out, ignore_errors=True)
        os.makedirs(self.out)
        write({**(self.old if earlier else {}), "notes.txt": b"of the user"}, self.out)

    def log(self, earlier):
        """The operations of a run that nothing ends."""
        self.start(earlier)
        log = os.path.join(self.work, "log")
        if os.path.exists(log):
            os.remove(log)
        assert self.run(FAULT_LOG=log).returncode == 0
        return list(operations(log, self.out))

    def raw_state(self):
        """Before any reader: a summary.json is beside its own files alone."""
        files = contents(self.out)
        if "summary.json" not in files:
            return "none"
        for name, stated in json.loads(files["summary.json"])["files"].items():
            if name not in files:
                return f"a mix: {name} is missing"
            found = {"bytes": len(files[name]), "crc32": f"{zlib.crc32(files[name]):08x}"}
            if stated is not None and stated != found:
                return f"a mix: {name} is {found}, summary.json states {stated}"
        return "whole"

    def check(self, what, earlier):
        raw = self.raw_state()
        read = chasles("export", self.out, "-o", os.path.join(self.work, "map.ply"), "--quiet")
        files = contents(self.out)
        assert files.pop("notes.txt", None) == b"of the user", "the user's file has gone"
        state = "a mix"
        for name, run in (("old", self.old), ("new", self.new)):
            if read.returncode == 0 and without_timing(files) == without_timing(run):
                state = name
        if read.returncode == 2 and not earlier and "no run folder" in read.stderr and not files:
            state = "none"
        growing = os.path.join(self.out, "growing")
        if os.path.exists(os.path.join(growing, "summary.json")):
            viewed = chasles("export", growing, "-o", os.path.join(self.work, "map.ply"), "--quiet")
            state += " and growing" if viewed.returncode == 0 else f" and {viewed.stderr}"
        if "mix" in raw or state.split(" and ")[0] == "a mix" or state.endswith("\n"):
            sys.exit(f"{what}: {state}; before reading: {raw}; {read.stderr}{sorted(files)}")
        self.outcomes[state] = self.outcomes.get(state, 0) + 1

    def ended_run(self, variable, count, earlier):
        point = self.draw.randint(1, count)
        self.start(earlier)
        done = self.run(**{variable: point})
        what = f"{variable}={point} of {count}, earlier run: {earlier}"
        if done.returncode == 70:
            sys.exit(f"{what}: exit code 70: {done.stderr}")
        if done.returncode == 0 and self.raw_state() != "whole":
            sys.exit(f"{what}: exit code 0, and no run")
        self.check(what, earlier)

    def power_cut(self, log, earlier):
        point = self.draw.randint(0, len(log))
        disk = Disk({**(self.old if earlier else {}), "notes.txt": b"of the user"})
        for operation in log[:point]:
            disk.apply(*operation)
        shutil.rmtree(self.out, ignore_errors=True)
        os.makedirs(self.out)
        write(disk.after_cut(self.draw), self.out)
        self.check(f"power cut after {point} of {len(log)}, earlier run: {earlier}", earlier)


def main():
    points = int(sys.argv[1]) if len(sys.argv) > 1 else 1000
    seed = int(sys.argv[2]) if len(sys.argv) > 2 else 1
    with tempfile.TemporaryDirectory() as work:
        trials = Trials(os.path.realpath(work), random.Random(seed))
        logs = {earlier: trials.log(earlier) for earlier in (False, True)}
        for number in range(points):
            earlier = number % 2 == 1
            log = logs[earlier]
            kind = number // 2 % 3
            if kind == 0:
                trials.ended_run("FAULT_KILL", len(log), earlier)
            elif kind == 1:
                trials.ended_run("FAULT_FULL", len(log), earlier)
            else:
                trials.power_cut(log, earlier)
        print(f"{points} points, {len(logs[True])} operations a run: "
              + ", ".join(f"{count} {state}" for state, count in sorted(trials.outcomes.items())))


if __name__ == "__main__":
    main()
