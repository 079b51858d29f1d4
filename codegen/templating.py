"""The one Jinja2 environment: strict about names, free of mathematics."""

from __future__ import annotations

from functools import cache
from importlib import resources
from typing import Any

import jinja2


def template_text(name: str) -> str:
    """Text of a file of `bladesmith.templates`, for example ``"c/platform.h"``."""
    return resources.files(f"{__package__.rpartition('.')[0]}.templates").joinpath(name).read_text(encoding="utf-8")


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
