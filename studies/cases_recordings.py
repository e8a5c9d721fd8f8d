"""Recordings with a fault, from the generators of ../shared/cases and from here: a part of studies/cases.py. It makes
every case from a rendered walk and from EuRoC's MH_01, runs `chasles run` and `chasles check` on them, compares
their outcome with what is right, and fills studies/cases.md."""

import concurrent.futures
import dataclasses
import functools
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import typing

from studies.cases_run import (CHASLES, DATA, OUT, ROOT, SHARED, call, check, lines, loaded, message, not_right, run, run_cells,
                       without_paths, words_of)
from studies.pages import fill

PAGE = ROOT / "studies/cases.md"
WALK = ["simulate", "walk", "--images", "--set", "walk_duration=12", "--set", "cameras=2", "--quiet", "-o"]
SOURCES = {"walk": "the rendered walk", "MH_01": "MH_01_easy_17s"}
MONO, BOTH = (["--cameras", "mono"],), ([], ["--cameras", "mono"])
BAG_START, DAY = 1_600_000_000_000_000_000, 86_400_000_000_000  # ns

sys.dont_write_bytecode = True
sys.path.insert(0, str(SHARED))
import make  # noqa: E402
import make_bag  # noqa: E402

make_bag.pixels = functools.lru_cache(240)(make_bag.pixels)  # decoding takes most of the time


# --- inputs ------------------------------------------------------------------------------------------------

def folder(case, source, to):
    make.clone(source, to)
    make.CASES[case](str(to))


def bag(case, source, to):
    make_bag.main(case.removeprefix("bag/"), str(source), str(to))
    return to / "r.bag"


def bag_folder(_, source, to):
    make_bag.main("plain", str(source), str(to))


def kitti(_, source, to):
    subprocess.run([sys.executable, "-B", SHARED / "make_kitti.py", source, to], check=True)
    return to / "2011_09_26/2011_09_26_drive_0001_sync"


def changed(change):
    """The intact recording after change(its folder)."""
    def made(_, source, to):
        make.clone(source, to)
        change(str(to))
    return made


def samples(change):
    """change([numbers of a sample], its index) -> numbers, of all IMU samples."""
    def row(r, i):
        return r[:1] + [repr(v) for v in change([float(v) for v in r[1:]], i)]
    return changed(lambda to: make.rows(f"{to}/mav0/imu0/data.csv", row))


def mirrored(axis):
    return samples(lambda v, i: [-x if k == 3 + axis else x for k, x in enumerate(v)])


def half_rate(to):
    make.rows(f"{to}/mav0/cam0/data.csv", lambda r, i: None if i % 2 else r)
    for path in sorted(make.images(to), key=lambda path: int(pathlib.Path(path).stem))[1::2]:
        os.unlink(path)


