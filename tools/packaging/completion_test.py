#!/usr/bin/env python3
"""completion_test.py CHASLES SHELL...: types into an interactive bash or zsh, presses Tab as a person
does, and compares the lines and lists that the shell then shows."""
import fcntl
import os
import pathlib
import pty
import re
import select
import struct
import subprocess
import sys
import tempfile
import termios
import time

READY = "ready> "
# What is typed, what the line then is, or what a list of several must contain and what not.
LINES = [
    ("chasles simu", "chasles simulate "),
    ("chasles map mer", "chasles map merge "),
    ("chasles calib", "chasles calibrate "),
    ("chasles calibrate no", "chasles calibrate noise "),
    ("chasles calibrate con", "chasles calibrate convert "),
    ("chasles run --save", "chasles run --save-map"),
    ("chasles run --pairing ne", "chasles run --pairing nearest"),
    ("chasles run --mode sl", "chasles run --mode slam"),
    ("chasles run --estimator win", "chasles run --estimator window:"),
    ("chasles run --set gate_q", "chasles run --set gate_quorum="),
    ("chasles run --set recognise=app", "chasles run --set recognise=appearance"),
    ("chasles run --set batch.mask_p", "chasles run --set batch.mask_p"),  # no such setting
    ("chasles simulate turnt", "chasles simulate turntable"),
    ("chasles compare hallway --charts standard,right-sen", "chasles compare hallway --charts standard,right-sen3"),
    ("chasles compare --scene-set hall_len", "chasles compare --scene-set hall_length="),
    ("chasles run record", "chasles run recording/"),
    ("chasles report -o page.html first_", "chasles report -o page.html first_run/"),
    ("chasles run recording --config sett", "chasles run recording --config settings.yaml"),
]
# zsh appends what the next key may take back.
IN_ZSH = {
    "chasles run --save-map": "chasles run --save-map=",
    "chasles compare hallway --charts standard,right-sen3": "chasles compare hallway --charts standard,right-sen3,",
}
LISTS = [
    ("chasles ", ["run", "check", "simulate", "montecarlo", "export"], ["completion"]),
    ("chasles run --truth-level ", ["auto", "yes", "no"], ["recording"]),
    ("chasles run --set chart=", ["standard", "right-sen3"], ["recording"]),
    ("chasles simulate street", ["street-ins", "street-exact"], []),
    ("chasles montecarlo ", ["hallway", "loops"], ["recording"]),
    ("chasles map ", ["merge"], []),
]


class Shell:
    """An interactive shell on a terminal of its own."""

    def __init__(self, name, program, folder, home):
        completion = home / ("_chasles" if name == "zsh" else "chasles.bash")
        env = {"PATH": f"{program.parent}:/usr/bin:/bin", "HOME": str(home), "TERM": "dumb",
               "LC_ALL": "C.UTF-8"}
        begin = {"bash": [f"PS1='{READY}'", "bind 'set bell-style none'",
                          "bind 'set completion-query-items 1000'", "bind 'set page-completions off'",
                          f"source {completion}"],
                 "zsh": [f"PS1='{READY}'", "unsetopt beep zle_bracketed_paste prompt_sp", f"fpath=({home} $fpath)",
                         "autoload -Uz compinit", "compinit -u", "LISTMAX=1000"]}[name]
        command = {"bash": ["bash", "--norc", "--noprofile", "-i"], "zsh": ["zsh", "-f", "-i"]}[name]
        os.system(f"'{program}' completion {name} > '{completion}'")
        self.process, self.terminal = pty.fork()
        if self.process == 0:
            os.chdir(folder)
            os.execvpe(command[0], command, env)
        # Wide, so that no line is broken.
        fcntl.ioctl(self.terminal, termios.TIOCSWINSZ, struct.pack("HHHH", 200, 400, 0, 0))
        self.type("".join(line + "\n" for line in begin) + "echo beg''un\n")
        text, last = "", time.monotonic()
        while "begun\n" not in text:
            text += self.read(0.1)
            if time.monotonic() - last > 60:
                sys.exit(f"completion_test.py: {name} does not begin: {text}")
        self.read()

    def type(self, text):
        os.write(self.terminal, text.encode())

    def read(self, quiet=0.3):
        """What the shell writes until it is quiet."""
        text, last = "", time.monotonic()
        while time.monotonic() - last < quiet:
            if select.select([self.terminal], [], [], 0.05)[0]:
                text += os.read(self.terminal, 65536).decode(errors="replace")
                last = time.monotonic()
        return re.sub(r"\x1b\[[0-9;?]*[A-Za-z]|\r|\x1b[=>]", "", text)

    def line_after(self, typed, quiet, tabs=1):
        """All that is shown after typing and Tab, once the shell is quiet so long [s]. Ctrl-U clears the
        line."""
        self.type(typed)
        self.read(quiet / 2)
        self.type("\t" * tabs)
        shown = self.read(quiet)
        self.type("\x15")
        self.read(quiet / 2)
        return shown

    def close(self):
        os.write(self.terminal, b"\x15exit\n")
        os.close(self.terminal)
        os.waitpid(self.process, 0)


