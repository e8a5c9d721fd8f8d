"""Runs `chasles run` and `chasles check` on one input, and compares the outcome with what is right. For
python3 -m studies.cases and its parts."""

import json
import os
import pathlib
import re
import subprocess
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
CHASLES = pathlib.Path(os.environ.get("CHASLES_BINARY", ROOT / "build/release/bin/chasles")).resolve()
SHARED = pathlib.Path(os.environ.get("CHASLES_CASES", ROOT / "../shared/cases")).resolve()
DATA = pathlib.Path(os.environ.get("CHASLES_DATA", ROOT / "../shared/data")).resolve()
OUT = ROOT / "out/cases"
NEAR = 1.5  # times the error of the intact recording


# --- commands ----------------------------------------------------------------------------------------------

def call(program, arguments, limit):
    """(exit code or "limit", standard output, standard error, seconds)"""
    started = time.monotonic()
    try:
        done = subprocess.run([program, *map(str, arguments)], capture_output=True, text=True, errors="replace",
                              timeout=limit, stdin=subprocess.DEVNULL)
        code, out, err = done.returncode, done.stdout, done.stderr
    except subprocess.TimeoutExpired as late:
        code, out, err = "limit", *((text or b"").decode(errors="replace") for text in (late.stdout, late.stderr))
    return code, out, err, round(time.monotonic() - started, 1)


def loaded(text):
    try:
        return json.loads(text)
    except json.JSONDecodeError:
        return {}


def lines(text):
    """The messages of standard error without "chasles: "; errors come first, and the start of the log is left out."""
    found = [line.removeprefix("chasles: ") for line in text.splitlines() if not line.startswith("chasles: info:")]
    errors = [line.removeprefix("error: ") for line in found if line.startswith("error: ")]
    return errors, [re.sub("^(warning|remark): ", "", line) for line in found if not line.startswith("error: ")]


def without_paths(text, *paths):
    for path in paths:
        text = text.replace(f"{path}/", "").replace(str(path), path.name)
    return text


def listing(made):
    return sorted((str(path), path.stat().st_size, path.stat().st_mtime_ns) for path in made.rglob("*") if path.is_file())


def run(program, made, arguments, truth, to, limit, watched=None, evaluator=CHASLES):
    """The outcome of `chasles run`, with the error against this truth by the program `evaluator`. `watched`: a
    folder that must not change."""
    before = listing(watched) if watched else None
    code, _, err, seconds = call(program, ["run", made, *arguments, "-o", to, "--quiet"], limit)
    summary = loaded((to / "summary.json").read_text()) if (to / "summary.json").is_file() else {}
    paths = (to, made, made.parent)
    errors, remarks = lines(without_paths(err, *paths))
    figures = {}
    if summary.get("frames"):
        figures = loaded(call(evaluator, ["evaluate", to, truth, "--json"], limit)[1])
    return {"command": " ".join(["chasles run", made.name, *arguments]), "exit": code, "seconds": seconds, "errors": errors,
            "remarks": [without_paths(line, *paths) for line in summary.get("remarks", [])] + remarks,
            "ate": figures.get("ate_posyaw_m"), "estimated": summary.get("frames"),
            "frames": summary.get("frontend", {}).get("frames"), "health": summary.get("health"),
            "changed": before is not None and before != listing(watched)}


def check(program, made, limit):
    code, out, err, seconds = call(program, ["check", made, "--json"], limit)
    report, paths = loaded(out), (made, made.parent)
    images = report.get("facts", {}).get("images", {})
    facts = [f"{images['count']['value']:.0f} images, longest interval {images['longest interval']['value']:.0f} ms"] if "longest interval" in images else []
    findings = sorted(report.get("findings", []), key=lambda f: ("error", "warning", "note").index(f["severity"]))
    return {"command": f"chasles check {made.name}", "exit": code, "seconds": seconds,
            "errors": [without_paths(line, *paths) for line in lines(err)[0]],
            "findings": [without_paths(f"{f['about']}: {f['what']}; {f.get('advice', '')}", *paths) for f in findings],
            "remarks": [without_paths(line, *paths) for line in report.get("remarks", [])], "facts": facts}


# --- what is right -----------------------------------------------------------------------------------------

def near(outcome, intact, factor=NEAR):
    """What is wrong with a run that should be near that of the intact recording."""
    if outcome["exit"] != 0:
        return f"exit {outcome['exit']}"
    if outcome["ate"] is None or not intact or intact["ate"] is None:
        return "no error to compare"
    if outcome["ate"] > factor * intact["ate"]:
        return f"{outcome['ate'] / intact['ate']:.1f} times the intact error"
    if outcome["estimated"] * intact["frames"] < 0.9 * intact["estimated"] * outcome["frames"]:
        return "fewer frames"
    return ""


def not_right(case, outcome, checked, intact):
    """What is not right in these outcomes of a case (Case or Rule), or ""."""
    named = (lambda line: line.replace(case.name, "")) if "." in case.name else str  # a file's name says nothing
    said = any(re.search(case.says, named(line)) for line in outcome["errors"] + outcome["remarks"])
    far = near(outcome, intact, getattr(case, "factor", NEAR))
    wrong = {"any": "", "near": far, "error": "" if outcome["exit"] in (1, 2, 3) and outcome["errors"] else "no error",
             "near or reported": far if not said else ""}[case.end]
    if not wrong and case.says and case.end != "near or reported" and not said:
        wrong = "`run` does not report it"
    if not wrong and outcome["changed"]:
        wrong = "the recording was changed"
    if not wrong and case.finds and checked:
        reported = checked["errors"] + checked["findings"] + checked["remarks"] + checked["facts"]
        found = any(re.search(case.finds.removeprefix("!"), named(line)) for line in reported)
        wrong = "" if found != case.finds.startswith("!") else "`check` does not find it" if not found else "`check` complains"
    return wrong


# --- cells of tables ---------------------------------------------------------------------------------------

def message(code, text, size=90):
    """The exit code and a message, as code: it is not prose of the page."""
    text = re.sub(r"\s+", " ", text).replace("|", "/").replace("`", "'").replace("\ufeff", "")
    text = text.removeprefix("DST: ").replace("DST/", "")
    text = text if len(text) <= size else text[:size - 1].rstrip() + "…"
    return f"{code}: `{text}`" if text else f"{code}"


DULL = "OPENBLAS_CORETYPE|^no truth: "  # remarks that every run makes here


def words_of(outcome, pattern):
    """The line that matters most: what should be said, then errors, then the rest."""
    said = outcome["errors"] + outcome.get("findings", []) + outcome["remarks"] + outcome.get("facts", [])
    pattern = pattern.removeprefix("!")
    matching = [line for line in said if pattern and re.search(pattern, line)]
    rest = [line for line in outcome["remarks"] if not re.search(DULL, line)]
    return (outcome["errors"] or matching or outcome.get("findings") or rest or [""])[0]


def run_cells(case, outcome):
    ate = "-" if outcome["ate"] is None else f"{1000 * outcome['ate']:.{0 if outcome['ate'] > 0.1 else 1}f}"
    frames = f"{outcome['estimated']}/{outcome['frames']}" if outcome["frames"] else "-"
    return [message(outcome["exit"], words_of(outcome, case.says)), ate, frames]
