#!/usr/bin/env python3
"""completion_test.py CHASLES SHELL...: types into an interactive bash or zsh, presses Tab as a person
does, and compares the lines and lists that the shell then shows."""
import os
import pathlib
import pty
import re
import select
import sys
import tempfile
import time

READY = "ready> "
# What is typed, what the line then is, or what a list of several must contain and what not.
LINES = [
    ("chasles simu", "chasles simulate "),
    ("chasles map mer", "chasles map merge "),
    ("chasles run --save", "chasles run --save-map"),
    ("chasles run --pairing ne", "chasles run --pairing nearest"),
    ("chasles run --mode sl", "chasles run --mode slam"),
    ("chasles run --estimator win", "chasles run --estimator window:"),
    ("chasles run --set recogn", "chasles run --set recognise="),
    ("chasles run --set recognise=app", "chasles run --set recognise=appearance"),
    ("chasles run --set batch.mask_p", "chasles run --set batch.mask_p"),  # no such setting
    ("chasles simulate turnt", "chasles simulate turntable"),
    ("chasles compare hallway --charts standard,right-sen", "chasles compare hallway --charts standard,right-sen3"),
    ("chasles compare --scene-set hall_len", "chasles compare --scene-set hall_length="),
    ("chasles run record", "chasles run recording/"),
    ("chasles report -o page.html first_", "chasles report -o page.html first_run/"),
    ("chasles run recording --config sett", "chasles run recording --config settings.yaml"),
]
LISTS = [
    ("chasles ", ["run", "check", "simulate", "montecarlo", "export"], ["completion"]),
    ("chasles run --truth-level ", ["auto", "yes", "no"], ["recording"]),
    ("chasles run --set chart=", ["standard", "right-sen3"], ["recording"]),
    ("chasles simulate street", ["street-ins", "street-exact"], []),
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
        import fcntl, struct, termios
        fcntl.ioctl(self.terminal, termios.TIOCSWINSZ, struct.pack("HHHH", 200, 400, 0, 0))
        for line in begin:
            self.type(line + "\n")
            self.read()
        self.type("clear; echo begun\n")
        self.read(0.5)

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

    def line_after(self, typed, tabs=1):
        """All that is shown after typing and Tab. Ctrl-U and Enter clear the line."""
        self.type(typed)
        self.read(0.15)
        self.type("\t" * tabs)
        shown = self.read(0.4)
        self.type("\x15")
        self.read(0.15)
        return shown

    def close(self):
        os.write(self.terminal, b"\x15exit\n")
        os.close(self.terminal)
        os.waitpid(self.process, 0)


def failures(shell, name):
    for typed, wanted in LINES:
        line = typed + shell.line_after(typed).replace("\x07", "").split("\n")[0]
        line = replay(line)
        if line.rstrip() != wanted.rstrip():
            yield f"{name}: '{typed}' and Tab gave '{line}', expected '{wanted}'"
    for typed, wanted, unwanted in LISTS:
        shown = set(re.split(r"[\s]+", shell.line_after(typed, 2)))
        missing, extra = set(wanted) - shown, set(unwanted) & shown
        if missing or extra:
            yield f"{name}: '{typed}' and Tab lacks {sorted(missing)}, has {sorted(extra)} in {sorted(shown)}"


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
    found = []
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