def wrong_line(shell, typed, wanted, quiet):
    line = replay(typed + shell.line_after(typed, quiet).replace("\x07", "").split("\n")[0])
    return None if line.rstrip() == wanted.rstrip() else f"gave '{line}', expected '{wanted}'"


def wrong_list(shell, typed, wanted, unwanted, quiet):
    shown = set(shell.line_after(typed, quiet, 2).split())
    missing, extra = set(wanted) - shown, set(unwanted) & shown
    if missing or extra:
        return f"lacks {sorted(missing)}, has {sorted(extra)} in {sorted(shown)}"
    return None


def failures(shell, name):
    tests = [(typed, lambda q, t=typed, w=wanted: wrong_line(shell, t, w, q)) for typed, wanted in
             ((typed, IN_ZSH.get(wanted, wanted) if name == "zsh" else wanted) for typed, wanted in LINES)]
    tests += [(typed, lambda q, t=typed, w=wanted, u=unwanted: wrong_list(shell, t, w, u, q))
              for typed, wanted, unwanted in LISTS]
    for typed, wrong in tests:
        # A machine under load is quiet without being ready.
        found = wrong(0.2) and wrong(1) and wrong(5)
        if found:
            yield f"{name}: '{typed}' and Tab {found}"


def output(program, *words):
    done = subprocess.run([program, *words], capture_output=True, text=True)
    return done.stdout if done.returncode == 0 else (done.returncode, done.stderr)


def missing_options(program):
    """Options of the help that the completion of bash lacks, and what it says to another shell."""
    script = output(program, "completion", "bash")
    for command in re.findall(r"^  (\w+)  ", output(program, "--help").partition("Subcommands:")[2], re.M):
        case = script.partition(f"    ' {command}')\n")[2].partition("\n      ;;\n")[0]
        for option in re.findall(r"^  (?:-\w,)?(--[\w-]+)", output(program, command, "--help"), re.M):
            if not re.search(rf"[ ']{option}[ ']", case):
                yield f"bash: chasles {command} lacks {option}"
    wrong = output(program, "completion", "fish")
    if wrong[0] != 1 or "found 'fish', expected bash or zsh" not in wrong[1]:
        yield f"chasles completion fish gave {wrong}"


def replay(line):
    """The line as it stands after backspaces."""
    result = ""
    for c in line:
        result = result[:-1] if c == "\b" else result + c
    return result


def main():
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    program = pathlib.Path(sys.argv[1]).resolve()
    found = list(missing_options(program))
    for name in sys.argv[2:]:
        with tempfile.TemporaryDirectory() as home, tempfile.TemporaryDirectory() as folder:
            for made in ("recording", "first_run"):
                (pathlib.Path(folder) / made).mkdir()
            (pathlib.Path(folder) / "settings.yaml").touch()
            shell = Shell(name, program, folder, pathlib.Path(home))
            found += failures(shell, name)
            shell.close()
    if found:
        sys.exit("\n".join(found))


if __name__ == "__main__":
    main()
