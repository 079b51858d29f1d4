"""Compiled CUDA kernels run on arrays, through the driver's own library, which every GPU's driver brings.

Arrays are copied to the device and back at each call. Kernels and generated text are not known here.
"""

from __future__ import annotations

import ctypes
import math
import sys
import weakref
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from functools import cache
from typing import Any

import numpy as np

from ..errors import DeviceError
from ..ir.argument import Argument
from .arrays import Array, Binding

#: The driver's library, as it is called on this system.
DRIVER = "nvcuda.dll" if sys.platform == "win32" else "libcuda.so.1"
#: Threads of a block: a multiple of the warp of 32, small enough for kernels that need many registers.
BLOCK = 128
#: Blocks of a grid: more than any GPU runs at once; threads take further items in turn.
MAX_BLOCKS = 1 << 16
#: Bytes to which arrays in one piece of memory are aligned: what an allocation of its own has.
ALIGNMENT = 256
_MAJOR, _MINOR = 75, 76  # attributes of a device: its compute capability
_NAME_LENGTH = 256


class Device:
    """One GPU.

    Parameters
    ----------
    index : int
        Its number, from 0.
    driver : str
        File of the driver's library.

    Raises
    ------
    DeviceError
        If there is no driver or no such GPU; the message says which.
    """

    def __init__(self, index: int = 0, driver: str = DRIVER) -> None:
        try:
            self._library = ctypes.CDLL(driver)
        except OSError:
            remedy = "CUDA kernels run where a GPU's driver is."
            raise DeviceError(f"{driver} is not there", remedy=remedy) from None
        self.call("cuInit", 0)
        count = ctypes.c_int()
        self.call("cuDeviceGetCount", ctypes.byref(count))
        if not 0 <= index < count.value:
            raise DeviceError(f"there is no GPU {index}; the driver knows {count.value}.")
        self._device, self._context = ctypes.c_int(), ctypes.c_void_p()
        self.call("cuDeviceGet", ctypes.byref(self._device), index)
        self.call("cuDevicePrimaryCtxRetain", ctypes.byref(self._context), self._device)

    def call(self, name: str, *arguments: Any) -> None:
        """Call a function of the driver.

        Raises
        ------
        DeviceError
            If it fails, with what the driver says.
        """
        status = getattr(self._library, name)(*arguments)
        if status:
            text = ctypes.c_char_p()
            self._library.cuGetErrorString(status, ctypes.byref(text))
            raise DeviceError(f"{name}: {(text.value or b'unknown error').decode()} ({status})")

    @property
    def name(self) -> str:
        """Name that the driver reports."""
        buffer = ctypes.create_string_buffer(_NAME_LENGTH)
        self.call("cuDeviceGetName", buffer, _NAME_LENGTH, self._device)
        return buffer.value.decode(errors="replace")

    @property
    def capability(self) -> int:
        """Its architecture, for example 90."""
        parts = []
        for attribute in (_MAJOR, _MINOR):
            value = ctypes.c_int()
            self.call("cuDeviceGetAttribute", ctypes.byref(value), attribute, self._device)
            parts.append(value.value)
        return 10 * parts[0] + parts[1]

    @contextmanager
    def current(self) -> Iterator[None]:
        """Make this the calling thread's device for a while."""
        self.call("cuCtxPushCurrent_v2", self._context)
        try:
            yield
        finally:
            self.call("cuCtxPopCurrent_v2", ctypes.byref(ctypes.c_void_p()))

    @contextmanager
    def memory(self, size: int) -> Iterator[ctypes.c_uint64]:
        """``size`` bytes on the device, freed afterwards."""
        pointer = ctypes.c_uint64()
        self.call("cuMemAlloc_v2", ctypes.byref(pointer), ctypes.c_size_t(max(size, 1)))
        try:
            yield pointer
        finally:
            self.call("cuMemFree_v2", pointer)


class CudaModule:
    """A compiled image on a device.

    Parameters
    ----------
    device : Device
    image : bytes
        PTX or cubin, as `nvrtc.compile_text` returns it.
    """

    def __init__(self, device: Device, image: bytes) -> None:
        self.device = device
        self._image = ctypes.create_string_buffer(image)  # PTX must end in a zero byte
        self._module = ctypes.c_void_p()
        with device.current():
            device.call("cuModuleLoadData", ctypes.byref(self._module), self._image)

    def function(self, name: str) -> ctypes.c_void_p:
        """Handle of a kernel, by its name in the source."""
        handle = ctypes.c_void_p()
        with self.device.current():
            self.device.call("cuModuleGetFunction", ctypes.byref(handle), self._module, name.encode())
        return handle

    def launch(self, function: ctypes.c_void_p, n: int, arguments: Sequence[Any], begin: int = 0) -> None:
        """Run a kernel for n items from one on, whose ends are its first two arguments, and wait for it.

        The device must be the thread's current one.
        """
        given = [ctypes.c_longlong(begin), ctypes.c_longlong(begin + n), *arguments]
        places = (ctypes.c_void_p * len(given))(*(ctypes.addressof(a) for a in given))
        shared_memory, stream, extra = 0, None, None
        grid, block = (min(math.ceil(n / BLOCK), MAX_BLOCKS), 1, 1), (BLOCK, 1, 1)
        self.device.call("cuLaunchKernel", function, *grid, *block, shared_memory, stream, places, extra)
        self.device.call("cuCtxSynchronize")


