"""write.py [--check]: see tools/python-types."""

import ast
import inspect
import pathlib
import re
import sys
import textwrap

HERE = pathlib.Path(__file__).resolve().parent
PACKAGE = HERE.parent / "chasles"
WIDTH = 120
PREFIXES = ("start", "frontend", "batch", "reader")
OF_RUN = {"estimator": "str", "threads": "int", "begin": "Literal['auto', 'truth']", "as_recorded": "bool", "map": "Optional[_Path]",
          "save_map": "Optional[_Path]", "keep_images": "Optional[int]", "mode": "Optional[str]",
          "config": "Optional[_Path]", "progress": "Optional[bool]"}


def compiled(name):
    """A compiled module alone: the package imports _settings.py, which may not be there yet."""
    import importlib.machinery
    import importlib.util
    import os

    for folder in os.environ["PYTHONPATH"].split(os.pathsep):
        for suffix in importlib.machinery.EXTENSION_SUFFIXES:
            file = pathlib.Path(folder) / "chasles" / f"{name}{suffix}"
            if file.exists():
                spec = importlib.util.spec_from_file_location(f"chasles.{name}", file)
                module = importlib.util.module_from_spec(spec)
                spec.loader.exec_module(module)
                return module
    raise SystemExit(f"tools/python-types: no chasles/{name} in {os.environ['PYTHONPATH']}; `make wheel` builds it")


def merged(*kinds):
    """{name: type, default, unit, meaning} of several kinds; types that differ are joined."""
    result = {}
    for settings in kinds:
        for name, one in settings.items():
            if name not in result:
                result[name] = dict(one)
            elif one["type"] not in result[name]["type"]:
                result[name]["type"] = f"Union[{result[name]['type']}, {one['type']}]"
    return result


def grouped(settings):
    """({prefix: settings}, those without a prefix)"""
    groups, plain = {}, {}
    for name, one in settings.items():
        prefix, dot, rest = name.partition(".")
        if dot:
            groups.setdefault(prefix, {})[rest] = one
        else:
            plain[name] = one
    return groups, plain


def typed_dict(name, doc, fields, base="TypedDict"):
    text = f'\n\nclass {name}({base}, total=False):\n    """{doc}"""\n\n'
    for field, (kind, note) in fields.items():
        text += f"    {field}: {kind}\n"
        if note:
            text += textwrap.fill(note, WIDTH, initial_indent='    """', subsequent_indent="    ") + '"""\n'
    return text


def without(fields, others):
    return {name: one for name, one in fields.items() if name not in others}


def note_of(one):
    unit = f" [{one['unit']}]" if one["unit"] not in ("", "1", "bool", "choice", "count") else ""
    return f"{one['meaning']}{unit}; default {one['default']}".replace("\\", "\\\\")


def fields_of(settings):
    return {name: (one["type"], note_of(one)) for name, one in settings.items()}


def group_types(groups):
    return {prefix: f"{prefix.capitalize()}Settings" for prefix in groups}


def settings_module(core, lab):
    imu, velocity = core.settings("imu"), core.settings("velocity")
    groups, plain = grouped(merged(imu, velocity))
    names = group_types(groups)
    text = ('"""The settings as types, for the keys of dictionaries. Written by tools/python-types: do not edit."""\n\n'
            "from __future__ import annotations\n\nimport os\n"
            "from typing import Literal, Optional, TypedDict, Union\n\n"
            '_Path = Union[str, "os.PathLike[str]"]\n')
    for prefix, settings in groups.items():
        text += typed_dict(names[prefix], f"Settings of the prefix `{prefix}`.", fields_of(settings))
    of_groups = {prefix: (names[prefix], "") for prefix in groups}
    of_run = {**fields_of(plain), **of_groups}
    groups, plain = grouped({name: one for name, one in imu.items() if name.split(".")[0] not in ("start", "frontend")})
    of_filter = {"estimator": ("str", ""), **fields_of(plain), "batch": ("BatchSettings", "")}
    shared = {name: one for name, one in of_filter.items() if of_run.get(name) == one}
    text += typed_dict("FilterSettings", "Settings of the filter with an IMU, by name.", shared)
    text += typed_dict("RunSettings", "Settings of a run, by name: chasles.run(recording, **settings).",
                       without(of_run, shared), "FilterSettings")
    text += typed_dict("RunArguments", "Arguments of chasles.run besides the recording, for chasles.compare.",
                       {name: (kind, "") for name, kind in OF_RUN.items() if name not in of_run}, "RunSettings")
    text += typed_dict("FilterArguments", "Settings of a filter of chasles.monte_carlo, and its estimator.",
                       without(of_filter, shared), "FilterSettings")
    text += typed_dict("SceneSettings", "Settings of a scene with an IMU.", fields_of(lab.settings("scene")))
    text += typed_dict("StreetSettings", "Settings of a street.", fields_of(lab.settings("street")))
    return text


