"""The mathematics: functions in GA notation that run on symbols and on numbers, in folders by subject.

Names of modules are unique over the folders: a spec says ``module.function``.
"""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from types import ModuleType


def load(name: str) -> ModuleType:
    """A module of formulas by its name, without its folder.

    Raises
    ------
    LookupError
        If there is none of that name.
    """
    for home in map(Path, __path__):
        for path in home.rglob(f"{name}.py"):
            return import_module(".".join((__name__, *path.relative_to(home).with_suffix("").parts)))
    raise LookupError(name)
