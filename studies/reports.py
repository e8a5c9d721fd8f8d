"""Inputs re-made from public reports, by the generators of ../shared/cases/reports: a part of studies/cases.py. It
makes each input from 6 s of MH_01, runs `chasles run` and `chasles check` on it (`chasles evaluate` for a truth),
compares the outcome with the rules of reports_rules.py, and fills studies/reports.md. Outcomes are kept in a cache."""

import concurrent.futures
import functools
import hashlib
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile

from studies import reports_rules as rules
from studies.cases_run import DATA, OUT, ROOT, SHARED, call, check, lines, loaded, message, not_right, run, run_cells, without_paths, words_of
from studies.pages import fill

PAGE, GENERATORS = ROOT / "studies/reports.md", SHARED / "reports"
SOURCE = DATA / "euroc/MH_01_easy_17s"
START, SECONDS = 1403636584763555584, 6  # of the piece, as in reports_common.py
VENV = ROOT / "build/cases-venv"
PACKAGES = ("numpy==1.26.4", "opencv-python-headless==4.10.0.84", "zstandard==0.23.0", "lz4==4.3.3")


# --- making ------------------------------------------------------------------------------------------------

def python():
    """A Python that has what the generators import: that of build/cases-venv, which is made once."""
    marker = VENV / "installed"
    if not marker.is_file() or marker.read_text() != "\n".join(PACKAGES):
        subprocess.run(["/usr/bin/python3", "-m", "venv", "--clear", VENV], check=True)
        subprocess.run([VENV / "bin/pip", "install", "--quiet", "--disable-pip-version-check", *PACKAGES], check=True)
        marker.write_text("\n".join(PACKAGES))
    return VENV / "bin/python"


def generate(script, *arguments):
    environment = {**os.environ, "SRC": str(SOURCE), "SECONDS": str(SECONDS), "PYTHONHASHSEED": "0"}
    subprocess.run([python(), "-B", GENERATORS / script, *map(str, arguments)], check=True, env=environment,
                   stdout=subprocess.DEVNULL, timeout=300)


def make_input(group, rule, to):
    """The input of a rule below the folder `to`."""
    if group == "intact":
        code = f"import sys; sys.path.insert(0, {str(GENERATORS)!r}); import reports_common as c; c.euroc({str(to)!r})"
        subprocess.run([python(), "-B", "-c", code], check=True, env={**os.environ, "SRC": str(SOURCE), "SECONDS": str(SECONDS)})
    elif group == "files":
        generate("make_files.py", to)
    else:
        generate(rules.GROUPS[group][0], rule.name, to)
    return to / (rule.at or default_input(group, rule))


def default_input(group, rule):
    return {"files": rule.name, "intact": "", "folders": "", "sensors": ""}.get(group, "walk.mcap")


@functools.cache
def truth_rows():
    """[(ns, [x, y, z, qw, qx, qy, qz])] of MH_01."""
    rows = (SOURCE / "mav0/state_groundtruth_estimate0/data.csv").read_text().splitlines()[1:]
    return [(int(v[0]), v[1:8]) for v in (row.split(",") for row in rows)]


def truth_text(moved):
    """The truth at the times of an input, as TUM. Where two poses have one time, the earlier pose stays."""
    poses = {}
    for ns, v in truth_rows():
        poses.setdefault(moved(ns, START), v)
    return "".join(f"{ns // 10**9}.{ns % 10**9:09d} {' '.join(v[:3] + v[4:7] + v[3:4])}\n" for ns, v in sorted(poses.items()))


# --- the cache ---------------------------------------------------------------------------------------------

@functools.cache
def digest(path):
    """Of a program or a generator."""
    return hashlib.sha256(path.read_bytes()).hexdigest()


def key_of(*parts):
    return hashlib.sha256(json.dumps([str(part) for part in parts]).encode()).hexdigest()[:32]


def kept(cache, key):
    try:
        return json.loads((cache / f"{key}.json").read_text())
    except (OSError, json.JSONDecodeError):
        return None


def keep(cache, key, outcome):
    cache.mkdir(parents=True, exist_ok=True)
    with tempfile.NamedTemporaryFile("w", dir=cache, delete=False, encoding="utf-8") as file:
        json.dump(outcome, file, indent=1, ensure_ascii=False)
    os.replace(file.name, cache / f"{key}.json")  # another script may write the same


# --- running -----------------------------------------------------------------------------------------------

