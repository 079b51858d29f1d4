"""The CUDA target: NVRTC compiles all of its text without a word, and the text computes the bits of C.

NVRTC needs no GPU, and its absence is a failure. What would run on a GPU runs here through the C compiler,
thread by thread, behind a stand-in for the driver; the last test runs on a real GPU where there is one.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from bladesmith.codegen.binding import BoundKernel, Library
from bladesmith.codegen.build import ExtensionSource
from bladesmith.codegen.build import load as load_extension
from bladesmith.codegen.errors import CompileError, InputError, MissingExtraError, SpecError
from bladesmith.codegen.machine import instances
from bladesmith.codegen.programs.scene import EVERYTHING, needs, scene_program
from bladesmith.codegen.targets import nvrtc
from bladesmith.codegen.targets.cuda import (
    DRIVER_OPTIONS,
    MAIN,
    bind,
    compile_source,
    cuda_source,
    device_arch,
    scene_source,
    self_contained,
    with_headers,
)
from bladesmith.codegen.targets.cuda_run import CudaKernel, CudaModule, Device, DeviceError, unavailable
from bladesmith.codegen.targets.extension import extension_source
from bladesmith.codegen.targets.printer import interface
from bladesmith.codegen.targets.specimens import arguments, specimens
from bladesmith.codegen.trace import Kernel

KERNELS = specimens()
FILES = cuda_source(list(KERNELS.values()))
COUNT = 300  # more than two blocks of threads
each_kernel = pytest.mark.parametrize("name", KERNELS)
each_dtype = pytest.mark.parametrize("dtype", [np.float64, np.float32], ids=["f64", "f32"])


@pytest.fixture(scope="module")
def compiled_c() -> Callable[[str], BoundKernel]:
    """The same kernels through the C target."""
    extension = extension_source("specimens", list(KERNELS.values()), (*instances("f64"), *instances("f32")))
    library = Library(load_extension(extension))
    return lambda name: BoundKernel(library, name, *interface(KERNELS[name]))


# -- the text ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("arch", ["compute_75", "compute_90"])
def test_all_kernels_compile_without_a_warning(arch: str) -> None:
    compiled = compile_source(FILES, arch)
    assert compiled.log == ""
    ptx = compiled.image.decode()
    entries = set(re.findall(r"\.entry (\w+)\(", ptx))
    assert entries == {f"{name}_batch_{tag}" for name in KERNELS for tag in ("f64", "f32")}
    assert not re.search(r"\bfma\.", re.sub(r"//.*", "", ptx)), "a product and a sum were contracted"
    assert ".approx" not in ptx and ".ftz" not in ptx, "a root or a quotient is not correctly rounded"


def test_machine_code_comes_out_too() -> None:
    compiled = compile_source(cuda_source([KERNELS["cga3d_compose"]]), "sm_90")
    assert compiled.image.startswith(b"\x7fELF")


def test_the_self_contained_text_needs_no_header() -> None:
    text = self_contained(cuda_source([KERNELS["cga3d_elementary"]]))
    assert not re.search(r'#\s*include\s*"', text)
    assert nvrtc.compile_text(text).log == ""


def test_headers_are_found_through_headers() -> None:
    files = with_headers({MAIN: '#include "own.h"\n', "own.h": '  #  include "rows.h"\n'})
    assert set(files) == {MAIN, "own.h", "rows.h"}
    assert "elementary.h" in with_headers(FILES)
    assert "elementary.h" not in with_headers(cuda_source([KERNELS["cga3d_compose"]]))


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


def test_every_gpu_gets_an_architecture_that_the_compiler_knows() -> None:
    known = nvrtc.architectures()
    assert nvrtc.version() >= (12, 2) and 75 in known
    assert device_arch(known[-1]) == f"sm_{known[-1]}"
    assert device_arch(999) == f"compute_{known[-1]}"


@pytest.mark.parametrize("arch", ["compute_75", "compute_90"])
def test_the_driver_of_scenes_compiles_without_a_warning(arch: str) -> None:
    compiled = compile_source(scene_source(scene_program(EVERYTHING).files), arch, DRIVER_OPTIONS)
    assert compiled.log == ""
    ptx = compiled.image.decode()
    loops = {"first", "all", "render"}
    assert set(re.findall(r"\.entry scene_(\w+)_launch_f(?:32|64)_scalar\(", ptx)) == loops
    assert not re.search(r"\bfma\.|\.approx|\.ftz", re.sub(r"//.*", "", ptx))


def test_a_small_scene_has_small_text() -> None:
    files = scene_source(scene_program(needs(["sphere"], pictures=False)).files)
    compiled = compile_source(files, options=DRIVER_OPTIONS)
    assert compiled.log == "" and b"render" not in compiled.image and b"evolved" not in compiled.image
    with pytest.raises(SpecError, match="bs_source_hash"):
        scene_source({"kernels.c": "int main(void) { return 0; }"})


# -- the text, run -------------------------------------------------------------------------------------

#: CUDA's words for the C compiler: a thread is a call, its place in the grid a global.
WORDS = """
#include <string.h>
#define __CUDACC__ 1
#define __device__
#define __global__
#define __noinline__
#define __forceinline__ inline __attribute__((always_inline, unused))
typedef struct { unsigned x, y, z; } bs_place;
static bs_place blockIdx, threadIdx, blockDim, gridDim;
#define BS_SAME_BITS(name, from, to) \\
  static inline to name(from a) { to b; memcpy(&b, &a, sizeof b); return b; }
