"""Calls of the compiled part with arguments that it does not take: an error of one line, with the argument, what was
found and what was expected, where pybind11 prints all signatures and values."""

from __future__ import annotations

import functools
import numbers
import os
import re
import types
from typing import Any, Callable, Optional

import numpy

from . import _core
from ._arguments import nearest

_KINDS = {"int": "an int", "float": "a number", "str": "a str", "bool": "True or False", "os.PathLike": "a path",
          "dict": "a dictionary", "numpy.ndarray": "an array"}


def found(value: Any) -> str:
    """What a value is, for messages: short, and of one line."""
    if isinstance(value, numpy.ndarray):
        return f"an array {value.shape} of {value.dtype}"
    text = " ".join(repr(value).split())
    return text if len(text) <= 60 else f"an object of type {type(value).__name__}"


def _split(text: str) -> list[str]:
    """At the commas outside brackets and quotes."""
    parts, depth, begin = [], 0, 0
    for i, c in enumerate(text):
        depth += (c in "[({") - (c in "])}")
        if c == "," and depth == 0:
            parts.append(text[begin:i])
            begin = i + 1
    return [part.strip() for part in (*parts, text[begin:]) if part.strip()]


class _Parameter:
    def __init__(self, text: str, keyword: bool) -> None:
        self.optional = " = " in text
        name, _, kind = text.split(" = ")[0].partition(": ")
        self.name, self.kind, self.keyword = name, kind, keyword


def _parameters(signature: str) -> tuple[list[_Parameter], bool]:
    """Of what pybind11 prints in brackets; and whether there are more, by name."""
    inner = signature[signature.index("(") + 1:signature.rindex(")")]
    result, keyword = [], False
    for part in _split(inner):
        if part == "*":
            keyword = True
        elif not part.startswith("*"):
            result.append(_Parameter(part, keyword))
    return result, "**" in inner


def _fits(value: Any, kind: str) -> bool:
    if kind.startswith("Optional["):
        return value is None or _fits(value, kind[9:-1])
    if kind.startswith(("List[", "Sequence[")):
        inner = kind[kind.index("[") + 1:-1]
        return not isinstance(value, (str, bytes)) and hasattr(value, "__iter__") and all(_fits(one, inner) for one in value)
    if kind.startswith("numpy.ndarray["):
        return _array_fits(value, kind)
    checks: dict[str, Callable[[Any], bool]] = {
        "int": lambda v: isinstance(v, (numbers.Integral, numpy.integer)),
        "float": lambda v: isinstance(v, (numbers.Real, numpy.number)),
        "str": lambda v: isinstance(v, str),
        "bool": lambda v: isinstance(v, (bool, numpy.bool_)),
        "os.PathLike": lambda v: isinstance(v, (str, bytes, os.PathLike)),
        "dict": lambda v: isinstance(v, dict),
        "numpy.ndarray": lambda v: isinstance(v, numpy.ndarray)}
    if kind in checks:
        return checks[kind](value)
    own = getattr(_core, kind.rpartition(".")[2], None) if kind.startswith("chasles._core.") else None
    return isinstance(value, own) if isinstance(own, type) else True


def _shape_of(kind: str) -> Optional[list[str]]:
    match = re.search(r"\[numpy\.\w+\[([^\]]*)\]", kind)
    return [one.strip() for one in match[1].split(",")] if match else None


def _array_fits(value: Any, kind: str) -> bool:
    try:
        array = numpy.asarray(value, dtype=float)
    except (TypeError, ValueError):
        return False
    shape = _shape_of(kind)
    if not shape:
        return True
    if all(one in "mn" for one in shape):
        return 0 < array.ndim <= 2
    expected = tuple(int(one) for one in shape)
    return array.shape == expected or (expected[-1:] == (1,) and array.shape == expected[:-1])


