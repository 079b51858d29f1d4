"""Registry of studies: one line for each. Their modules are imported when they are run."""

from __future__ import annotations

from collections.abc import Iterable
from importlib import import_module
from typing import NamedTuple

from ..errors import InputError, suggest
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
    """The study of this name.

    Raises
    ------
    InputError
        If there is no such study.
    """
    if name not in STUDIES:
        raise InputError(f"there is no study {name!r}{suggest(name, list(STUDIES))}; there are: {', '.join(STUDIES)}.")
    study = import_module(f".studies.{STUDIES[name].module}", __package__).STUDY
    assert isinstance(study, Study)
    return study


def expected_seconds(names: Iterable[str], quick: bool = False) -> int:
    """Expected duration of studies, by the times in `STUDIES`."""
    entries = [STUDIES[name] for name in names]
    return sum(e.quick_seconds if quick else e.seconds for e in entries)
