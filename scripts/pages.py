"""Pages whose tables the scripts here fill, between markers."""


def fill(page, name, text):
    """Replaces the text of the file between the markers of this name."""
    begin, end = f"<!-- {name}:begin -->\n", f"<!-- {name}:end -->"
    head, rest = page.read_text().split(begin)
    page.write_text(head + begin + text + "\n" + end + rest.split(end)[1])
