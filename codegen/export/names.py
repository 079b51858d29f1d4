"""Names that a language can have."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from functools import cache

from ..errors import InputError
from ..targets.c.names import is_c_word
from .places import result_of
from .unit import Unit

_NAME = re.compile(r"[A-Za-z][A-Za-z0-9]*(_[A-Za-z0-9]+)*")
_INNER_NAME = re.compile(f"{_NAME.pattern}_?")
#: What has a name that others begin or end with.
_OUTER = ("the name", "the kind", "the function")
#: Words that cannot be names, beside those of C and C++.
_WORDS = {
    "cpp": """
        bitand bitor char8_t char16_t char32_t co_await co_return co_yield compl concept consteval constexpr constinit
        const_cast decltype dynamic_cast final import module noexcept not_eq nullptr or_eq override reinterpret_cast
        requires static_assert static_cast thread_local typeid xor_eq std main
        HUGE_VAL HUGE_VALF HUGE_VALL INFINITY M_1_PI M_2_PI M_2_SQRTPI M_E M_LN10 M_LN2 M_LOG10E M_LOG2E M_PI M_PI_2
        M_PI_4 M_SQRT1_2 M_SQRT2 NAN NULL
    """,
    "rust": """
        abstract as async await become box break const continue crate do dyn else enum extern false final fn for gen if
        impl in let loop macro match mod move mut override priv pub ref return self Self static struct super trait true
        try type typeof unsafe unsized use virtual where while yield
    """,
    "js": """
        arguments await break case catch class const continue debugger default delete do else enum eval export extends
        false finally for function if implements import in instanceof interface let new null package private protected
        public return static super switch this throw true try typeof undefined var void while with yield
    """,
    "glsl": """
        active asm atomic_uint attribute buffer bvec2 bvec3 bvec4 cast centroid coherent common demote discard dmat2
        dmat3 dmat4 dvec2 dvec3 dvec4 external filter fixed flat half highp hvec2 hvec3 hvec4 image1D image2D image3D
        imageBuffer imageCube in inout input invariant isampler2D isampler3D isamplerCube ivec2 ivec3 ivec4 layout lowp
        main mat2 mat2x2 mat2x3 mat2x4 mat3 mat3x2 mat3x3 mat3x4 mat4 mat4x2 mat4x3 mat4x4 mediump noinline
        noperspective out output packed partition patch precise precision readonly resource sample sampler1D sampler2D
        sampler2DRect sampler2DShadow sampler3D sampler3DRect samplerBuffer samplerCube samplerCubeShadow shared smooth
        subroutine superp texture uint uniform usampler2D usampler3D usamplerCube uvec2 uvec3 uvec4 varying vec2 vec3
        vec4 writeonly
    """,
}
#: Names that a file cannot have, beside words: in C++ a namespace would hide what headers declare, in Rust crates have
#: files of these names.
_TAKEN_FILES = {
    "cpp": """
        abort abs acos acosh asin asinh atan atan2 atanh atof atoi atol calloc cbrt ceil copysign cos cosh div drand48
        drem erf erfc exit exp exp2 expm1 fabs fdim ffs finite floor fma fmax fmin fmod free frexp gamma getenv hypot
        ilogb index j0 j1 jn labs ldexp ldiv lgamma llabs lldiv log log10 log1p log2 logb lrand48 lrint lround malloc
        memchr memcmp memcpy memmove memset modf mrand48 nearbyint nextafter nexttoward pow qsort rand random realloc
        remainder remquo rindex rint round scalbln scalbn select signgam significand sin sinh sqrt srand srandom
        strcat strchr strcmp strcpy strlen strstr strtod strtol system tan tanh tgamma trunc y0 y1 yn
    """,
    "rust": "lib main",
}
#: Languages in which functions have the file's name before theirs: there they may be called as a word.
_PREFIXED = ("c99", "glsl")
#: Languages in which arguments and results get an underscore where they are called as a word.
_RENAMED = ("glsl",)
#: Names of the files' own functions, where types and functions have one space of names.
_HELPERS = ("quotient", "remainder", "min", "max", "imin", "imax", "iabs")
_OWN = {
    "c99": _HELPERS, "glsl": _HELPERS, "cpp": ("detail", "T"),
    "js": ("BigInt", "BigInt64Array", "Float64Array", "Infinity", "Math", "NaN", "Number", "Object", "RangeError",
           "Uint16Array", "Uint32Array", "Uint8Array"),
}  # fmt: skip
#: Languages whose words are not those of C besides.
_UNLIKE_C = ("rust", "js")


@cache
def language_words(language: str) -> frozenset[str]:
    """Words that cannot be names, beside those of C and C++ that `targets.c.names` has."""
    return frozenset(_WORDS.get(language, "").split())


def camel_case(name: str) -> str:
    """``motor_any`` as ``MotorAny``."""
    return "".join(part[:1].upper() + part[1:] for part in name.split("_"))


def lower_camel_case(name: str) -> str:
    """``motor_any`` as ``motorAny``."""
    first, *rest = name.split("_")
    return first + camel_case("_".join(rest))


#: How a language writes types and other names, where not as they are.
_SPELLED: dict[str, tuple[Callable[[str], str], Callable[[str], str]]] = {
    "cpp": (camel_case, str), "rust": (camel_case, str), "js": (camel_case, lower_camel_case),
}  # fmt: skip


def _remedy(what: str) -> str:
    if what == "the function":
        return 'Declare it with another name: @codegen.kernel(..., name="another_name").'
    return "Export it with another name (name=...)." if what == "the name of the file" else "Rename it."


def check_names(unit: Unit, language: str) -> None:
    """Refuse names that the language cannot have.

    Raises
    ------
    InputError
    """
    words = language_words(language)
    if unit.name in _TAKEN_FILES.get(language, "").split() or (language == "glsl" and unit.name.startswith("gl_")):
        raise InputError(
            f"a file of {language} cannot be called {unit.name!r}: that is a name of its library.",
            remedy=_remedy("the name of the file"),
        )
    for what, name, is_prefixed in _names(unit):
        if not (_NAME if what.startswith(_OUTER) else _INNER_NAME).fullmatch(name):
            raise InputError(
                f"{what} {name!r} cannot be exported.",
                remedy="Use letters of ASCII, digits and single underscores between them.",
            )
        is_kept = what.startswith((*_OUTER, "the blade"))
        is_safe = language in (_PREFIXED if is_prefixed else () if is_kept else _RENAMED)
        if not is_safe and (name in words or (language not in _UNLIKE_C and is_c_word(name))):
            raise InputError(f"{what} {name!r} is a word of {language}.", remedy=_remedy(what))
    if twice := [s.name for s in unit.structs if len({*s.fields}) < len(s.fields)]:
        raise InputError(
            f"the kind {twice[0]!r} has a vector 's', as the scalar is called there.",
            remedy="Name the vector otherwise.",
        )
    types, others = _SPELLED.get(language, (str, str))
    results = [f"{e.name}_result" for e in unit.entries if e.is_kernel and not result_of(e).slot]
    _check_different([*(s.name for s in unit.structs), *results], types, "kinds or results")
    _check_different([e.name for e in unit.entries], others, "functions")
    if language in _OWN:
        kinds = {*(types(s.name) for s in unit.structs), *map(types, results)}
        if hidden := kinds.intersection(_OWN[language]):
            raise InputError(f"a kind would be called {min(hidden)}, which is taken there.", remedy="Rename it.")
        taken = {*_OWN[language], *(() if language == "js" else kinds)}
        for name in (e.name for e in unit.entries):
            if name in taken or (language in _PREFIXED and name.startswith("math_")):
                raise InputError(f"the name of the function {name!r} is taken there.", remedy="Give it another name.")
    for entry in unit.entries:
        own = entry.inputs if entry.is_kernel else entry.function.parameters
        _check_different([p.name for p in own], others, "arguments")
        _check_different([s.name for s in entry.outputs], others, "results")


def _check_different(names: Sequence[str], spelled: Callable[[str], str], what: str) -> None:
    found: dict[str, str] = {}
    for name in names:
        if spelled(name) in found:
            raise InputError(
                f"the {what} {found[spelled(name)]!r} and {name!r} are both {spelled(name)} there.",
                remedy="Declare one of them with another name.",
            )
        found[spelled(name)] = name


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
