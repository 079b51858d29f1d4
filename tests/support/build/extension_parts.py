"""Two extensions that share a translation unit; a process of its own can run this file."""

from dataclasses import replace

from bladesmith.codegen.build import extension
from bladesmith.codegen.build.extension import ExtensionSource
from bladesmith.codegen.build.translation_units import Unit

PART = Unit(
    "part", '#include "part.h"\ndouble part(double x) { return FACTOR * x; }\n', {"part.h": "#define FACTOR 3\n"}
)
WHOLE = ExtensionSource(
    "whole",
    "double twice(double); ptrdiff_t size(const uint8_t *);",
    "#include <stddef.h>\n#include <stdint.h>\ndouble part(double);\ndouble twice(double x) { return 2 * part(x); }\n"
    "ptrdiff_t size(const uint8_t *x) { return x[0]; }\n",
    units=(PART,),
)
OTHER = replace(WHOLE, source=WHOLE.source.replace("2 *", "10 *"))


def forget(monkeypatch):
    """Leave a process as if it had loaded no extension."""
    monkeypatch.setattr(extension, "_loading", extension._Loading())
