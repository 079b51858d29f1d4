"""Names and types of algorithms in C."""

from __future__ import annotations

import re
from functools import cache

from ...ir.loops.types import BOOL, INT, REAL, ArrayType, Scalar
from ..templates import template_text

TYPES = {REAL: "S", INT: "ptrdiff_t", BOOL: "int"}
#: Integers of arrays by the bits in which they are stored.
STORED = {32: "int32_t", 8: "uint8_t"}


def stored_type(type: ArrayType | Scalar) -> str:
    """C type of the numbers of an argument where they lie: of an array, or one number."""
    if isinstance(type, ArrayType):
        return STORED.get(type.bits) or TYPES[type.scalar]
    return "S" if type == REAL else "ptrdiff_t"


def c_name(name: str) -> str:
    """A name of the text: never one that C or instance.h has. Theirs do not end with an underscore."""
    return f"{name}_" if name.isupper() or name in _TAKEN or name.endswith("_") or name.startswith("bs_") else name


#: Words of C and C++, and names that their headers or CUDA give a meaning.
_WORDS = """
alignas alignof and and_eq asm auto bool break case catch char class const continue default delete do double else enum
explicit export extern false float for friend goto if inline int long main mutable namespace nan new not operator or
private protected ptrdiff_t public register restrict return short signed size_t sizeof static struct switch template
this throw true try typedef typename union unsigned using virtual void volatile wchar_t while xor int32_t int64_t
errno linux unix stdin stdout stderr uint8_t uint32_t uint64_t threadIdx blockIdx blockDim gridDim
"""
_TAKEN = frozenset(_WORDS.split())


def is_c_word(name: str) -> bool:
    """Whether a name is a word of C or C++, or one that their headers have."""
    return name in _TAKEN


#: Headers before the functions of an algorithm.
_HEADERS = ("instance.h", "rows.h", "loops.h", "lanes.h", "elementary.h")


def c_function_name(name: str) -> str:
    """A name of an algorithm, to which the instance's tag is added: never one of the headers."""
    return f"{name}_" if name in _library() else c_name(name)


@cache
def _library() -> frozenset[str]:
    """Functions of the headers, without their tags."""
    return frozenset(name for header in _HEADERS for name in re.findall(r"FN\((\w+)\)", template_text(header)))