def lines_of(parts):
    """Joined by commas, and broken between parts alone."""
    whole = ", ".join(part.replace(" ", "\0") for part in parts)
    return textwrap.fill(whole, WIDTH - 8, break_long_words=False, break_on_hyphens=False).replace("\0", " ")


def keywords(settings):
    """As keyword arguments of a stub."""
    return lines_of(f"{name}: {one if isinstance(one, str) else one['type']} = ..." for name, one in settings.items())


def run_keywords(core, own):
    groups, plain = grouped(merged(core.settings("imu"), core.settings("velocity")))
    plain.update({prefix: name for prefix, name in group_types(groups).items()})
    for name in own:
        plain.pop(name, None)
    return plain


def docstring(text, indent):
    lines = inspect.cleandoc(text).replace("\\", "\\\\").split("\n")
    return "\n".join([f'{indent}"""{lines[0]}', *((indent + line).rstrip() for line in lines[1:])]) + '"""\n'


def arguments(text):
    return "\n".join(f"        {line}" for line in text.split("\n"))


def function(name, first, settings, result, doc):
    return (f"\n\ndef {name}(\n        {first}\n{arguments(keywords(settings))},\n) -> {result}:\n"
            f"{docstring(doc, '    ')}    ...\n")


def calls_stub(core, lab):
    tree = ast.parse((PACKAGE / "_calls.py").read_text(encoding="utf-8"))
    docs = {one.name: ast.get_docstring(one) for one in tree.body if isinstance(one, ast.FunctionDef)}
    of_run = run_keywords(core, OF_RUN)
    scene = merged(lab.settings("scene"), lab.settings("street"))
    groups, _ = grouped(merged(core.settings("imu"), core.settings("velocity")))
    first_of_run = lines_of(f"{name}: {kind} = ..." for name, kind in OF_RUN.items()).replace("\n", "\n        ") + ","
    text = ('"""Types of _calls.py, with all settings. Written by tools/python-types: do not edit."""\n\n'
            "from concurrent.futures import Executor as _Executor\n"
            "from typing import Literal, Mapping, Optional, Union\n\nfrom ._core import Path as _Path, Recording\n"
            "from ._run import Run\nfrom ._settings import (\n    FilterArguments,\n    RunArguments,\n"
            + "".join(f"    {name},\n" for name in sorted(group_types(groups).values()))
            + ")\nfrom .lab import Comparison, Study\n")
    text += function("simulate", "scene: str = ..., *, run: int = ..., images: bool = ..., progress: Optional[bool] = ...,",
                     {name: one for name, one in scene.items() if name != "run"}, "Recording", docs["simulate"])
    text += function("run", f"recording: Union[Recording, _Path], *,\n        {first_of_run}", of_run, "Run", docs["run"])
    text += function("compare", "recording: Union[Recording, _Path], estimators: Mapping[str, RunArguments], *,\n        "
                     + first_of_run, of_run, "Comparison", docs["compare"])
    text += function("monte_carlo", "scene: str, filters: Mapping[str, FilterArguments], *, runs: int, first: int = ...,\n"
                     "        workers: int = ..., folder: Optional[_Path] = ..., executor: Optional[_Executor] = ...,\n"
                     "        attempts: int = ..., progress: Optional[bool] = ...,",
                     {name: one for name, one in scene.items() if name not in ("runs", "first")}, "Study",
                     docs["monte_carlo"])
    return text


