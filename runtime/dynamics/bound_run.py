"""Runs that are prepared once: each call goes on where the last one ended, in the same arrays."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..mechanics.system import System
from .integration import runs
from .integration.driver import Driver
from .integration.initial_conditions import check_start
from .integration.termination import message_of, raise_ending
from .model.loads import Load
from .trajectory import Trajectory

Array = NDArray[Any]


class BoundRun:
    """A simulation over a time, again and again; made by `Simulation.bound`. Not for several threads at once.

    A call is a run from the state at which the last call ended, with the bits of a simulation that begins there;
    functions of time see it go on. Nothing is made in it.
    """

    def __init__(
        self, driver: Driver, times: Array, motors: Array, twists: Array, loads: Sequence[Load], system: System | None
    ) -> None:
        self._loads, self._system, self._relative = loads, system, times.copy()
        self._run = run = runs.Run(driver, times.copy(), motors, twists)
        check_start(run, False)
        self._progress, self._status, self._stored = run.rows("progress"), run.status, run.stored
        self._reached, self._states, self._kept = run.rows("reached"), run.rows("states")[0], run.rows("kept")[0]
        size, first = 14 * driver.bodies, driver.program.kept.offsets["motors"]
        self._end, self._begin = self._states[-1, :size], self._kept[first : first + size]
        self._start = np.concatenate([motors.ravel(), twists.ravel()])
        self._bound, self._last, self._ends = run.hold(), len(times), self._end
        self.restart()

    def restart(self) -> None:
        """Begin the next call at the start of the simulation, at time 0."""
        self._count, self._ends = 0, self._start

    def __call__(self) -> None:
        """Go on for the time.

        Raises
        ------
        SimulationError
            If it cannot continue; its ``trajectory`` holds the states until then. The next call begins anew.
        KeyboardInterrupt
            The next call begins where this one did; or at its end, if that was reached: see ``time``.
        """
        self._kept.fill(0.0)
        self._progress.fill(0)
        self._begin[:] = self._ends
        run = self._run
        np.add(self._relative, self._count * self._relative[-1], run.times)
        self._reached[0, 0] = run.times[0]
        try:
            self._bound(0, 1)
            while self._stored[0] < self._last and not self._status[0]:  # interrupts are heard between
                self._bound(0, 1)
        except BaseException:
            if self._stored[0] == self._last and not self._status[0]:  # heard behind the last step
                self._count, self._ends = self._count + 1, self._end
            raise
        if self._status[0]:
            self.restart()
            raise_ending(run, self.trajectory)
        self._count, self._ends = self._count + 1, self._end

    @property
    def time(self) -> float:
        """The time that was reached, since the start."""
        return self._run.time_reached

    @property
    def trajectory(self) -> Trajectory:
        """The states of the last call, which stay as they are in the next one."""
        copied = self._run.copied()
        return Trajectory(copied, self._loads, message_of(copied), {}, self._system)


__all__ = ["BoundRun"]