def one(group, rule, programs, options, work):
    """{program: {"run": outcome, "check": outcome}} of one input."""
    script = rules.GROUPS[group][0] if group in rules.GROUPS else "reports_common.py"
    truth = truth_text(rule.moved)
    about = (digest(GENERATORS / script), digest(GENERATORS / "reports_common.py"), group, rule.name, rule.at, rule.arguments, SECONDS, truth)
    keys = {which: key_of(digest(program), *about) for which, program in programs.items()}
    outcomes = {which: kept(options.cache, key) for which, key in keys.items()}
    missing = [which for which in programs if not outcomes[which]]
    if not missing:
        return outcomes
    folder = work / f"{group}-{rule.name}".replace(", ", "-")
    folder.mkdir()
    (folder / "truth.tum").write_text(truth)
    made = make_input(group, rule, folder / "DST")
    for which in missing:
        program = programs[which]
        outcomes[which] = {"run": run(program, made, rule.arguments, folder / "truth.tum", folder / which, options.limit, evaluator=program),
                           "check": check(program, made, options.limit) if group != "intact" else None}
        keep(options.cache, keys[which], outcomes[which])
    shutil.rmtree(folder, ignore_errors=True)
    print(f"reports/{group}/{rule.name}", flush=True)
    return outcomes


def tried(group, rule, *rest):
    try:
        return one(group, rule, *rest)
    except Exception as error:  # the other inputs go on
        print(f"reports/{group}/{rule.name}: {type(error).__name__}: {error}", file=sys.stderr, flush=True)
        return None


# --- truths ------------------------------------------------------------------------------------------------

def strings(value):
    """All texts in a JSON value, but not its keys."""
    if isinstance(value, str):
        return [value]
    values = value.values() if isinstance(value, dict) else value if isinstance(value, list) else ()
    return [text for item in values for text in strings(item)]


def evaluated(program, run_folder, truth, limit):
    code, out, err, seconds = call(program, ["evaluate", run_folder, truth, "--json"], limit)
    report, (errors, remarks) = loaded(out), lines(without_paths(err, truth, run_folder))
    reported = [line for line in strings(report) if " " in line]
    return {"exit": code, "seconds": seconds, "errors": errors, "remarks": remarks + [line for line in reported if line not in remarks],
            **{name: report.get(name) for name in ("matched", "ate_posyaw_m", "attitude_posyaw_deg", "nees_pose", "nees_position")}}


def truths(programs, options, work):
    """{file: {program: outcome}} of `chasles evaluate` with a run of the intact piece; "" is the plain truth."""
    files = ["", *(rule.name for rule in rules.TRUTHS)]
    about = [digest(GENERATORS / "make_truths.py"), digest(GENERATORS / "reports_common.py"), SECONDS]
    found, made = {file: {} for file in files}, work / "truths"
    for which, program in programs.items():
        key = key_of(digest(program), "truths", *files, *about)
        outcomes = kept(options.cache, key)
        if not outcomes:
            if not made.is_dir():
                generate("make_truths.py", made)
                (work / "plain.tum").write_text(truth_text(lambda ns, start: ns))
                make_input("intact", rules.INTACT[0], work / "truths-intact")
            run_folder = work / f"truths-{which}"
            call(program, ["run", work / "truths-intact", "-o", run_folder, "--quiet"], options.limit)
            outcomes = {file: evaluated(program, run_folder, made / file if file else work / "plain.tum", options.limit) for file in files}
            keep(options.cache, key, outcomes)
        for file in files:
            found[file][which] = outcomes[file]
    return found


def same_figures(rule, outcome, plain):
    """What is wrong with figures that should be those of the plain truth."""
    if outcome["exit"] != 0:
        return f"exit {outcome['exit']}"
    if outcome["ate_posyaw_m"] is None or outcome["ate_posyaw_m"] > 1.5 * plain["ate_posyaw_m"]:
        return "another error"
    if rule.attitude:
        return "" if (outcome["attitude_posyaw_deg"] or 0) < 2 * plain["attitude_posyaw_deg"] + 0.1 else "another attitude"
    return "" if outcome["attitude_posyaw_deg"] is None and outcome["nees_pose"] is None else "figures of an attitude that is not there"


def truth_wrong(rule, outcome, plain):
    """What is not right, or ""."""
    said = any(re.search(rule.says, line.replace(rule.name, "")) for line in outcome["errors"] + outcome["remarks"])
    if outcome["exit"] not in (0, 1, 2, 3):
        return f"exit {outcome['exit']}"
    if rule.end == "reported":
        return "" if said else "silently wrong" if outcome["exit"] == 0 else "the message misleads"
    wrong = same_figures(rule, outcome, plain)
    if rule.end == "same or reported":
        return "" if said else wrong
    return wrong or ("" if said or not rule.says else "not said")


# --- assessing and the page ----------------------------------------------------------------------------------

def wrong_of(rule, outcome, intact):
    found = not_right(rule, outcome["run"], outcome["check"], intact)
    if not found and not rule.healthy and outcome["run"]["health"] == "ok" and not outcome["run"]["errors"]:
        found = "`run` calls itself healthy"
    if not found and len(outcome["run"]["errors"] + outcome["run"]["remarks"]) > rule.lines:
        found = "too many lines"
    return found


