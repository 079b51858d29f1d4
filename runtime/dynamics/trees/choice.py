"""The choice between coordinates of joints and poses of bodies."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any

from numpy.typing import NDArray

from ...codegen.errors import InputError
from ...mechanics.system import System
from ..integration.time_grid import Settings, check_room
from ..model.joint_loads import JointLoad
from .driver import TreeDriver, TreeRun
from .executor import TreeTask
from .problem import INTEGRATORS, TreeProblem, tree_problem

Array = NDArray[Any]
#: What can be integrated.
COORDINATES = ("auto", "joint", "maximal")
#: Drivers that are kept.
CACHE_SIZE = 4


class TreeChoice:
    """Whether a simulation is in the coordinates of joints.

    Parameters
    ----------
    system : System, optional
    loads : sequence
    integrator, target, coordinates : str
        As of `Simulation`.
    obstacles : mapping of str to bool
        Reasons why poses of bodies are needed, and whether they are there.

    Raises
    ------
    InputError
        If it is to be in coordinates of joints, and is none in them.
    """

    def __init__(
        self, system: System | None, loads: Sequence[Any], integrator: str, target: str, coordinates: str,
        obstacles: Mapping[str, bool],
    ) -> None:  # fmt: skip
        self._given = system, loads, integrator, target
        self._coordinates = coordinates
        self._obstacle = next((reason for reason, is_there in obstacles.items() if is_there), "")
        self._problem: TreeProblem | str | None = None
        self._drivers: dict[Settings, TreeDriver] = {}
        self._insists = coordinates == "joint"
        if system is not None and system.couplings:
            self._insists = True
            if coordinates == "maximal":
                (j, _), *_ = system.couplings[0]
                raise InputError(
                    f"{system.joints[j].label} is coupled to another joint, in coordinates of joints alone.",
                    remedy="Leave coordinates='maximal' out, or take the robot's system(followers='lock') or 'free'",
                )
        for i, load in enumerate(loads):
            if isinstance(load, JointLoad):
                self._insists = True
                _check_joint_load(f"loads[{i}] ({load.label})", load, system, coordinates)
        if self._insists:
            self.problem()

    def problem(self, is_needed: bool = False) -> TreeProblem | str:
        """The motion in coordinates of joints; or, if these are not needed, the reason why there is none."""
        if self._problem is None:
            self._problem = self._obstacle or tree_problem(*self._given)
        if isinstance(self._problem, str) and (self._insists or is_needed):
            raise self._error(self._problem)
        return self._problem

    def problem_of(self, needs_poses: Sequence[str]) -> TreeProblem | None:
        """The motion in coordinates of joints, if a run is one; ``needs_poses`` names what cannot do without poses.

        Raises
        ------
        InputError
            If it is to be in coordinates of joints, and needs poses.
        """
        if needs_poses and self._insists:
            raise self._error(f"{', '.join(needs_poses)}: these need poses of bodies")
        is_auto = self._coordinates == "auto" and self._given[2] == "auto" and not needs_poses
        problem = self.problem() if self._insists or is_auto else ""
        return None if isinstance(problem, str) else problem

    def run(
        self, settings: Settings, stores: Array, threads: int | None, needs_poses: Sequence[str], is_blank: bool
    ) -> TreeRun | None:
        """A run at its start, or a blank one; None if the simulation is one of poses.

        Raises
        ------
        InputError
            If it is to be in coordinates of joints, and needs poses; or if its states do not fit into memory.
        """
        problem = self.problem_of(needs_poses)
        if problem is None:
            return None
        driver = self._drivers.get(settings) or problem.driver(settings)
        for old in [each for each in self._drivers if each != settings][: 1 - CACHE_SIZE]:  # other threads may run it
            self._drivers.pop(old, None)
        self._drivers[settings] = driver
        check_room(driver, len(stores), threads)
        return TreeRun.blank(driver, stores) if is_blank else TreeRun(driver, stores, threads)

    def task(self, settings: Settings, stores: Array) -> TreeTask:
        """The same for workers of an executor."""
        system, loads, integrator, target = self._given
        assert system is not None
        return TreeTask(system, tuple(loads), integrator, target, stores, settings)

    def _error(self, reason: str) -> InputError:
        what, remedy = "loads of joints are", "Take loads of bodies, as WorldWrench, Spring or Damper"
        system, _, integrator, _ = self._given
        if system is not None and system.couplings:
            what, remedy = "coupled joints are", "Take the robot's system(followers='lock') or 'free'"
        if self._coordinates == "joint":
            what, remedy = "coordinates='joint' is", "Take coordinates='auto', or 'maximal'"
        elif not self._insists:
            what, remedy = "a stepper is", "Take Simulation.run"
        if integrator not in INTEGRATORS:
            *first, last = map(json.dumps, INTEGRATORS)
            remedy = f"Take integrator = {', '.join(first)} or {last}. {remedy.replace('Take', 'Or take')}"
        return InputError(f"{what} for systems of joints with coordinates: {reason}.", remedy=remedy)

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_drivers": {}, "_problem": None}  # what is compiled stays in its process


def _check_joint_load(what: str, load: JointLoad, system: System | None, coordinates: str) -> None:
    """Refuse a load of a joint that is not there, or not integrated."""
    if system is None:
        raise InputError(f"{what} is of a joint, and the simulation of one body.")
    if coordinates == "maximal":
        raise InputError(f"{what} acts in coordinates of joints.", remedy="Leave coordinates='maximal' out")
    try:
        system.joint_index(load.joint)
    except InputError as error:
        raise InputError(error.what, where=what, remedy=error.remedy) from None
