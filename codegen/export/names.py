"""Names that a language can have."""

from __future__ import annotations

import re
from collections.abc import Iterator

from ..errors import InputError
from ..targets.c.names import is_c_word
from .unit import Unit

_NAME = re.compile(r"[A-Za-z][A-Za-z0-9]*(_[A-Za-z0-9]+)*")
#: Words that cannot be names, beside those of C and C++.
_WORDS = {
    "rust": """
        as async await become box crate dyn final fn impl in let loop macro match mod move mut override priv pub ref
        self Self super trait type unsafe unsized use where yield f32 f64 main
    """,
    "js": """
        arguments async await debugger eval export extends finally function implements import in instanceof interface
        let null of package super undefined var with yield
    """,
    "glsl": """
        active asm attribute buffer cast centroid common discard dvec2 dvec3 dvec4 external filter fixed flat half highp
        hvec2 hvec3 hvec4 in inout input invariant ivec2 ivec3 ivec4 layout lowp main mat2 mat3 mat4 mediump noinline
        noperspective out output packed partition patch precise precision resource sample sampler1D sampler2D sampler3D
        shared smooth subroutine superp texture uniform unsigned uvec2 uvec3 uvec4 varying vec2 vec3 vec4 writeonly
    """,
}
#: Languages in which functions have the file's name before theirs: there they may be called as a word.
_PREFIXED = ("c99", "glsl")


def check_names(unit: Unit, language: str) -> None:
    """Refuse names that the language cannot have.

    Raises
    ------
    InputError
    """
    words = frozenset(_WORDS.get(language, "").split())
    for what, name, is_prefixed in _names(unit):
        if not _NAME.fullmatch(name):
            raise InputError(
                f"{what} {name!r} cannot be exported.",
                remedy="Use letters of ASCII, digits and single underscores between them.",
            )
        if not (is_prefixed and language in _PREFIXED) and (name in words or is_c_word(name)):
            raise InputError(f"{what} {name!r} is a word of {language}.", remedy="Give it another name (name=...).")


def _names(unit: Unit) -> Iterator[tuple[str, str, bool]]:
    """What it is, the name, and whether the file's name stands before it."""
    yield "the name of the file", unit.name, False
    for struct in unit.structs:
        yield "the kind", struct.name, True
        yield from (("the blade", field, False) for field in struct.fields)
    for entry in unit.entries:
        yield "the function", entry.name, True
        yield from (("the argument", s.name, False) for s in entry.inputs)
        if len(entry.outputs) > 1:
            yield from (("the result", s.name, False) for s in entry.outputs)
        if not entry.is_kernel:
            yield from (("the argument", p.name, False) for p in entry.function.parameters)
