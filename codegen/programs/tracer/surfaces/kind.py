"""What a kind of surface contributes to a program."""

from __future__ import annotations

from dataclasses import dataclass

from ... import KernelSpec
from ..records import PIECE
from .rows import CircleRows, PairRows


@dataclass(frozen=True)
class SurfaceKind:
    """Contribution of one kind of surface to a program.

    Attributes
    ----------
    name : str
        As programs and C functions spell it.
    parameters, constants : int
        Numbers of a row of parameters, and of a row of constants.
    kernels : tuple of KernelSpec
    methods : tuple of (str, tuple of KernelSpec)
        For surfaces whose roots can be found in several ways: what each way needs besides.
    roots : int
        The most points that one line can have on one row.
    layout : tuple of (str, int)
        Names and lengths of the parts of the row of constants, where Python reads them too.
    rows : CircleRows or PairRows, optional
        For surfaces along curves: what their algorithms take.
    """

    name: str
    parameters: int
    constants: int
    kernels: tuple[KernelSpec, ...]
    roots: int = 1
    methods: tuple[tuple[str, tuple[KernelSpec, ...]], ...] = ()
    layout: tuple[tuple[str, int], ...] = ()
    rows: CircleRows | PairRows | None = None

    @property
    def is_apart(self) -> bool:
        """True where its functions take a compiler so long that they are a translation unit, once for all scenes."""
        return bool(self.methods)

    def slice(self, name: str) -> slice:
        """Slice of a part of the row of constants."""
        start = 0
        for part, size in self.layout:
            if part == name:
                return slice(start, start + size)
            start += size
        raise KeyError(name)


#: Kinds of the arguments that are a ray.
RAY = ("position", "position")


def piece_layout() -> tuple[tuple[str, int], ...]:
    """Names and lengths of what the rows of every piece of a curve begin with."""
    return tuple((name, PIECE.extent(name)[1]) for name in PIECE.offsets)
