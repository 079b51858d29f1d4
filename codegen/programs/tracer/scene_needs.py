"""What a scene's program has: the key that programs are kept by."""

from __future__ import annotations

from dataclasses import dataclass

FLAGS = ("pictures", "lines", "layers", "reflection", "checker", "single", "tree")
#: Kinds of which several rays are met at once, in scenes that have no others.
WIDE_KINDS = frozenset(("plane", "sphere"))


@dataclass(frozen=True)
class SceneNeeds:
    """Features of a scene; equal needs are the same program.

    Attributes
    ----------
    kinds : tuple of str
        Kinds of surface, in their order.
    methods : tuple of str
        Of `METHODS`; empty where no surface has a choice.
    pictures, reflection, checker, single, layers, tree : bool
        Camera and light; mirrors; checkered surfaces; float32 besides float64; normals, depth and more of pictures;
        a tree over the boxes of many surfaces.
    lines : bool
        All points of lines on a surface.
    """

    kinds: tuple[str, ...]
    methods: tuple[str, ...] = ()
    pictures: bool = True
    reflection: bool = False
    checker: bool = False
    single: bool = False
    layers: bool = False
    tree: bool = False
    lines: bool = False

    @property
    def wide(self) -> bool:
        """True where the program meets several rays at once, of first hits."""
        return bool(self.kinds) and set(self.kinds) <= WIDE_KINDS and not self.tree

    def covers(self, other: SceneNeeds) -> bool:
        """Return whether a program for these needs serves the other's too."""
        return (
            set(other.kinds) <= set(self.kinds)
            and set(other.methods) <= set(self.methods)
            and all(getattr(self, flag) >= getattr(other, flag) for flag in FLAGS)
        )