def table_of(group, found, order):
    heading = ["case", "what is right"]
    for which in order:
        heading += [f"{which}: `run`", "ATE mm", "frames", "`check`", "right?"]
    rows = [heading, ["---"] * len(heading)]
    for rule in rules.INTACT if group == "intact" else rules.GROUPS[group][1]:
        outcomes = found.get((group, rule.name))
        if not outcomes:
            continue
        row = [f"`{rule.name}`" if group != "intact" else rule.name, rule.right]
        for which in order:
            outcome = outcomes[which]
            row += run_cells(rule, outcome["run"])
            row.append(message(outcome["check"]["exit"], words_of(outcome["check"], rule.finds)) if outcome["check"] else "")
            row.append(outcome["wrong"] or ("-" if group == "intact" else "yes"))
        rows.append(row)
    return "\n".join(f"| {' | '.join(row)} |" for row in rows)


def number(value, scale=1.0, digits=1):
    return "-" if value is None else f"{scale * value:.{digits}f}"


def truth_table(found, order):
    heading = ["truth", "what is right"]
    for which in order:
        heading += [f"{which}: `evaluate`", "ATE mm", "attitude deg", "NEES pose", "right?"]
    rows = [heading, ["---"] * len(heading)]
    for rule in [rules.TruthRule("", "-"), *rules.TRUTHS]:
        row = [f"`{rule.name}`" if rule.name else "intact", rule.right]
        for which in order:
            outcome = found[rule.name][which]
            row += [message(outcome["exit"], words_of(outcome, rule.says)), number(outcome["ate_posyaw_m"], 1000),
                    number(outcome["attitude_posyaw_deg"], digits=2), number(outcome["nees_pose"]),
                    "-" if not rule.name else outcome["wrong"] or "yes"]
        rows.append(row)
    return "\n".join(f"| {' | '.join(row)} |" for row in rows)


def summary(found, of_truth, order):
    """One row a group: how many are right."""
    rows = [["inputs", "cases", *(f"right {which}" for which in order)], ["---"] + ["---:"] * (1 + len(order))]
    counts = {group: [found[group, rule.name] for rule in listed if (group, rule.name) in found] for group, (_, listed) in rules.GROUPS.items()}
    counts["truths"] = [of_truth[rule.name] for rule in rules.TRUTHS] if of_truth else []
    counts["all"] = [case for cases in counts.values() for case in cases]
    for group, cases in counts.items():
        rows.append([group.replace("_", " "), str(len(cases)), *(str(sum(not case[which]["wrong"] for case in cases)) for which in order)])
    return "\n".join(f"| {' | '.join(row)} |" for row in rows)


def assess(found, of_truth, order):
    """Adds to each outcome what is not right."""
    every = {(group, rule.name): rule for group, (_, listed) in rules.GROUPS.items() for rule in listed}
    for which in order:
        intact = {name: outcomes[which]["run"] for (group, name), outcomes in found.items() if group == "intact"}
        for key, outcomes in found.items():
            outcomes[which]["wrong"] = wrong_of(every[key], outcomes[which], intact.get(every[key].like)) if key in every else ""
        for file, outcomes in of_truth.items():
            rule = next((rule for rule in rules.TRUTHS if rule.name == file), None)
            outcomes[which]["wrong"] = truth_wrong(rule, outcomes[which], of_truth[""][which]) if rule else ""


def wanted_of(names):
    every = [(group, rule) for group, (_, listed) in rules.GROUPS.items() for rule in listed]
    wanted = [(group, rule) for group, rule in every if not names or any(name in f"reports/{group}/{rule.name}" for name in names)]
    return [("intact", rule) for rule in rules.INTACT] + wanted if wanted else []


def main(options, programs, work):
    """Runs the inputs in the folder `work`, and fills the page or, with names, prints the tables."""
    wanted, order = wanted_of(options.names), list(programs)
    python()
    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        outcomes = list(pool.map(lambda job: tried(*job, programs, options, work), wanted))
    found = {(group, rule.name): outcome for (group, rule), outcome in zip(wanted, outcomes) if outcome}
    with_truths = not options.names or any(name in "reports/truths" for name in options.names)
    of_truth = truths(programs, options, work) if with_truths else {}
    assess(found, of_truth, order)
    results = {"cases": {"/".join(key): outcome for key, outcome in found.items()}, "truths": of_truth}
    (OUT / "reports.json").write_text(json.dumps(results, indent=1, ensure_ascii=False))
    tables = {group: table_of(group, found, order) for group in ("intact", *rules.GROUPS) if any(key[0] == group for key in found)}
    if of_truth:
        tables["truths"] = truth_table(of_truth, order)
    if not options.names:
        tables["summary"] = summary(found, of_truth, order)
    for name, table in tables.items():
        if options.names:
            print(table)
        else:
            fill(PAGE, name, table)
    wrong = [(f"reports/{'/'.join(key)}", outcome["after"]["wrong"]) for key, outcome in found.items()]
    wrong += [(f"reports/truths/{file}", outcome["after"]["wrong"]) for file, outcome in of_truth.items()]
    return [f"{name}: {what}" for name, what in wrong if what]