def _expected(kind: str) -> str:
    if kind.startswith("Optional["):
        return f"{_expected(kind[9:-1])}, or None"
    if kind.startswith(("List[", "Sequence[")):
        inner = kind[kind.index("[") + 1:-1]
        return f"a list of {inner.rpartition('.')[2]}"
    if kind.startswith("numpy.ndarray["):
        shape = _shape_of(kind)
        if shape and not any(one in "mn" for one in shape):
            return f"an array ({', '.join(one for one in shape if one != '1')}{',' if shape[-1] == '1' else ''})"
        return "an array of numbers, of one or two dimensions"
    name = kind.rpartition(".")[2]
    return _KINDS.get(kind, f"{'an' if name[:1] in 'AEIO' else 'a'} {name}")


def _complaint(parameters: list[_Parameter], more: bool, args: tuple[Any, ...], kwargs: dict[str, Any]) -> Optional[str]:
    positional = [one for one in parameters if not one.keyword]
    if len(args) > len(positional):
        return f"found {len(args)} arguments without a name, expected at most {len(positional)}"
    given = {one.name: value for one, value in zip(positional, args)}
    names = [one.name for one in parameters]
    for name in kwargs:
        if name in given:
            return f"{name}: given twice"
        if name not in names and not more:
            return f"unknown argument '{name}'{nearest(name, names)}; expected {', '.join(names)}"
    given.update(kwargs)
    for one in parameters:
        if one.name not in given:
            if not one.optional:
                return f"{one.name} is missing; expected {_expected(one.kind)}"
        elif not _fits(given[one.name], one.kind):
            return f"{one.name}: found {found(given[one.name])}, expected {_expected(one.kind)}"
    for one in parameters:
        value = given.get(one.name)
        if one.kind == "int" and value is not None and not 0 <= value < 2**31:
            return f"{one.name}: found {value}, expected a whole number that is not below 0 and not above {2**31 - 1}"
    return None


def _explained(name: str, text: str, args: tuple[Any, ...], kwargs: dict[str, Any]) -> str:
    signatures = re.findall(r"^ +\d+\. (.*(?:\n(?! +\d+\. |\nInvoked).*)*)", text.partition("\n\nInvoked with")[0], re.M)
    signature = " ".join(signatures[0].split()) if signatures else ""
    parameters, more = _parameters(signature.partition(" -> ")[0]) if "(" in signature else ([], True)
    if parameters and parameters[0].name == "self":
        parameters = parameters[1:]
    complaint = _complaint(parameters, more, args, kwargs)
    if complaint is None:
        values = [found(value) for value in args] + [f"{key}={found(value)}" for key, value in kwargs.items()]
        complaint = f"found ({', '.join(values)}), expected ({', '.join(one.name for one in parameters)})"
    return f"{name}: {complaint}"


def _wrapped(function: Any, name: str, skipped: int) -> Any:
    @functools.wraps(function)
    def call(*args: Any, **kwargs: Any) -> Any:
        try:
            return function(*args, **kwargs)
        except TypeError as error:
            text = str(error)
            # What a function of Python raised within the call has frames of its own.
            within = error.__traceback__ is not None and error.__traceback__.tb_next is not None
            if within or not re.match(rf"{re.escape(function.__name__)}\(\): incompatible \w+ arguments\.", text):
                raise
            said = _explained(name, text, args[skipped:], kwargs)
        raise TypeError(said)

    del call.__wrapped__  # type: ignore[attr-defined]
    setattr(call, "__signature__", "of the compiled part")  # the stubs have it; inspect.signature() has none
    return call


def wrap(module: types.ModuleType) -> None:
    """Of all functions, classes and methods of the module."""
    for name, one in list(vars(module).items()):
        if isinstance(one, types.BuiltinFunctionType):
            setattr(module, name, _wrapped(one, {"recording_of": "from_arrays"}.get(name, name), 0))
        elif isinstance(one, type) and not issubclass(one, Exception):
            for member, method in list(vars(one).items()):
                if type(method).__name__ == "instancemethod" and (member == "__init__" or not member.startswith("_")):
                    called = name if member == "__init__" else f"{name}.{member}"
                    setattr(one, member, _wrapped(method, called, 1))


wrap(_core)
