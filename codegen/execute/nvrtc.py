"""NVIDIA's run-time compiler as a library: CUDA text in, PTX or machine code out. No GPU is needed.

The library comes with the package nvidia-cuda-nvrtc-cu12 (the extra "cuda"); a CUDA toolkit's one serves too.
Headers are handed over in memory. Generated files are compiled through the cache.
"""

from __future__ import annotations

import base64
import ctypes
import ctypes.util
import hashlib
import json
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib.util import find_spec
from pathlib import Path

from ..build import text_cache
from ..errors import CompileError, InputError, MissingExtraError
from ..targets.cuda.printer import MAIN, with_headers

#: Turing: the oldest architecture that current compilers serve. Its PTX runs on every later GPU.
DEFAULT_ARCH = "compute_75"
#: Nothing contracted, IEEE division and roots, subnormal numbers kept: the bits of the C target.
OPTIONS = ("--std=c++17", "--fmad=false", "--prec-div=true", "--prec-sqrt=true", "--ftz=false")
_ERROR_LINES = 3
#: Digits of the digest in the name of an entry of the cache.
_DIGITS = 24


@dataclass(frozen=True)
class CompiledText:
    """Output of the compiler.

    Attributes
    ----------
    image : bytes
        PTX text for an arch "compute_..", machine code (cubin) for "sm_..".
    log : str
        Its warnings; empty when there was nothing to say.
    arch : str
    """

    image: bytes
    log: str
    arch: str


def compile_text(
    source: str,
    headers: Mapping[str, str] | None = None,
    name: str = "kernels.cu",
    arch: str = DEFAULT_ARCH,
    options: Sequence[str] = (),
) -> CompiledText:
    """Compile one CUDA text.

    Parameters
    ----------
    source : str
    headers : mapping, optional
        File name to text of what ``source`` includes.
    name : str
        File name in messages.
    arch : str
        "compute_75" for PTX, "sm_75" for machine code, and so on.
    options : sequence of str
        More options, after `OPTIONS`.

    Raises
    ------
    MissingExtraError
        If the library is not installed.
    CompileError
        If the compiler refuses the source; the message holds its first errors.
    InputError
        If ``arch`` is not the name of an architecture.
    """
    prefix, _, number = arch.partition("_")
    if prefix not in ("compute", "sm") or not number.rstrip("af").isdigit():
        raise InputError(f"arch is {arch!r}; it is compute_<number> for PTX or sm_<number> for machine code.")
    library = _library()
    texts = dict(headers or {})
    program = ctypes.c_void_p()
    _check(
        library.nvrtcCreateProgram(
            ctypes.byref(program),
            source.encode(),
            name.encode(),
            len(texts),
            _strings(list(texts.values())),
            _strings(list(texts)),
        )
    )
    try:
        arguments = [f"--gpu-architecture={arch}", *OPTIONS, *options]
        status = library.nvrtcCompileProgram(program, len(arguments), _strings(arguments))
        log = _text(program, "ProgramLog")
        if status:
            lines = [line for line in log.splitlines() if "error" in line] or [_message(status)]
            raise CompileError(" | ".join(lines[:_ERROR_LINES]), where=name)
        return CompiledText(_bytes(program, "PTX" if prefix == "compute" else "CUBIN"), log.strip(), arch)
    finally:
        library.nvrtcDestroyProgram(ctypes.byref(program))


def version() -> tuple[int, int]:
    """Version of the library.

    Raises
    ------
    MissingExtraError
        If it is not installed.
    """
    major, minor = ctypes.c_int(), ctypes.c_int()
    _check(_library().nvrtcVersion(ctypes.byref(major), ctypes.byref(minor)))
    return major.value, minor.value


def architectures() -> tuple[int, ...]:
    """Numbers of the architectures that the library compiles for, ascending."""
    count = ctypes.c_int()
    _check(_library().nvrtcGetNumSupportedArchs(ctypes.byref(count)))
    numbers = (ctypes.c_int * count.value)()
    _check(_library().nvrtcGetSupportedArchs(numbers))
    return tuple(sorted(numbers))


@cache
def _library() -> ctypes.CDLL:
    for path in _candidates():
        try:
            return ctypes.CDLL(path)
        except OSError:  # another system's, or a toolkit that was half removed: the next may do
            continue
    raise MissingExtraError("cuda", "Compiling CUDA kernels")


def _candidates() -> list[str]:
    """Files of NVIDIA's packages (`cuda_nvrtc`, since version 13 `cu13`), newest first, then what the loader knows."""
    pattern = "*/bin/nvrtc64_*.dll" if sys.platform == "win32" else "*/lib/libnvrtc.so.*"
    spec = find_spec("nvidia")
    folders = list(spec.submodule_search_locations or []) if spec else []
    files = [path for folder in folders for path in Path(folder).glob(pattern) if ".alt." not in path.name]
    found = [str(path) for path in sorted(files, key=lambda path: path.name, reverse=True)]
    system = ctypes.util.find_library("nvrtc")
    return found + ([system] if system else [])


def _strings(texts: Sequence[str]) -> ctypes.Array[ctypes.c_char_p]:
    return (ctypes.c_char_p * len(texts))(*(text.encode() for text in texts))


def _bytes(program: ctypes.c_void_p, what: str) -> bytes:
    size = ctypes.c_size_t()
    _check(getattr(_library(), f"nvrtcGet{what}Size")(program, ctypes.byref(size)))
    buffer = ctypes.create_string_buffer(max(size.value, 1))
    _check(getattr(_library(), f"nvrtcGet{what}")(program, buffer))
    return buffer.raw[: size.value]


def _text(program: ctypes.c_void_p, what: str) -> str:
    return _bytes(program, what).rstrip(b"\0").decode(errors="replace")


def _message(status: int) -> str:
    describe = _library().nvrtcGetErrorString
    describe.restype = ctypes.c_char_p
    return str((describe(status) or b"unknown error").decode())


def _check(status: int) -> None:
    if status:
        raise CompileError(_message(status), where="NVRTC")


def compile_source(files: Mapping[str, str], arch: str = DEFAULT_ARCH, options: Sequence[str] = ()) -> CompiledText:
    """Compile generated files with NVRTC; see `compile_text`.

    Raises
    ------
    MissingExtraError
        If NVRTC is not installed.
    CompileError
        If it refuses the source.
    """
    texts = with_headers(files)
    return compile_text(texts.pop(MAIN), texts, MAIN, arch, options)


def compile_cached(files: Mapping[str, str], arch: str, options: Sequence[str] = ()) -> bytes:
    """The image of generated files, from the cache or compiled now; see `compile_source`."""
    sources = with_headers(files)
    parts = [sorted(sources.items()), arch, [*OPTIONS, *options], version()]
    name = hashlib.sha256(json.dumps(parts).encode()).hexdigest()[:_DIGITS]
    text = text_cache.read(f"cuda_{name}", f"{arch}.txt")
    if text is None:
        image = compile_source(files, arch, options).image
        text_cache.write(f"cuda_{name}", {f"{arch}.txt": base64.b64encode(image).decode()})
        return image
    text_cache.touch(f"cuda_{name}")
    return base64.b64decode(text)


def device_arch(capability: int) -> str:
    """The arch to compile for on a GPU of this capability: machine code, or PTX where NVRTC is older."""
    supported = architectures()
    return f"sm_{capability}" if capability in supported else f"compute_{max(a for a in supported if a < capability)}"
