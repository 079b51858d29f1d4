"""State of a search: its candidates, and their significance."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..verification.ranking import GAP_LEVEL, CandidateRanking

Array = NDArray[Any]
#: Objects match up to this many tolerances.
MATCH_FACTOR = 3.0
#: A pose is significant if fewer motors than this are expected to be as good by chance.
MAX_NFA = 1e-4


@dataclass
class SearchState:
    """State of a search: its candidates and their significance.

    Attributes
    ----------
    motors, scores, hits : arrays (m, 8), (m,), (m,)
        Candidates in the frames of the models, the best first; their scores and numbers of inliers.
    tolerance : float
        Tolerance at which they were found.
    candidates : int
        Number of motors that were tried, at all tolerances.
    accidental_rate : float
        Probability that a wrong motor matches an object at this tolerance.
    log_nfa : float
        log10 of the number of false alarms: of motors as good as the best one that are expected by chance. Or, where
        that is more, of the probability of its lead over its competitors, scaled so that `MAX_NFA` is its limit too.
    sets : int
        Number of minimal sets that were used at this tolerance.
    inlier_scale : float
        Distance up to which the best motor's matches are most significant; NaN before candidates were compared.
    n_equivalent : int
        Number of motors, the first ones, that are equivalent to the best.
    ranking : CandidateRanking
    is_ambiguous : bool
        True if the best motor is significant, but motors that contradict it are nearly as good.
    background_rate : float
        Fraction of the objects that wrong candidates match; NaN before candidates were compared.
    has_converged : bool
        True if no better motor was missed, provided that noise is less than the tolerance.
    """

    motors: Array = field(default_factory=lambda: np.empty((0, 8)))
    scores: Array = field(default_factory=lambda: np.empty(0))
    hits: Array = field(default_factory=lambda: np.empty(0, np.int32))
    tolerance: float = math.nan
    candidates: int = 0
    accidental_rate: float = 1.0
    log_nfa: float = math.inf
    sets: int = 0
    inlier_scale: float = math.nan
    n_equivalent: int = 1
    ranking: CandidateRanking | None = None
    is_ambiguous: bool = False
    background_rate: float = math.nan
    has_converged: bool = False

    @property
    def is_significant(self) -> bool:
        """True if fewer than `MAX_NFA` motors are expected to be as good by chance."""
        return self.log_nfa <= math.log10(MAX_NFA)

    def compare(self, alternatives: Array | None = None) -> None:
        """Refine and rank the candidates, together with alternatives (m, 8) of the best one."""
        assert self.ranking is not None
        motors, background_rate = self.motors, None
        if alternatives is not None:
            motors, background_rate = np.concatenate([motors[:1], alternatives, motors[1:]]), self.background_rate
        result = self.ranking.rank(motors, self.tolerance, max(self.candidates, 1), background_rate)
        self.background_rate = result.background_rate
        self.motors, self.scores, self.hits = result.motors, result.scores, result.hits
        self.n_equivalent, self.inlier_scale = result.n_equivalent, result.inlier_scale
        self.is_ambiguous = result.log_nfa <= math.log10(MAX_NFA) and not result.is_unambiguous
        self.log_nfa = max(result.log_nfa, result.log_gap_probability - math.log10(GAP_LEVEL) + math.log10(MAX_NFA))