BS_SAME_BITS(__double_as_longlong, double, long long)
BS_SAME_BITS(__longlong_as_double, long long, double)
BS_SAME_BITS(__float_as_int, float, int)
BS_SAME_BITS(__int_as_float, int, float)
"""

#: The part of the driver's interface that cuda_run uses. Device memory is the host's.
DRIVER = """
typedef unsigned long long bs_pointer;
typedef struct { const char *name; void (*run)(void **); } bs_entry;
static const bs_entry bs_entries[] = {@ENTRIES@};
static int bs_contexts, bs_pieces;
int bs_left_open(void) { return bs_contexts + bs_pieces; }
int cuInit(unsigned flags) { return flags; }
int cuDeviceGetCount(int *count) { *count = 1; return 0; }
int cuDeviceGet(int *device, int index) { *device = index; return 0; }
int cuDeviceGetName(char *name, int size, int device)
{
  strncpy(name, "stand-in", (size_t)size);
  return device;
}
int cuDeviceGetAttribute(int *value, int which, int device) { *value = which == 75 ? 7 : 5; return device; }
int cuDevicePrimaryCtxRetain(void **context, int device) { *context = &bs_contexts; return device; }
int cuCtxPushCurrent_v2(void *context) { bs_contexts++; return context != &bs_contexts; }
int cuCtxPopCurrent_v2(void **context) { bs_contexts--; *context = &bs_contexts; return 0; }
int cuCtxSynchronize(void) { return 0; }
int cuModuleLoadData(void **module, const void *image) { *module = (void *)image; return image == NULL; }
int cuModuleGetFunction(void **function, void *module, const char *name)
{
  for (size_t i = 0; i < sizeof bs_entries / sizeof bs_entries[0]; i++)
    if (!strcmp(bs_entries[i].name, name)) { *function = (void *)&bs_entries[i]; return module == NULL; }
  return 500;
}
int cuMemAlloc_v2(bs_pointer *place, size_t size)
{
  if (size >> 40) return 2;
  bs_pieces++;
  *place = (bs_pointer)malloc(size);
  return 0;
}
int cuMemFree_v2(bs_pointer place) { bs_pieces--; free((void *)place); return 0; }
int cuMemcpyHtoD_v2(bs_pointer to, const void *from, size_t size)
{
  memcpy((void *)to, from, size);
  return 0;
}
int cuMemcpyDtoH_v2(void *to, bs_pointer from, size_t size)
{
  memcpy(to, (const void *)from, size);
  return 0;
}
int cuGetErrorString(int status, const char **text)
{
  *text = status == 2 ? "out of memory" : "not found";
  return 0;
}
int cuLaunchKernel(void *function, unsigned gx, unsigned gy, unsigned gz, unsigned bx, unsigned by,
    unsigned bz, unsigned shared, void *stream, void **arguments, void **extra)
{
  if (gy != 1 || gz != 1 || by != 1 || bz != 1 || shared || stream || extra) return 1;
  gridDim.x = gx, blockDim.x = bx;
  for (blockIdx.x = 0; blockIdx.x < gx; blockIdx.x++)
    for (threadIdx.x = 0; threadIdx.x < bx; threadIdx.x++)
      ((const bs_entry *)function)->run(arguments);
  return 0;
}
"""


def stand_in(kernels: list[Kernel]) -> str:
    """Path of a library that looks like the driver and runs the kernels' CUDA text thread by thread."""
    calls, entries = [], []
    for kernel in kernels:
        inputs, outputs = interface(kernel)
        for tag, scalar in (("f64", "double"), ("f32", "float")):
            types = ["long long", "long long"]
            types += ["unsigned char *" if o.is_status else f"{scalar} *" for o in outputs]
            types += [f"const {scalar} *", "long long"] * len(inputs)
            name = f"{kernel.algebra.name}_{kernel.name}_batch_{tag}"
            passed = ", ".join(f"*({t} *)p[{i}]" for i, t in enumerate(types))
            calls.append(f"static void run_{name}(void **p) {{ {name}({passed}); }}")
            entries.append(f'{{"{name}", run_{name}}}')
    text = self_contained(cuda_source(kernels)).replace('extern "C" ', "static ")
    driver = DRIVER.replace("@ENTRIES@", ", ".join(entries))
    source = "\n".join(["#include <stdlib.h>", WORDS, text, *calls, driver])
    return str(load_extension(ExtensionSource("cuda_stand_in", "int bs_left_open(void);", source)).__file__)


@pytest.fixture(scope="module")
def device() -> Device:
    return Device(driver=stand_in(list(KERNELS.values())))


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
def test_a_gpu_computes_the_bits_of_c(
    name: str, dtype: Any, compiled_c: Callable[[str], BoundKernel]
) -> None:
    operands = arguments(KERNELS[name], COUNT, dtype=dtype)
    assert_same_bits(bind(KERNELS[name])(*operands), compiled_c(name)(*operands), name)


def assert_same_bits(actual: Any, expected: Any, name: str) -> None:
    """Equal as integers; a NaN equals any NaN, since no rule fixes its bits."""
    pairs = zip(*(r if isinstance(r, tuple) else (r,) for r in (actual, expected)), strict=True)
    for a, b in pairs:
        assert a.dtype == b.dtype and a.shape == b.shape
        bits = np.dtype(f"u{a.dtype.itemsize}")
        different = (a.view(bits) != b.view(bits)) & ~(np.isnan(a) & np.isnan(b))
        assert not different.any(), f"{name}: {a[different][:3]} instead of {b[different][:3]}"
