"""The CUDA target: NVRTC compiles all of its text without a word, and the text computes the bits of C.

NVRTC needs no GPU, and its absence is a failure. What would run on a GPU runs here through the C compiler,
thread by thread, behind a stand-in for the driver; the last test runs on a real GPU where there is one.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from bladesmith.codegen.compiler import bind_cuda
from bladesmith.codegen.errors import CompileError, InputError, MissingExtraError, SpecError
from bladesmith.codegen.execute import nvrtc
from bladesmith.codegen.execute.bound_kernels import BoundKernel
from bladesmith.codegen.execute.cuda_driver import CudaKernel, CudaModule, Device, DeviceError, unavailable
from bladesmith.codegen.execute.nvrtc import compile_source, device_arch
from bladesmith.codegen.programs.tracer.scene import EVERYTHING, needs, scene_program
from bladesmith.codegen.targets.cuda.printer import (
    DRIVER_OPTIONS,
    MAIN,
    cuda_source,
    scene_source,
    self_contained,
    with_headers,
)
from bladesmith.codegen.trace.kernel import interface

from ...support import cuda as cuda_support
from ...support.specimens import KERNELS, VARIANTS, arguments, assert_same_bits

pytestmark = pytest.mark.gpu

FILES = cuda_source(list(VARIANTS.values()))
COUNT = 300  # more than two blocks of threads
each_kernel = pytest.mark.parametrize("name", KERNELS)
each_dtype = pytest.mark.parametrize("dtype", [np.float64, np.float32], ids=["f64", "f32"])


# -- the text ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("arch", cuda_support.ARCHITECTURES)
def test_all_kernels_compile_without_a_warning(arch: str) -> None:
    compiled = compile_source(FILES, arch)
    assert compiled.log == ""
    ptx = compiled.image.decode()
    entries = set(re.findall(r"\.entry (\w+)\(", ptx))
    assert entries == {f"{name}_batch_{tag}" for name in KERNELS for tag in ("f64", "f32")}
    assert not re.search(r"\bfma\.", re.sub(r"//.*", "", ptx)), "a product and a sum were contracted"
    assert ".approx" not in ptx and ".ftz" not in ptx, "a root or a quotient is not correctly rounded"


def test_machine_code_comes_out_too() -> None:
    compiled = compile_source(cuda_source([VARIANTS["cga3d_compose"]]), "sm_90")
    assert compiled.image.startswith(b"\x7fELF")


def test_the_self_contained_text_needs_no_header() -> None:
    text = self_contained(cuda_source([VARIANTS["cga3d_elementary"]]))
    assert not re.search(r'#\s*include\s*"', text)
    assert nvrtc.compile_text(text).log == ""


def test_headers_are_found_through_headers() -> None:
    files = with_headers({MAIN: '#include "own.h"\n', "own.h": '  #  include "rows.h"\n'})
    assert set(files) == {MAIN, "own.h", "rows.h"}
    assert "elementary.h" in with_headers(FILES)
    assert "elementary.h" not in with_headers(cuda_source([VARIANTS["cga3d_compose"]]))


def test_refusals_are_clear(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(CompileError, match=r"bad\.cu.*nonsense"):
        nvrtc.compile_text("__global__ void f() { nonsense; }", name="bad.cu")
    with pytest.raises(InputError, match="arch is 'turing'"):
        nvrtc.compile_text("", arch="turing")
    monkeypatch.setattr(nvrtc, "_candidates", lambda: ["/nowhere/libnvrtc.so.12"])
    nvrtc._library.cache_clear()
    try:
        with pytest.raises(MissingExtraError, match=r"bladesmith\[cuda\]"):
            nvrtc.compile_text("")
    finally:
        nvrtc._library.cache_clear()


def test_the_compiler_is_found_in_each_of_nvidias_packages(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Folders of the toolkit's version 12, `nvidia/cuda_nvrtc`, and of 13, `nvidia/cu13`: the newest first."""
    files = [tmp_path / "nvidia" / x for x in ("cu13/lib/libnvrtc.so.13", "cuda_nvrtc/lib/libnvrtc.so.12")]
    for file in (*files, tmp_path / "nvidia/cu13/lib/libnvrtc.alt.so.13"):
        file.parent.mkdir(parents=True, exist_ok=True)
        file.touch()
    monkeypatch.setattr(nvrtc, "find_spec", lambda name: SimpleNamespace(submodule_search_locations=[tmp_path / name]))
    monkeypatch.setattr(nvrtc.sys, "platform", "linux")
    assert nvrtc._candidates()[:2] == [str(file) for file in files]
    monkeypatch.setattr(nvrtc, "find_spec", lambda name: None)
    assert not any(str(tmp_path) in path for path in nvrtc._candidates())


