"""A stand-in for a GPU: CUDA's words for the C compiler, and a library that looks like the GPU's driver.

Its device memory is the host's, and a launch runs its threads one after the other.
"""

from __future__ import annotations

import hashlib
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager

import pytest

from bladesmith.codegen.build.extension import load as load_extension
from bladesmith.codegen.execute import cuda_driver, cuda_items
from bladesmith.codegen.execute.cuda_driver import CudaModule, Device, unavailable
from bladesmith.codegen.execute.nvrtc import DEFAULT_ARCH, CompiledText, compile_source, version
from bladesmith.codegen.optimise.variants import Variant
from bladesmith.codegen.targets.c.printer import symbol
from bladesmith.codegen.targets.c.source import ExtensionSource
from bladesmith.codegen.targets.cuda.printer import DRIVER_OPTIONS, cuda_source, self_contained
from bladesmith.codegen.trace.kernel import interface

from .effort import FULL

#: What texts are compiled for: the warnings are those of the compiler's front end, and so of all.
ARCHITECTURES = ("compute_75", "compute_90") if FULL else ("compute_75",)

#: The version of NVRTC that can leave out its optimiser.
FIRST_QUICK = (12, 9)

#: CUDA's words for the C compiler: a thread is a call, its place in the grid a global.
WORDS = """
#include <string.h>
#define __CUDACC__ 1
#define __device__
#define __global__
#define __noinline__
#define __grid_constant__
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


def stand_in(name: str, text: str, launchers: Mapping[str, Sequence[str]]) -> str:
    """Path of a library that has the driver's functions and these launchers.

    Parameters
    ----------
    name : str
        An identifier.
    text : str
        Self-contained CUDA text.
    launchers : mapping of str to sequence of str
        C types of the arguments of each.
    """
    calls, entries = [], []
    for launcher, types in launchers.items():
        passed = ", ".join(f"*({t} *)p[{i}]" for i, t in enumerate(types))
        calls.append(f"static void run_{launcher}(void **p) {{ {launcher}({passed}); }}")
        entries.append(f'{{"{launcher}", run_{launcher}}}')
    driver = DRIVER.replace("@ENTRIES@", ", ".join(entries))
    own = text.replace('extern "C" ', "static ")
    source = "\n".join(["#include <stddef.h>", "#include <stdlib.h>", WORDS, own, *calls, driver])
    level = "-O1" if FULL else "-O0"
    return str(load_extension(ExtensionSource(name, "int bs_left_open(void);", source, options=(level,))).__file__)


def stand_in_of_kernels(name: str, variants: Iterable[Variant]) -> Device:
    """A device that runs the launchers of some kernels' text, thread by thread."""
    chosen = list(variants)
    launchers = {}
    for variant in chosen:
        inputs, outputs = interface(variant.kernel)
        for tag, scalar in (("f64", "double"), ("f32", "float")):
            types = ["long long", "long long"]
            types += ["unsigned char *" if o.is_status else f"{scalar} *" for o in outputs]
            types += [f"const {scalar} *", "long long"] * len(inputs)
            launchers[f"{symbol(variant.kernel)}_batch_{tag}"] = types
    return Device(driver=stand_in(name, self_contained(cuda_source(chosen)), launchers))


def stand_in_of_loops(name: str, files: Mapping[str, str]) -> Device:
    """A device that runs the launchers of some text's loops, thread by thread."""
    launchers = {}
    for head in re.finditer(r"\b(\w*launch_\w+)\((long long begin, long long end,[^)]*)\)", files["kernels.cu"]):
        arguments = re.sub(r"\bconst\b|\b__grid_constant__\b", "", head[2]).split(",")
        launchers[head[1]] = [" ".join(argument.split()[:-1]) for argument in arguments]
    return Device(driver=stand_in(name, self_contained(files), launchers))


#: Where a test runs the text for GPUs: through the C compiler, and on a GPU.
STAND_IN, GPU = "stand-in", "GPU"
each_device = pytest.mark.parametrize(
    "where",
    [
        STAND_IN,
        pytest.param(GPU, marks=pytest.mark.skipif(bool(unavailable()), reason=f"no GPU to run on: {unavailable()}")),
    ],
)


@contextmanager
def devices(where: str) -> Iterator[list[Device]]:
    """Devices that algorithms are compiled for, one for each of their programs: a stand-in of its own, or the GPU."""
    used: list[Device] = []
    compile_loops = cuda_items.compile_loops

    def stood_in(_: object, source: Mapping[str, str]) -> CudaModule:
        digest = hashlib.sha256(self_contained(source).encode()).hexdigest()[:12]
        used.append(stand_in_of_loops(f"stand_in_{digest}", source))
        return CudaModule(used[-1], b"no image")

    def counted(device: Device, source: Mapping[str, str]) -> CudaModule:
        used.append(device)
        return compile_loops(device, source)

    with pytest.MonkeyPatch.context() as patch:
        if where == STAND_IN:
            patch.setattr(cuda_driver, "first_gpu", lambda: None)
        patch.setattr(cuda_items, "compile_loops", stood_in if where == STAND_IN else counted)
        yield used


def compiled_for_gpus(
    files: Mapping[str, str], arch: str = DEFAULT_ARCH, options: Sequence[str] = (), optimise: bool = FULL
) -> CompiledText:
    """What NVRTC makes of a text, and says of it: its front end alone has warnings, in a thirtieth of the time.

    Only the optimiser contracts products and sums: tests of what it is told ask for it.
    """
    quick = () if optimise or version() < FIRST_QUICK else ("--Ofast-compile=max",)
    return compile_source(files, arch, (*options, *quick))


def assert_clean(files: Mapping[str, str], arch: str, launchers: set[str], optimise: bool = FULL) -> None:
    """NVRTC has nothing to say, and every operation is rounded by itself."""
    compiled = compiled_for_gpus(files, arch, DRIVER_OPTIONS, optimise)
    assert compiled.log == ""
    ptx = compiled.image.decode()
    assert set(re.findall(r"\.entry (\w+)\(", ptx)) == launchers
    assert not re.search(r"\bfma\.|\.approx|\.ftz", re.sub(r"//.*", "", ptx))
