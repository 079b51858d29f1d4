"""Code generation: mathematics in, source text out.

Importing this costs nothing; what a name needs is imported when the name is first used, so that users of the
compiled algebras never load SymPy or a compiler.
"""

from __future__ import annotations

from . import start_time as start_time
from .lazy_names import lazy_names

__getattr__, __dir__ = lazy_names(__name__, __file__)
