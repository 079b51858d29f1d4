"""Options that mean one thing have one default wherever they occur."""

from __future__ import annotations

import inspect
import re
from importlib import import_module

import pytest

PACKAGES = ("", "codegen", "objects", "curves", "interchange", "mechanics", "poses", "kinematics", "dynamics",
            "registration", "tracer", "plot")  # fmt: skip
#: Name of an option: its default, and what its description says.
OPTIONS = {
    "threads": (None, r"[Dd]efault: the package's|As of|As in|As for|as in|See `"),
    "progress": (False, r"bladesmith\.Progress|`Progress`|As for|As of"),
    "executor": (None, r"concurrent\.futures\.Executor|As for|As of"),
}


def public_callables():
    """Functions, classes and methods behind public names, each once."""
    seen = {}
    for package in PACKAGES:
        module = import_module(f"bladesmith.{package}".rstrip("."))
        for name in dir(module):
            value = getattr(module, name)
            members = [(name, value)]
            if inspect.isclass(value):
                members += [
                    (f"{name}.{m}", inspect.getattr_static(value, m)) for m in dir(value) if not m.startswith("_")
                ]
            for label, member in members:
                home = getattr(member, "__module__", None) or ""
                if callable(member) and home.startswith("bladesmith"):
                    seen.setdefault(f"{home}.{getattr(member, '__qualname__', label)}", member)
    return seen


def with_option(option):
    found = {}
    for name, member in public_callables().items():
        try:
            parameters = inspect.signature(member).parameters
        except (TypeError, ValueError):
            continue
        if option in parameters:
            found[name] = (parameters[option].default, inspect.getdoc(member) or "")
    return found


@pytest.mark.parametrize(("option", "least"), [("threads", 20), ("progress", 9), ("executor", 4)])
def test_an_option_has_one_default_and_one_meaning(option, least):
    default, meaning = OPTIONS[option]
    found = with_option(option)
    assert len(found) >= least, sorted(found)
    assert {name: value for name, (value, _) in found.items() if value is not default} == {}
    undocumented = []
    for name, (_, text) in found.items():
        described = re.search(rf"^[\w, ]*\b{option}\b[\w, ]*(?: : .*)?\n((?: +.*\n?)+)", text, re.M)
        if described and not re.search(meaning, described[0]):
            undocumented.append(name)
    assert undocumented == []
