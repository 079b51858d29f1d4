"""The one Jinja2 environment: strict about names, free of mathematics."""

from __future__ import annotations

import re
from collections.abc import Iterable
from functools import cache
from importlib import resources
from typing import Any

import jinja2

_INCLUDE = re.compile(r'^[ \t]*#[ \t]*include[ \t]+"([\w.]+)"', re.MULTILINE)


def template_text(name: str) -> str:
    """Text of a file of `bladesmith.templates`, for example ``"c/platform.h"``."""
    return resources.files(f"{__package__.rpartition('.')[0]}.templates").joinpath(name).read_text(encoding="utf-8")


def included_headers(texts: Iterable[str], known: Iterable[str] = ()) -> dict[str, str]:
    """Headers of templates/c that C texts include, directly or not: name -> text; those of known names left out."""
    found: dict[str, str] = {}
    passed = set(known)
    waiting = list(texts)
    while waiting:
        for name in _INCLUDE.findall(waiting.pop()):
            if name not in passed:
                passed.add(name)
                found[name] = template_text(f"c/{name}")
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