def middle(source):
    stamps = [int(line.split(",")[0]) for line in make.read(f"{source}/mav0/cam0/data.csv").splitlines()[1:]]
    return stamps[len(stamps) // 2]


def after_pause(source, stamp):
    return stamp + (DAY if stamp >= middle(source) else 0)


def pause(_, source, to):
    make.clone(source, to)
    half = middle(source)
    for table in make.all_tables(str(to)):
        make.rows(table, lambda r, i: [int(r[0]) + (DAY if int(r[0]) >= half else 0)] + r[1:])


def same_time(_, stamp):
    return stamp


# --- cases -------------------------------------------------------------------------------------------------

@dataclasses.dataclass
class Case:
    """A case is right if `run` says `says` where that is given, `check` says `finds` (with a "!" before it: does
    not), and `run` ends as `end` says. near: without an error, near the intact recording; error: it ends with an
    error that says `says`; near or reported: either, reported meaning that a message says `says`; any."""
    name: str
    right: str
    end: str = "near"
    says: str = ""
    finds: str = ""
    make: typing.Callable = folder
    variants: tuple = ([],)  # arguments of `run`
    like: str = ""  # the intact run to compare with, where it is not that with the same arguments
    output: str = ""  # folder for the run, below the recording
    stamp: typing.Callable = same_time  # (source, ns) -> time of the same moment in the case


NAMES_IT = "expected seconds|nanosecond|comma|EuRoC|byte order"  # a message about a file of the truth
ERROR_NEAR = "error near that of the intact recording"
SPANS = r"samples from .+ frames from"


def bag_case(name, right, *args, **more):
    return Case(f"bag/{name}", right, *args, **{"make": bag, "like": "short mono", "stamp": lambda _, t: t + BAG_START, **more})


# Only to compare with. `--stop` and `--start` get their seconds in `one`.
INTACT = [
    Case("intact", "-", "any", make=changed(lambda to: None), variants=BOTH),
    Case("intact, 60 images", "-", "any", make=changed(lambda to: None), variants=(["--stop"], ["--cameras", "mono", "--stop"])),
    Case("intact without its first image", "-", "any", make=changed(lambda to: None), variants=(["--start"], ["--cameras", "mono", "--start"])),
]
CASES = [
    *INTACT,
    Case("every_second_image_torn", ERROR_NEAR, finds="cannot be read", variants=BOTH),
    Case("every_third_image_torn", ERROR_NEAR, finds="cannot be read", make=changed(lambda to: make.torn(to, 3)), variants=BOTH),
    Case("every_fifth_image_torn", ERROR_NEAR, finds="cannot be read", variants=BOTH),
    Case("every_seventh_image_torn", ERROR_NEAR, finds="cannot be read", make=changed(lambda to: make.torn(to, 7)), variants=BOTH),
    Case("every_second_image_black", ERROR_NEAR, variants=BOTH),
    Case("first_camera_at_half_rate", ERROR_NEAR, "near or reported", "first camera", make=changed(half_rate), variants=BOTH),
    Case("cameras_5ms_apart", "as good as the first camera alone, or a message", "near or reported", "apart|first camera", variants=BOTH, like="mono"),
    Case("times_in_microseconds", "an error that asks for the unit", "error", "microsecond", "microsecond"),
    Case("imu_times_in_microseconds", "an error with both spans of time", "error", SPANS, SPANS),
    Case("imu_clock_since_boot", "an error with both spans of time", "error", SPANS, SPANS),
    Case("imu_times_float32", "an error that names the cause", "error", f"{SPANS}|32-bit", f"{SPANS}|32-bit"),
    Case("one_gyroscope_spike", "bridged, counted, found by `check`", "near", "spike", "spike"),
    Case("accelerometer_spike_300", "bridged, counted, found by `check`", "near", "spike", "spike",
         make=samples(lambda v, i: v[:3] + [300.0, *v[4:]] if i == 1200 else v)),
    Case("every_tenth_sample_zero", "bridged, found by `check`", "near", "zero", "zero"),
    Case("one_sample_nan", "left out and counted", "near", "finite|not a number|NaN"),
    Case("accelerometer_sign", "`check` finds it", "any", "", "sign of the accelerometer|wrong sign"),
    *(Case(f"accelerometer_mirrored_{name}", "`check` finds it", "any", "", f"(?i)mirror|(sign|axis).*accelerometer|accelerometer.*(sign|axis)",
           make=mirrored(axis)) for axis, name in enumerate("xyz")),
    Case("gyroscope_in_degrees", "an error; `check` names the unit", "error", "", "in deg/s",
         make=samples(lambda v, i: [x * 57.29577951308232 for x in v[:3]] + v[3:])),
    Case("accelerations_in_g", "an error; `check` names the unit", "error", "", "be g:",
         make=samples(lambda v, i: v[:3] + [x / 9.80665 for x in v[3:]])),
    Case("pause_of_a_day", "one restart, reported; found by `check`", "any", "restarted (1 times|once)|pause", "nothing for|pause",
         make=pause, stamp=after_pause),
    Case("kalibr_plain", "read; no remark about the order of the images", finds="!order"),
    Case("kalibr_timeshift_30ms", "applied", stamp=lambda _, t: t - 30_000_000),
    Case("kalibr_new_names", "read"),
    Case("kalibr_imu_in_and_out", "read"),
    Case("kalibr_scale_misalignment", "applied, rejected, or reported", "any", "intrinsics"),
    Case("kalibr_image_size", "an error at once", "error", r"376|752|size"),
    Case("kalibr_five_coefficients", "read"),
    Case("kalibr_extracted", "read, or a message what to rename", "near or reported", "imu0.csv|rename"),
    Case("macos_files", "left out", like="mono"),
    Case("times_with_folder", "read, or a message what is missing", "near or reported", "times.csv", like="mono"),
    Case("tum_vi_layout", "read"),
    Case("right_images_left_out", "the first camera alone", variants=MONO),
    Case("byte_order_mark", "read"),
    Case("no_last_line_end", "read"),
    bag_case("plain", "read"),
    bag_case("plain_as_a_folder", "read", make=bag_folder),
    bag_case("header_stamps_unset", "an error that names the cause", "error", "stamp"),
    bag_case("mono16", "read, or reported", "near or reported", "mono16"),
    bag_case("bgra8", "read, or reported", "near or reported", "bgra8"),
    bag_case("bayer", "read, or reported", "near or reported", "bayer"),
    bag_case("first_imu_sample_nan", "left out and counted", "near", "finite|not a number|NaN"),
    bag_case("imu_clock_since_boot", "an error that names the cause", "error", SPANS),
    bag_case("compressed_right_left", "cam0 is the right one", finds="!off the (epipolar|other)", like="short"),
    Case("kitti_frame_lost", "59 frames; image 6 keeps its time", "any", finds="59 images, longest interval 200 ms", make=kitti),
    Case("output_into_the_recording", "rejected", "error", "recording", make=changed(lambda to: None), output="."),
    Case("output_into_mav0", "rejected", "error", "recording", make=changed(lambda to: None), output="mav0"),
]


def intact_of(case, variant, results):
    """The run of the intact recording to compare with."""
    words = case.like or " ".join(variant).replace("--cameras ", "")
    short, mono = "short" in words, "mono" in words
    return results.get(("intact, 60 images" if short else "intact", "mono" if mono else "stereo"))


# --- all of them -------------------------------------------------------------------------------------------

def truth_of(case, source, to):
    """The truth of the intact recording at the times of the case, as TUM."""
    with open(to, "w", encoding="utf-8") as file:
        for line in make.read(f"{source}/mav0/state_groundtruth_estimate0/data.csv").splitlines()[1:]:
            stamp, *v = line.split(",")[:8]
            ns = case.stamp(source, int(stamp))
            file.write(f"{'-' if ns < 0 else ''}{abs(ns) // 10**9}.{abs(ns) % 10**9:09d} {' '.join(v[:3] + v[4:7] + v[3:4])}\n")
    return to


def behind_image(source, count):
    """Seconds from the recording's start to just behind this image."""
    first = min(int(make.read(f"{source}/mav0/{sensor}/data.csv").splitlines()[1].split(",")[0]) for sensor in ("imu0", "cam0"))
    stamps = sorted(int(pathlib.Path(path).stem) for path in make.images(str(source)))
    return (stamps[count - 1] + 25_000_000 - first) / 1e9


def one(name, case, programs, limit, work):
    """The outcomes of a case by each program: {"before": [runs, check], "after": …}."""
    source, work = work / "sources" / name, work / f"{name}-{CASES.index(case)}"
    work.mkdir()
    outcomes, made = {}, None
    for which, program in programs.items():
        if case.output or not made:
            made = case.make(case.name, source, work / "DST") or work / "DST"
        truth = truth_of(case, source, work / "truth.tum")
        seconds = {"--stop": [f"{behind_image(source, 60):.3f}"], "--start": [f"{behind_image(source, 1):.3f}"]}
        variants = [variant + seconds.get((variant or [""])[-1], []) for variant in case.variants]
        to, watched = (lambda i: made / case.output if case.output else work / f"{which}-{i}"), made if case.output else None
        runs = [run(program, made, variant, truth, to(i), limit, watched) for i, variant in enumerate(variants)]
        outcomes[which] = {"runs": runs, "check": check(program, made, limit) if case not in INTACT[1:] else None}
    shutil.rmtree(work, ignore_errors=True)
    print(f"{name}/{case.name}", flush=True)
    return outcomes


def tried(name, case, *rest):
    try:
        return one(name, case, *rest)
    except Exception as error:  # the other cases go on
        print(f"{name}/{case.name}: {type(error).__name__}: {error}", file=sys.stderr, flush=True)
        return None


def truths(programs, limit, work):
    """{file or words: {program: (exit code, words, wrong)}} of `chasles evaluate`."""
    found = {}
    for file in sorted((SHARED / "truth").iterdir()):
        found[file.name] = {}
        for which, program in programs.items():
            code, out, err, _ = call(program, ["evaluate", SHARED / "truth/plain.tum", file, "--json"], limit)
            ate, (errors, remarks) = loaded(out).get("ate_m"), lines(without_paths(err, SHARED / "truth/x", SHARED / "truth/y"))
            words = f"ATE {1000 * ate:.1f} mm" if ate is not None else (errors + remarks + [""])[0]
            right = ate is not None and ate < 1e-3 if code == 0 else re.search(NAMES_IT, words.replace(file.name, ""))
            found[file.name][which] = code, words, "" if right else "wrong figures" if code == 0 else "the message misleads"
    run_folder, truth = work / "run", truth_of(CASES[0], work / "sources/walk", work / "truth.tum")
    call(CHASLES, ["run", work / "sources/walk", "-o", run_folder, "--quiet"], limit)
    found["arguments the other way round"] = {}
    for which, program in programs.items():
        code, out, err, _ = call(program, ["evaluate", truth, run_folder, "--json"], limit)
        ate = loaded(out).get("ate_m")
        words = (lines(without_paths(err, truth, run_folder))[0] + ([f"ATE {1000 * ate:.1f} mm"] if ate is not None else [""]))[0]
        found["arguments the other way round"][which] = code, words, "" if code in (1, 2) else "not rejected"
    return found


# --- the page ----------------------------------------------------------------------------------------------

def table_of(name, results, order):
    heading = ["case", "what is right"]
    for which in order:
        heading += [f"{which}: `run`", "ATE mm", "frames", "`check`", "right?"]
    rows = [heading, ["---"] * len(heading)]
    for case in CASES:
        found = results.get((name, case.name))
        for i in range(len(case.variants) if found else 0):
            mono = ", mono" if "mono" in case.variants[i] else ""
            row = [(case.name if case in INTACT else f"`{case.name}`") + mono, case.right]
            for which in order:
                outcome, checked = found[which]["runs"][i], found[which]["check"] if i == 0 else None
                row += run_cells(case, outcome)
                row.append(message(checked["exit"], words_of(checked, case.finds)) if checked else "")
                row.append("-" if case in INTACT else found[which]["wrong"][i] or "yes")
            rows.append(row)
    return "\n".join(f"| {' | '.join(row)} |" for row in rows)


def truth_table(found, order):
    rows = [["truth", *(cell for which in order for cell in (which, "right?"))]]
    rows.append(["---"] * len(rows[0]))
    for file, outcomes in found.items():
        cells = [cell for which in order for cell in (message(*outcomes[which][:2]), outcomes[which][2] or "yes")]
        rows.append([f"`{file}`" if "." in file else file, *cells])
    return "\n".join(f"| {' | '.join(row)} |" for row in rows)


def assess(name, results, order):
    """Adds to each case what is not right, one entry a run."""
    for which in order:
        intact = {(case.name, "mono" if "mono" in variant else "stereo"): found[which]["runs"][i]
                  for case in INTACT[:2] if (found := results.get((name, case.name))) for i, variant in enumerate(case.variants)}
        for case in CASES:
            if found := results.get((name, case.name)):
                checks = [found[which]["check"]] + [None] * len(case.variants)  # the first variant's row has it
                found[which]["wrong"] = ["" if case in INTACT else not_right(case, outcome, checked, intact_of(case, variant, intact))
                                         for outcome, checked, variant in zip(found[which]["runs"], checks, case.variants)]


def sources(work, names):
    """The intact recordings of these names, as copies: cases link their images, and nothing may write into the originals."""
    for name in names:
        to = work / "sources" / name
        if name == "walk":
            subprocess.run([CHASLES, *WALK, to], check=True, stdout=subprocess.DEVNULL)
        elif (DATA / "euroc/MH_01_easy_17s").is_dir():
            shutil.copytree(DATA / "euroc/MH_01_easy_17s", to)
    return [name for name in names if (work / "sources" / name).is_dir()]


def wanted_of(names):
    """[(name of the recording, case)] with one of these names in them, and the intact recordings to compare with."""
    wanted = [(name, case) for name in SOURCES for case in CASES if not names or any(word in f"{name}/{case.name}" for word in names)]
    needed = {name for name, _ in wanted}
    return [(name, case) for name in SOURCES if name in needed for case in CASES if case in INTACT or (name, case) in wanted]


def main(options, programs, work):
    """Runs the cases in the folder `work`, and fills the page or, with names, prints the tables."""
    wanted = wanted_of(options.names)
    there = sources(work, dict.fromkeys(name for name, _ in wanted))
    wanted = [(name, case) for name, case in wanted if name in there]
    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        outcomes = list(pool.map(lambda job: tried(*job, programs, options.limit, work), wanted))
    results = {(name, case.name): found for (name, case), found in zip(wanted, outcomes) if found}
    of_truth = {} if options.names else truths(programs, options.limit, work)
    return show(results, of_truth, list(programs), fill_page=not options.names)


def show(results, of_truth, order, fill_page):
    for name in SOURCES:
        assess(name, results, order)
    kept = {f"{name}/{case}": found for (name, case), found in results.items()}
    (OUT / "results.json").write_text(json.dumps({"cases": kept, "truth": of_truth}, indent=1, ensure_ascii=False))
    for name in SOURCES:
        if fill_page:
            fill(PAGE, name, table_of(name, results, order))
        elif any(key[0] == name for key in results):
            print(table_of(name, results, order))
    if fill_page:
        fill(PAGE, "truth", truth_table(of_truth, order))
    wrong = [f"{key} ({outcome['command']}): {wrong}" for key, found in kept.items()
             for outcome, wrong in zip(found["after"]["runs"], found["after"]["wrong"]) if wrong]
    return wrong + [f"evaluate, {file}: {outcomes['after'][2]}" for file, outcomes in of_truth.items() if outcomes["after"][2]]
