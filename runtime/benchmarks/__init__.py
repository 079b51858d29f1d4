"""Error against run time: declarative studies, their runner, and the report that `bladesmith report` writes."""

from __future__ import annotations

from .harness.runner import Measurement, run_study
from .harness.study import Case, Method, Study

__all__ = ["Case", "Measurement", "Method", "Study", "run_study"]