class DeviceMemory:
    """Memory of a device, freed with this object.

    Parameters
    ----------
    device : Device
    size : int
        Bytes.
    """

    def __init__(self, device: Device, size: int) -> None:
        self.device, self.size, self.pointer = device, size, ctypes.c_uint64()
        with device.current():
            device.call("cuMemAlloc_v2", ctypes.byref(self.pointer), ctypes.c_size_t(max(size, 1)))
        self._freed = weakref.finalize(self, _free, device, self.pointer.value)
        self._freed.atexit = False  # the driver frees all that a process leaves

    def write(self, array: Array) -> None:
        """Copy an array to its beginning."""
        with self.device.current():
            self.device.call("cuMemcpyHtoD_v2", self.pointer, _address(array), ctypes.c_size_t(array.nbytes))

    def read(self, into: Array, offset: int = 0) -> None:
        """Copy from a place, in bytes, into an array."""
        place = ctypes.c_uint64(self.pointer.value + offset)
        with self.device.current():
            self.device.call("cuMemcpyDtoH_v2", _address(into), place, ctypes.c_size_t(into.nbytes))


class DeviceArrays:
    """Copies of arrays on a device, in one piece of memory that is kept from call to call and grows.

    Parameters
    ----------
    device : Device
    """

    def __init__(self, device: Device) -> None:
        self.device = device
        self._memory = DeviceMemory(device, 0)

    def write(self, arrays: Sequence[Array]) -> list[ctypes.c_uint64]:
        """Copy C-contiguous arrays, in the place of those before; where each begins."""
        ends = np.cumsum([-(-array.nbytes // ALIGNMENT) * ALIGNMENT for array in arrays], dtype=np.int64).tolist()
        begins, size = [0, *ends[:-1]], ends[-1] if ends else 0
        if size > self._memory.size:
            self._memory = DeviceMemory(self.device, size)
        together = np.zeros(size, np.uint8)
        for begin, array in zip(begins, arrays, strict=False):
            together[begin : begin + array.nbytes] = array.reshape(-1).view(np.uint8)
        self._memory.write(together)
        return [ctypes.c_uint64(self._memory.pointer.value + begin) for begin in begins[: len(arrays)]]

    def read(self, pointer: ctypes.c_uint64, into: Array) -> None:
        """Copy from a place back into an array."""
        self._memory.read(into, pointer.value - self._memory.pointer.value)


class CudaKernel(Binding):
    """One kernel of a module, as a function of arrays.

    Parameters
    ----------
    module : CudaModule
    symbol : str
        Name of the kernel; its launchers are ``<symbol>_batch_f64`` and ``<symbol>_batch_f32``.
    inputs, outputs : sequences of Argument
    """

    def __init__(
        self, module: CudaModule, symbol: str, inputs: Sequence[Argument], outputs: Sequence[Argument]
    ) -> None:
        super().__init__(symbol, inputs, outputs)
        self.module = module
        self._functions = {
            np.dtype(dtype): module.function(f"{symbol}_batch_{tag}")
            for dtype, tag in ((np.float64, "f64"), (np.float32, "f32"))
        }

    def run(self, arrays: Sequence[Array], results: Sequence[Array], n: int) -> None:
        """Copy to the device, compute ``n`` items, copy back."""
        if n == 0:
            return
        device = self.module.device
        with ExitStack() as stack:
            stack.enter_context(device.current())
            outs = [stack.enter_context(device.memory(r.nbytes)) for r in results]
            ins = [stack.enter_context(device.memory(a.nbytes)) for a in arrays]
            for pointer, array in zip(ins, arrays, strict=True):
                device.call("cuMemcpyHtoD_v2", pointer, _address(array), ctypes.c_size_t(array.nbytes))
            arguments: list[Any] = list(outs)
            for pointer, stride in zip(ins, self.strides(arrays), strict=True):
                arguments += [pointer, ctypes.c_longlong(stride)]
            dtype = arrays[0].dtype if arrays else np.dtype(np.float64)
            self.module.launch(self._functions[dtype], n, arguments)
            for pointer, result in zip(outs, results, strict=True):
                device.call("cuMemcpyDtoH_v2", _address(result), pointer, ctypes.c_size_t(result.nbytes))


@cache
def first_gpu() -> Device:
    """The first GPU, opened once.

    Raises
    ------
    DeviceError
        If there is none.
    """
    return Device()


def unavailable(driver: str = DRIVER) -> str:
    """Why no kernel can run here; empty where there is a GPU."""
    try:
        Device(driver=driver)
    except DeviceError as error:
        return str(error)
    return ""


def _address(array: Array) -> ctypes.c_void_p:
    return ctypes.c_void_p(array.ctypes.data)


def _free(device: Device, pointer: int) -> None:
    with device.current():
        device.call("cuMemFree_v2", ctypes.c_uint64(pointer))
