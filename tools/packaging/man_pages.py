#!/usr/bin/env python3
"""man_pages.py CHASLES FOLDER: writes a man page for the command and one for each subcommand, from
what `CHASLES [SUBCOMMAND] --help` prints. The date is that of $SOURCE_DATE_EPOCH, or today's."""
import datetime
import os
import pathlib
import re
import subprocess
import sys

MANUAL = "Chasles manual"


def help_of(program, words):
    return subprocess.run([program, *words, "--help"], check=True, capture_output=True, text=True,
                          env={**os.environ, "LC_ALL": "C.UTF-8"}).stdout


class Help:
    """The parts of a help text: the sentence, the usage, and sections of (term, unit, text)."""

    def __init__(self, text):
        head, _, rest = text.partition("Usage: ")
        self.sentence = " ".join(head.split())
        self.usage, _, rest = rest.partition("\n")
        self.sections = []
        self._goes_on = False  # a text without a heading's colon
        for line in rest.split("\n"):
            self._take(line)

    def _take(self, line):
        if not line.strip():
            self._goes_on = False
            return
        if not line.startswith(" "):
            if self._goes_on:  # a text of several lines
                self.sections[-1] = (f"{self.sections[-1][0]} {line}", None)
            else:
                self._goes_on = not line.endswith(":")
                self.sections.append((line.rstrip(":"), None if self._goes_on else []))
            return
        entries = self.sections[-1][1]
        entry = re.match(r"  (?! )(.+?)(?:\s{2,}(.*))?$", line)
        if entry and " = " in entry[1]:
            entries.append([entry[1], entry[2] or "", ""])
        elif entry:
            entries.append([entry[1], "", entry[2] or ""])
        else:
            entries[-1][2] = f"{entries[-1][2]} {line.strip()}".strip()

    def named(self, name):
        return next((entries for heading, entries in self.sections if heading == name), [])


def roff(text):
    """Text for troff; code between backticks in bold, options with real hyphens."""
    text = text.replace("\\", "\\e").replace("'", "\\(aq")
    text = re.sub(r"(?<![\w-])--?(?=[A-Za-z])", lambda m: m[0].replace("-", "\\-"), text)
    text = re.sub(r"`([^`]+)`", r"\\fB\1\\fR", text)
    return "\\&" + text if text.startswith(".") else text


def term(words):
    """An option with its value: names in bold, the type of the value in italics."""
    def one(word):
        text = roff(word).replace("-", "\\-").replace("\\\\-", "\\-")
        return f"\\fB{text}\\fR" if word.startswith("-") else f"\\fI{text}\\fR"
    pieces = words.replace(" REQUIRED", "").split(" ")
    names = ", ".join(one(name) for name in pieces[0].split(","))
    return " ".join([names, *map(one, pieces[1:])])


def plain(name, text):
    """What a validator or another option adds to the term, as words of the text."""
    found = re.search(r":\w+ in \[(\S+) - (\S+)\](?:=(\S+))?", name)
    if found:
        default = f" (default: {found[3]})" if found[3] and "default" not in text else ""
        name, text = name.replace(found[0], ""), f"{text}{default}; from {found[1]} to {found[2]}"
    for word, meaning in (("Needs", "needs"), ("Excludes", "not with")):
        found = re.search(rf" {word}: (\S+)", name)
        if found:
            name, text = name.replace(found[0], ""), f"{text}; {meaning} {found[1]}"
    return name, text


def listed(entries, first=term):
    lines = []
    for name, unit, text in entries:
        name, text = plain(name, text)
        lines += [".TP", first(name) + (f"  {roff(unit)}" if unit else ""), roff(text) or "\\&"]
    return lines


def bold(text):
    return "\\fB" + roff(text).replace("-", "\\-").replace("\\\\-", "\\-") + "\\fR"


def setting(text):
    key, _, value = text.partition(" = ")
    return f"{bold(key)} = {roff(value)}"


def exit_status(top):
    """The list of exit codes, which only the command's own help has."""
    text = next(h for h, entries in top.sections if h.startswith("Exit codes"))
    codes = re.findall(r"(\d+) ([^,.]+(?:, (?!\d)[^,.]+)*)", text.partition(": ")[2])
    return [".SH EXIT STATUS", *listed([[code, "", meaning] for code, meaning in codes], bold)]


def is_settings(heading):
    return heading.startswith(("Settings", "Scenes"))


def options(page):
    lines = []
    for heading, entries in page.sections:
        if entries is None or is_settings(heading) or heading in ("Positionals", "Subcommands"):
            continue
        lines += [f".SS {roff(heading)}" if heading != "Options" else "", *listed(entries)]
    return [".SH OPTIONS", *filter(None, lines)]


def settings(page):
    lines = []
    for heading, entries in page.sections:
        if entries and is_settings(heading):
            first = setting if heading.startswith("Settings") else bold
            lines += [f".SS {roff(heading)}", *listed(entries, first)]
    scenes = any(heading.startswith("Scenes") for heading, _ in page.sections)
    title = ".SH SCENES AND SETTINGS" if scenes else ".SH SETTINGS"
    return [title, *lines] if lines else []


def page_name(words):
    return "-".join(["chasles", *words])


def man_page(words, page, top, version, date):
    name = page_name(words)
    usage = page.usage.removeprefix(" ".join(["chasles", *words])).strip()
    commands = page.named("Subcommands")
    also = [[], *([sub[0]] for sub in top.named("Subcommands"))] if words else []
    also = [other for other in also if other != words] + [[*words, sub[0]] for sub in commands]
    sentence = page.sentence.partition(". ")[0].rstrip(".")
    lines = [
        f'.TH {name.upper()} 1 {date} "Chasles {version}" "{MANUAL}"',
        ".ad l", ".nh",
        ".SH NAME", f"{name} \\- {roff(sentence[0].lower() + sentence[1:] if words else sentence)}",
        ".SH SYNOPSIS", f"{bold(' '.join(['chasles', *words]))} {roff(usage)}",
        ".SH DESCRIPTION", roff(page.sentence.rstrip(".") + ".")]
    if page.named("Positionals"):
        lines += [".SH ARGUMENTS", *listed(page.named("Positionals"))]
    lines += options(page)
    if commands:
        lines += [".SH COMMANDS", *listed(commands, bold)]
    lines += settings(page)
    lines += exit_status(top)
    lines += [".SH SEE ALSO", "\n".join(f".BR {page_name(other)} (1),".replace("-", "\\-") for other in sorted(also))]
    return "\n".join(lines).removesuffix(",") + "\n"


def pages(program, words):
    """(words, Help) of the command and of its subcommands."""
    page = Help(help_of(program, words))
    yield words, page
    for sub in page.named("Subcommands"):
        yield from pages(program, [*words, sub[0]])


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    program, folder = sys.argv[1], pathlib.Path(sys.argv[2])
    epoch = os.environ.get("SOURCE_DATE_EPOCH")
    date = (datetime.datetime.fromtimestamp(int(epoch), datetime.timezone.utc) if epoch
            else datetime.datetime.now(datetime.timezone.utc)).date().isoformat()
    version = subprocess.run([program, "--version"], check=True, capture_output=True,
                             text=True).stdout.split()[-1]
    found = list(pages(program, []))
    folder.mkdir(parents=True, exist_ok=True)
    for old in folder.glob("*.1"):
        old.unlink()
    for words, page in found:
        text = man_page(words, page, found[0][1], version, date)
        (folder / f"{page_name(words)}.1").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
