"""A stand-in for a GPU: CUDA's words for the C compiler, and a library that looks like the GPU's driver.

Its device memory is the host's, and a launch runs its threads one after the other.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from bladesmith.codegen.build.extension import load as load_extension
from bladesmith.codegen.targets.c.source import ExtensionSource

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
    return str(load_extension(ExtensionSource(name, "int bs_left_open(void);", source, options=("-O1",))).__file__)
