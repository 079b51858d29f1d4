"""Error against run time: declarative studies, their runner, and the report that `bladesmith report` writes."""

from __future__ import annotations

from .harness.runner import Measurement, run_study
from .harness.study import Case, Method, Study
from .harness.write import write_report
from .registry import load_study

__all__ = ["Case", "Measurement", "Method", "Study", "load_study", "run_study", "write_report"]
