"""The studies that there are; each capability registers its own by a line here. They are imported when run."""

from __future__ import annotations

from importlib import import_module

from ..errors import InputError, suggest
from .study import Study

#: Study name -> module of `report.studies` that defines it as ``STUDY``.
STUDIES = {
    "products": "products",
    "distance": "distance",
    "rays": "rays",
    "ribbons": "ribbons",
    "hits": "hits",
    "crowds": "crowds",
    "rotors": "rotors",
    "registrations": "registrations",
    "robustness": "robustness",
    "symmetries": "symmetries",
    "claims": "claims",
    "coverage": "coverage",
    "tops": "tops",
    "pendulums": "pendulums",
    "drift": "drift",
    "violations": "violations",
    "stiffness": "stiffness",
    "delta": "delta",
    "chains": "chains",
    "mechanisms": "mechanisms",
    "reaching": "mechanisms_reaching",
    "projector": "projector",
    "exponential": "exponential",
    "logarithm": "logarithm",
}


def load_study(name: str) -> Study:
    """The study of this name.

    Raises
    ------
    InputError
        If there is none.
    """
    if name not in STUDIES:
        raise InputError(f"there is no study {name!r}{suggest(name, list(STUDIES))}; there are: {', '.join(STUDIES)}.")
    study = import_module(f".studies.{STUDIES[name]}", __package__).STUDY
    assert isinstance(study, Study)
    return study
