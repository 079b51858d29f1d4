"""CUDA: the kernel bodies of the C target as device functions, and a launcher around each.

One text serves both precisions. It includes headers of templates/c, which are found by name when it is
compiled or made self-contained.
"""

from __future__ import annotations

import base64
import hashlib
import json
import re
from collections.abc import Mapping, Sequence

from .. import texts as kept_texts
from ..errors import SpecError
from ..simplify import chosen_form
from ..templating import render, template_text
from ..trace import Kernel
from .c import c_function, symbol
from .cuda_run import CudaKernel, CudaModule, Device
from .extension import in_dependency_order
from .nvrtc import DEFAULT_ARCH, OPTIONS, Compiled, architectures, compile_text, version
from .printer import interface

#: The file that is compiled; the others are included by it.
MAIN = "kernels.cu"
#: For drivers: their loops are written for C, and carry no words of CUDA.
DRIVER_OPTIONS = ("--device-as-default-execution-space",)
#: In programs, the first line of the functions that the host calls, which a GPU has no use for.
_HOST_PART = "const char *bs_source_hash(void)"
_DIGITS = 24
_INCLUDE = re.compile(r'^[ \t]*#[ \t]*include[ \t]+"([\w.]+)"[^\n]*$', re.MULTILINE)


def cuda_source(kernels: Sequence[Kernel], title: str = "") -> dict[str, str]:
    """Generated files: the main one, the bodies, and the launchers ``<symbol>_batch_f64`` and ``_f32``.

    Parameters
    ----------
    kernels : sequence of Kernel
    title : str, optional
        First words of the main file's comment; default: the algebra's name.
    """
    functions = [c_function(chosen_form(k)) for k in in_dependency_order(kernels)]
    values = {
        "title": title or (kernels[0].algebra.name if kernels else "kernels"),
        "functions": functions,
        "batched": [symbol(k) for k in kernels],
        "count": len(kernels),
        "elementary": any(f.elementary for f in functions),
    }
    return {
        MAIN: render("cuda/kernels.cu.j2", **values),
        "kernels.h": render("c/kernels.h.j2", **values),
        "launch.h": render("cuda/launch.h.j2", **values),
    }


def scene_source(files: Mapping[str, str]) -> dict[str, str]:
    """A scene's compiled program as CUDA text: the same driver, with launchers in place of what Python calls.

    Parameters
    ----------
    files : mapping
        File name to text, as in ``scene_program(...).files``. Compile the result with `DRIVER_OPTIONS`.
    """
    driver = _device_part(files)
    tags = re.findall(r"^#define BS_TAG (\w+)$", driver, re.MULTILINE)
    return _launched(files, "cuda/scene.cu.j2", driver=driver, tags=tags)


def reform_source(files: Mapping[str, str]) -> dict[str, str]:
    """A registration's compiled program as CUDA text: the same driver, with a launcher for each stage.

    Parameters
    ----------
    files : mapping
        File name to text, as in ``reform_program(...).files``. Compile the result with `DRIVER_OPTIONS`.
    """
    return _launched(files, "cuda/reform.cu.j2", driver=_device_part(files))


def _device_part(files: Mapping[str, str]) -> str:
    """The driver without what Python calls."""
    driver, found, _ = files["kernels.c"].partition(_HOST_PART)
    if not found:
        raise SpecError(f"this program's kernels.c does not have the line {_HOST_PART!r} after its driver.")
    return driver.rstrip() + "\n"


def _launched(files: Mapping[str, str], template: str, **values: object) -> dict[str, str]:
    """The launchers around a driver, and the driver's own headers."""
    own = {name: text for name, text in files.items() if name != "kernels.c"}
    return {MAIN: render(template, **values), **own}


def with_headers(files: Mapping[str, str]) -> dict[str, str]:
    """The files and every header of templates/c that they include, directly or not."""
    found = dict(files)
    waiting = list(found.values())
    while waiting:
        for name in _INCLUDE.findall(waiting.pop()):
            if name not in found:
                found[name] = template_text(f"c/{name}")
                waiting.append(found[name])
    return found


def self_contained(files: Mapping[str, str]) -> str:
    """One text without includes of ours: for nvcc, or for other packages that compile CUDA."""
    texts = with_headers(files)

    def expanded(text: str) -> str:
        return _INCLUDE.sub(lambda found: expanded(texts[found[1]]).rstrip(), text)

    return expanded(texts[MAIN])


def compile_source(
    files: Mapping[str, str], arch: str = DEFAULT_ARCH, options: Sequence[str] = ()
) -> Compiled:
    """Compile generated files with NVRTC; see `nvrtc.compile_text`.

    Raises
    ------
    MissingExtraError
        If NVRTC is not installed.
    CompileError
        If it refuses the source.
    """
    texts = with_headers(files)
    return compile_text(texts.pop(MAIN), texts, MAIN, arch, options)


def compile_kept(files: Mapping[str, str], arch: str, options: Sequence[str] = ()) -> bytes:
    """The image of generated files, from the cache or compiled now; see `compile_source`."""
    sources = with_headers(files)
    parts = [sorted(sources.items()), arch, [*OPTIONS, *options], version()]
    name = hashlib.sha256(json.dumps(parts).encode()).hexdigest()[:_DIGITS]
    found = kept_texts.read(f"cuda_{name}", f"{arch}.txt")
    if found is None:
        image = compile_source(files, arch, options).image
        kept_texts.write(f"cuda_{name}", {f"{arch}.txt": base64.b64encode(image).decode()})
        return image
    kept_texts.touch(f"cuda_{name}")
    return base64.b64decode(found)


def device_arch(capability: int) -> str:
    """The arch to compile for on a GPU of this capability: machine code, or PTX where NVRTC is older."""
    known = architectures()
    return f"sm_{capability}" if capability in known else f"compute_{max(a for a in known if a < capability)}"


def bind(kernel: Kernel, device: Device | None = None) -> CudaKernel:
    """A kernel as a function of arrays, compiled for a GPU of this machine.

    Parameters
    ----------
    kernel : Kernel
    device : Device, optional
        Default: the first GPU.

    Raises
    ------
    MissingExtraError
        If NVRTC is not installed.
    DeviceError
        If there is no GPU.
    """
    device = device or Device()
    compiled = compile_source(cuda_source([kernel]), device_arch(device.capability))
    return CudaKernel(CudaModule(device, compiled.image), symbol(kernel), *interface(kernel))