def plain_doc(text):
    """A docstring of the module without the signatures that pybind11 puts first."""
    # A default that is a matrix has several lines.
    text = re.sub(r"\A\w+\(((?!\n\n).)*?\) -> [^\n]*", "", (text or "").strip(), flags=re.DOTALL)
    return textwrap.dedent(text).strip()


def from_arrays_doc():
    tree = ast.parse((PACKAGE / "_arrays.py").read_text(encoding="utf-8"))
    return next(ast.get_docstring(one) for one in tree.body if getattr(one, "name", "") == "from_arrays")


def doc_of(owner, name):
    if name == "from_arrays":
        return from_arrays_doc()
    member = inspect.getattr_static(owner, name, None)
    if isinstance(member, property):
        return plain_doc(member.__doc__ or getattr(member.fget, "__doc__", ""))
    return plain_doc(getattr(member, "__doc__", ""))


def core_stub(core):
    imu_groups, _ = grouped(core.settings("imu"))
    names = group_types(imu_groups)
    groups, plain = grouped(core.settings("imu"))
    plain.update(names)
    for own in ("estimator", "map", "most_images"):
        plain.pop(own, None)
    source = (HERE / "core.pyi").read_text(encoding="utf-8")
    source = source.replace("SETTINGS)", "\n" + arguments(keywords(plain)) + ")")
    imports = ", ".join(sorted(names.values()))
    source = source.replace("from numpy.typing import ArrayLike, NDArray\n",
                            f"from numpy.typing import ArrayLike, NDArray\n\nfrom ._settings import {imports}\n")
    source = source.replace(" tools/python-types adds the docstrings and the settings (SETTINGS).",
                            " Written by tools/python-types from python/types/core.pyi: do not edit.")
    lines = [line.rstrip() for line in source.split("\n")]
    tree = ast.parse("\n".join(lines))
    wanted = []
    for one in tree.body:
        if isinstance(one, ast.ClassDef) and isinstance(getattr(core, one.name, None), type):
            owner = getattr(core, one.name)
            if one.name not in ("Error", "UsageError", "InputError", "NotInitialisedError", "DivergedError"):
                wanted.append((one, plain_doc(owner.__doc__), "class"))
            for member in one.body:
                if isinstance(member, ast.FunctionDef) and not member.name.startswith("_") or \
                        isinstance(member, ast.FunctionDef) and member.name == "__init__":
                    wanted.append((member, doc_of(owner, member.name), "function"))
    for node, doc, kind in sorted(wanted, key=lambda one: -one[0].lineno):
        if not doc:
            continue
        if kind == "class":
            lines.insert(node.body[0].lineno - 1 - len(getattr(node.body[0], "decorator_list", [])),
                         docstring(doc, "    ").rstrip("\n"))
            continue
        last = node.body[0].end_lineno - 1
        assert lines[last].endswith(": ..."), lines[last]
        lines[last] = lines[last][:-4]
        lines.insert(last + 1, docstring(doc, "        ").rstrip("\n"))
    return "\n".join(lines)


def main(check):
    core, lab = compiled("_core"), compiled("_lab")  # in this order: _lab uses _core
    stale = []
    for name, text in (("_settings.py", settings_module(core, lab)), ("_calls.pyi", calls_stub(core, lab)),
                       ("_core.pyi", core_stub(core))):
        file = PACKAGE / name
        if not file.exists() or file.read_text(encoding="utf-8") != text:
            stale.append(name)
            if not check:
                file.write_text(text, encoding="utf-8")
    if check and stale:
        raise SystemExit(f"{', '.join(stale)}: not those of the module; run tools/python-types")
    print("written:" if stale else "up to date", *stale)


if __name__ == "__main__":
    main("--check" in sys.argv[1:])
