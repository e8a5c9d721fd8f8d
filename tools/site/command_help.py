#!/usr/bin/env python3
"""command_help.py PROGRAM: a Markdown page of the options and settings of all subcommands, from --help."""
import html
import re
import subprocess
import sys

# Name, default, and unit or values; the meaning is below.
SETTING = re.compile(r"  (\S+) = (\S*) *(?:\[(.*)\]|(\S.*))?$")
ENTRY = re.compile(r"  (\S.*?)(?:  +(\S.*))?$")  # an option, a subcommand or a scene, with its meaning
BELOW = re.compile(r"   +(\S.*)$")
INTRODUCTION = """# All options and settings

This page is the text of `--help` of each subcommand of the program. [The command line](command-line.md)
explains it.
"""


def help_of(program, words):
    return subprocess.run([program, *words, "--help"], check=True, capture_output=True, text=True).stdout


def sections(text):
    """The sections of a help text: heading and lines. Text outside of a section has the heading None."""
    found = [(None, [])]
    for line in filter(str.strip, text.splitlines()):
        if line.startswith("  -h,--help"):
            continue
        if not line.startswith(" ") and line.endswith(":"):
            found.append((line[:-1], []))
        elif not line.startswith(" ") and found[-1][0]:
            found.append((None, [line]))
        else:
            found[-1][1].append(line)
    return [section for section in found if section[1]]


def prose(text):
    """HTML of a text, with its references to pages as links."""
    return re.sub(r"docs/([a-z-]+)\.md", r'<a href="\1.html">\g<0></a>', html.escape(text))


def code(text):
    return f"<code>{html.escape(text)}</code>" if text else ""


def rows(lines):
    """Cells in HTML: name and meaning, or name, default and meaning."""
    made = []
    for line in lines:
        if match := SETTING.match(line):
            name, default, unit, values = match.groups()
            made.append([code(name), code(default) + (f" {html.escape(unit)}" if unit else ""),
                         code(values.replace("|", " | ")) if values else ""])
        elif match := BELOW.match(line):
            made[-1][-1] = "<br>".join(filter(None, [made[-1][-1], prose(match[1])]))
        else:
            name, meaning = ENTRY.match(line).groups()
            made.append([code(name), prose(meaning or "")])
    return made


def table(lines):
    made = rows(lines)
    head = ["name", "default", "meaning"] if len(made[0]) == 3 else ["name", "meaning"]
    out = [f"<tr>{''.join(f'<th>{cell}</th>' for cell in head)}</tr>"]
    out += [f"<tr>{''.join(f'<td>{cell}</td>' for cell in row)}</tr>" for row in made]
    return "\n".join(['<div class="stacked"><table>', *out, "</table></div>", ""])


def slug(text):
    return re.sub(r"[^a-z0-9]+", "-", text.lower()).strip("-")


def text_lines(lines):
    usage = [line.removeprefix("Usage: ") for line in lines if line.startswith("Usage: ")]
    yield html.escape(" ".join(line for line in lines if not line.startswith("Usage: "))) + "\n"
    yield from (f"    {line}\n" for line in usage)


def commands(program, words=()):
    """(words, sections of the help) of the command and of all its subcommands."""
    found = sections(help_of(program, words))
    yield words, found
    for heading, lines in found:
        for line in lines if heading == "Subcommands" else ():
            if not line.startswith("   "):  # the text of the one above goes on
                yield from commands(program, (*words, line.split()[0]))


def page(program):
    """The lines of the page. A section or text that another subcommand has as well is written once."""
    yield INTRODUCTION
    written = {}
    for words, found in commands(program):
        title = " ".join(["chasles", *words])
        yield f"## {title}\n"
        for heading, lines in found:
            anchor = slug(f"{title} {heading}")
            first = written.setdefault((heading, *lines), (title, anchor))
            if heading:
                yield f"### {heading} {{: #{anchor} }}\n"
                yield table(lines) if first[1] == anchor else f"The same as of [{first[0]}](#{first[1]}).\n"
            elif first[1] == anchor:
                yield from text_lines(lines)


if __name__ == "__main__":
    print("\n".join(page(sys.argv[1])))