def test_every_gpu_gets_an_architecture_that_the_compiler_knows() -> None:
    known = nvrtc.architectures()
    assert nvrtc.version() >= (12, 2) and 75 in known
    assert device_arch(known[-1]) == f"sm_{known[-1]}"
    assert device_arch(999) == f"compute_{known[-1]}"


@pytest.mark.parametrize("arch", cuda_support.ARCHITECTURES)
def test_the_driver_of_scenes_compiles_without_a_warning(arch: str) -> None:
    files = scene_source(scene_program(EVERYTHING).files)
    compiled = cuda_support.compiled_for_gpus(files, arch, DRIVER_OPTIONS)
    assert compiled.log == ""
    ptx = compiled.image.decode()
    loops = {"first", "all", "render"}
    assert set(re.findall(r"\.entry scene_(\w+)_launch_f(?:32|64)_scalar\(", ptx)) == loops
    assert all(f"hits_evolved_{family}_3_isolate_f64" in ptx for family in ("circles", "point_pairs"))
    assert not re.search(r"\bfma\.|\.approx|\.ftz", re.sub(r"//.*", "", ptx))


def test_a_small_scene_has_small_text() -> None:
    files = scene_source(scene_program(needs(["sphere"], pictures=False)).files)
    compiled = compile_source(files, options=DRIVER_OPTIONS)
    assert compiled.log == "" and b"render" not in compiled.image and b"evolved" not in compiled.image
    with pytest.raises(SpecError, match="bs_source_hash"):
        scene_source({"kernels.c": "int main(void) { return 0; }"})


# -- the text, run -------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def device() -> Device:
    return cuda_support.stand_in_of_kernels("cuda_stand_in", VARIANTS.values())


@each_kernel
@each_dtype
def test_the_text_computes_the_bits_of_c(
    name: str, dtype: Any, compiled_c: Callable[[str], BoundKernel], device: Device
) -> None:
    kernel = CudaKernel(CudaModule(device, b"no image"), name, *interface(KERNELS[name]))
    operands = arguments(KERNELS[name], COUNT, dtype=dtype)
    assert_same_bits(kernel(*operands), compiled_c(name)(*operands), name)
    operands[-1] = operands[-1][:1]
    assert_same_bits(kernel(*operands), compiled_c(name)(*operands), name)


def test_devices_answer_and_nothing_stays_allocated(device: Device) -> None:
    assert (device.name, device.capability) == ("stand-in", 75)
    module = CudaModule(device, b"no image")
    with pytest.raises(DeviceError, match="cuModuleGetFunction: not found"):
        CudaKernel(module, "cga3d_absent", [], [])
    with pytest.raises(DeviceError, match="out of memory"), device.current(), device.memory(1 << 50):
        pass
    device.call("bs_left_open")  # fails unless it returns zero
    with pytest.raises(DeviceError, match="no GPU 3"):
        Device(3, device._library._name)


def test_without_a_driver_the_reason_is_given() -> None:
    assert "/nowhere/libcuda.so.1 is not there" in unavailable("/nowhere/libcuda.so.1")


@pytest.mark.skipif(bool(unavailable()), reason=f"no GPU to run on: {unavailable()}")
@each_kernel
@each_dtype
def test_a_gpu_computes_the_bits_of_c(name: str, dtype: Any, compiled_c: Callable[[str], BoundKernel]) -> None:
    operands = arguments(KERNELS[name], COUNT, dtype=dtype)
    assert_same_bits(bind_cuda(VARIANTS[name])(*operands), compiled_c(name)(*operands), name)
