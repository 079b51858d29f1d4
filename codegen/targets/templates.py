"""The one Jinja2 environment: strict about names, free of mathematics."""

from __future__ import annotations

import re
from collections.abc import Iterable
from functools import cache
from importlib import resources
from importlib.resources.abc import Traversable
from typing import Any

import jinja2

#: A line of C that includes a header of ours.
INCLUDE = re.compile(r'^[ \t]*#[ \t]*include[ \t]+"([\w.]+)"[^\n]*$', re.MULTILINE)


#: The templates among the files of their folders.
_SUFFIXES = (".h", ".j2", ".cdef", ".css", ".js")


def template_text(name: str) -> str:
    """Text of a template or header by its name, which no other has: for example ``"platform.h"``."""
    return _templates()[name].read_text(encoding="utf-8")


@cache
def _templates() -> dict[str, Traversable]:
    """Templates and headers of all folders, by name."""
    found: dict[str, Traversable] = {}
    waiting = [resources.files(f"{__package__.partition('.')[0]}.templates")]
    while waiting:
        for item in waiting.pop().iterdir():
            if item.is_dir():
                waiting.append(item)
            elif item.name.endswith(_SUFFIXES):
                found[item.name] = item
    return found


def included_headers(texts: Iterable[str], known: Iterable[str] = ()) -> dict[str, str]:
    """Headers of templates that C texts include, directly or not: name -> text; those of known names left out."""
    found: dict[str, str] = {}
    passed = set(known)
    waiting = list(texts)
    while waiting:
        for name in INCLUDE.findall(waiting.pop()):
            if name not in passed:
                passed.add(name)
                found[name] = template_text(name)
                waiting.append(found[name])
    return found


@cache
def environment() -> jinja2.Environment:
    """Environment over the bundled templates."""
    return jinja2.Environment(
        loader=jinja2.FunctionLoader(template_text),
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        autoescape=False,  # the output is source code; every name was validated before it came here
    )


def render(name: str, **values: Any) -> str:
    """Fill a template."""
    return environment().get_template(name).render(**values)
