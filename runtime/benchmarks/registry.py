"""Registry of studies: one line for each. Their modules are imported when they are run."""

from __future__ import annotations

import sys
import traceback
from collections.abc import Iterable
from functools import cache
from importlib import import_module
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from typing import NamedTuple

from ..codegen.errors import BladesmithError, InputError, one_line, suggest
from ..codegen.version import site_page
from .harness.study import Study


class Entry(NamedTuple):
    """Entry of a study.

    Parameters
    ----------
    module : str
        Module of `benchmarks.studies` that defines it as ``STUDY``.
    seconds, quick_seconds : int
        Processor time on an AMD EPYC, plots and compiling included, with every peer installed.
    """

    module: str
    seconds: int
    quick_seconds: int


#: Studies by name.
STUDIES = {
    "products": Entry("algebra.products", 8, 5),
    "distance": Entry("algebra.distance", 6, 3),
    "rays": Entry("tracing.rays", 30, 17),
    "ribbons": Entry("tracing.ribbons", 28, 22),
    "hits": Entry("tracing.hits", 52, 11),
    "crowds": Entry("tracing.crowds", 25, 11),
    "rotors": Entry("algebra.rotors", 82, 12),
    "registrations": Entry("registration.registrations", 88, 18),
    "robustness": Entry("registration.robustness", 15, 10),
    "symmetries": Entry("registration.symmetries", 12, 7),
    "claims": Entry("registration.claims", 20, 4),
    "coverage": Entry("registration.coverage", 11, 2),
    "segments": Entry("registration.segments", 60, 12),
    "tops": Entry("dynamics.tops", 28, 25),
    "pendulums": Entry("dynamics.pendulums", 19, 19),
    "drift": Entry("dynamics.drift", 15, 14),
    "violations": Entry("dynamics.violations", 9, 8),
    "stiffness": Entry("dynamics.stiffness", 45, 35),
    "springs": Entry("dynamics.springs", 45, 45),
    "joints": Entry("dynamics.joints", 38, 38),
    "lanes": Entry("dynamics.lanes", 25, 25),
    "delta": Entry("kinematics.delta", 25, 16),
    "chains": Entry("kinematics.chains", 13, 10),
    "mechanisms": Entry("kinematics.mechanisms", 15, 12),
    "reaching": Entry("kinematics.mechanisms_reaching", 13, 12),
    "projector": Entry("algebra.projector", 50, 15),
    "exponential": Entry("algebra.exponential", 52, 12),
    "logarithm": Entry("algebra.logarithm", 85, 17),
}


def load_study(name: str) -> Study:
    """The study of this name, or that of a Python file: its ``STUDY``.

    Parameters
    ----------
    name : str
        A name of `STUDIES`, or the path of a file, ``mine.py``, which is run.

    Raises
    ------
    InputError
        If there is no such study, or the file cannot be run or has no study; then with its line.
    """
    if name.endswith(".py"):
        path = Path(name).absolute()
        try:
            changed = path.stat().st_mtime_ns
        except OSError as error:
            raise InputError(f"cannot be read: {error.strerror}.", where=name) from None
        return _study_of_file(path, changed)
    if name not in STUDIES:
        raise InputError(
            f"there is no study {name!r}{suggest(name, list(STUDIES))}; there are: {', '.join(STUDIES)}.",
            remedy="Or give the file of one of your own, mine.py",
        )
    study = import_module(f".studies.{STUDIES[name].module}", __package__).STUDY
    assert isinstance(study, Study)
    return study


@cache
def _study_of_file(path: Path, changed: int) -> Study:
    """The study of a file in one state: it is run once."""
    spec = spec_from_file_location(f"bladesmith_study_{path.stem}", path)
    assert spec is not None and spec.loader is not None
    module = module_from_spec(spec)
    sys.modules[spec.name] = module  # dataclasses look for themselves there
    try:
        spec.loader.exec_module(module)
    except BladesmithError:
        raise
    except SyntaxError as error:
        raise InputError(f"is not Python: {error.msg}.", where=f"{path}, line {error.lineno}") from None
    except Exception as error:
        lines = [f.lineno for f in traceback.extract_tb(error.__traceback__) if f.filename == str(path)]
        where = f"{path}, line {lines[-1]}" if lines else str(path)
        raise InputError(f"cannot be run: {type(error).__name__}: {error}.", where=where) from None
    study = getattr(module, "STUDY", None)
    if not isinstance(study, Study):
        what = "has no STUDY" if study is None else f"has a STUDY that is {one_line(study)}"
        remedy = f"Write STUDY = bladesmith.benchmarks.Study(...) in it: {site_page('accuracy/studies')}"
        raise InputError(f"{what}.", where=str(path), remedy=remedy)
    return study


def expected_seconds(names: Iterable[str], quick: bool = False) -> int:
    """Expected duration of studies, by the times in `STUDIES`: of files nothing is known."""
    entries = [STUDIES[name] for name in names if name in STUDIES]
    return sum(e.quick_seconds if quick else e.seconds for e in entries)
