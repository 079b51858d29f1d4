"""Simulations: bodies with loads and constraints, integrated over time."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import replace
from functools import cached_property
from typing import Any

from numpy.typing import NDArray

from ..codegen.errors import InputError, SimulationError
from ..codegen.interrupts import keep_partial
from ..common.executors import check_executor
from ..common.progress import ProgressOption, open_progress
from ..common.validation import as_bool, as_choice, as_int, as_tuple, invalid, positive_float, short_repr
from ..core.multivector import Multivector
from ..mechanics.rigid_body import RigidBody
from ..mechanics.system import System
from .bound_run import BoundRun
from .integration import integrators, runs
from .integration.driver import Driver
from .integration.events import Event, as_events, check_single, stop_at_first_event
from .integration.executor import SimulationTask, run_on_executor
from .integration.initial_conditions import check_start
from .integration.problem import Problem
from .integration.program import TARGETS
from .integration.termination import finish, message_of, raise_ending
from .integration.time_grid import Settings, check_room, settings_of, stored_times
from .model.constraints import Constraint, check_constraints
from .model.joint_constraints import joint_constraints
from .model.loads import Load, check_loads
from .sensitivity.directions import as_names
from .trajectory import Trajectory
from .trees import executor as tree_executor
from .trees.choice import COORDINATES, TreeChoice
from .trees.driver import TreeRun
from .trees.problem import TreeProblem
from .trees.stepper import Stepper

Array = NDArray[Any]
#: An event, or its function alone.
EventLike = Event | Callable[..., Any]
#: Input of a run: slices of its sensitivities by name, the driver, motors and twists.
Prepared = tuple[dict[str, slice], Driver, Array, Array]
#: Message of a trajectory until an interrupt.
INTERRUPTED = "interrupted"
#: Inputs of the latest runs that a simulation caches.
CACHE_SIZE = 4
#: Default rate of decay of errors by Baumgarte's terms, per second.
BAUMGARTE = 10.0


class Simulation:
    """A body, or a system of bodies, with loads and constraints.

    Parameters
    ----------
    body : RigidBody or System
        One, or a batch of n bodies: n simulations.
    loads : sequence, or a single one
        `Gravity`, `BodyWrench`, `WorldWrench`, `Spring`, `Damper` and the like: see :doc:`/motion/dynamics`.
    constraints : sequence, or a single one
        `Pin`, `PinPath`, `PinLinear`, `Incidence`, `VirtualPower`.
    integrator : str
        "auto", or one of :doc:`/motion/integrators`: "rk4", "rkmk4", "adaptive", "taylor", ..
    map : {"exponential", "bortz", "cayley", "outer"}
        The chart of integrators that have one (thesis 6.11).
    stabilization : {"auto", "null-space", "projection", "baumgarte", "none"}
        Stabilization of constraints: "auto" is the null-space method for pins that never move, else a projection of
        pose and twist after each step; Baumgarte's terms change the accelerations; "none" lets errors grow.
    baumgarte : float
        Rate of decay of those terms, per second.
    stabilisation : str
        The same as `stabilization`.
    target : {"c", "numba", "cuda"}
        What runs it, to the same bits: "cuda" is a GPU, a thread for each simulation of a batch, without functions of
        users. Where there is no C compiler, "c" is numba, too.
    coordinates : {"auto", "joint", "maximal"}
        What is integrated: coordinates of joints, at a cost that grows with the number of bodies, or poses of all
        bodies under constraints, whose cost grows with its cube. "auto": those of joints where the system is a tree of
        joints and the integrator is "auto" too, unless what is asked for needs poses: see :doc:`/motion/dynamics`.
    """

    def __init__(
        self,
        body: RigidBody | System,
        loads: Load | Sequence[Load] | None = (),
        constraints: Constraint | Sequence[Constraint] | None = (),
        integrator: str = "auto",
        map: str = "exponential",
        stabilization: str = "auto",
        baumgarte: float = BAUMGARTE,
        stabilisation: str | None = None,
        target: str = "c",
        coordinates: str = "auto",
    ) -> None:
        self._cache: dict[tuple[Any, ...], Prepared] = {}
        self.bodies: tuple[RigidBody, ...]
        self.names: tuple[str, ...]
        listed = as_tuple(constraints, "the constraints", (Constraint, Multivector))  # which is told what it is
        self.loads: tuple[Load, ...] = as_tuple(loads, "the loads", Load)
        match body:
            case RigidBody():
                self.bodies, self.names = (body,), ("body",)
            case System():
                self.bodies, self.names = tuple(body.bodies.values()), tuple(body.bodies)
            case _:
                raise invalid(body, "the body", "a RigidBody or a System")
        check_loads(self.loads, self.names)
        check_constraints(listed, self.names)
        self._own_constraints = listed
        self.integrator = as_choice(integrator, "integrator", ("auto", *integrators.INTEGRATORS))
        self.map = as_choice(map, "map", integrators.MAPS)
        both = isinstance(stabilization, str) and stabilization != "auto" and stabilisation is not None
        if both and short_repr(stabilisation) != short_repr(stabilization):
            raise InputError(
                f"stabilization is {short_repr(stabilization)} and stabilisation {short_repr(stabilisation)}; they say "
                "the same thing: give one of them."
            )
        option = stabilization if stabilisation is None else stabilisation
        self.stabilization = as_choice(option, "stabilization", integrators.STABILIZATIONS)
        self.baumgarte = positive_float(baumgarte, "the rate of Baumgarte's terms")
        if self.baumgarte != BAUMGARTE and self.stabilization != "baumgarte":
            raise InputError("the rate baumgarte goes with stabilization='baumgarte'.", remedy="Give both, or neither")
        self.target = as_choice(target, "target", TARGETS)
        self.coordinates = as_choice(coordinates, "coordinates", COORDINATES)
        self.system = body if isinstance(body, System) else None
        obstacles = {
            "stabilization is of motions with constraints": self.stabilization != "auto",
            "map is of motions with constraints": self.map != "exponential",
            "there are constraints besides the joints": bool(listed),
        }
        self._choice = TreeChoice(self.system, self.loads, self.integrator, self.target, self.coordinates, obstacles)
        self._sealed = True

    @cached_property
    def constraints(self) -> tuple[Constraint, ...]:
        """Constraints of the joints, then the others."""
        return (*(() if self.system is None else joint_constraints(self.system)), *self._own_constraints)

    @cached_property
    def _problem(self) -> Problem:
        return Problem(
            self.bodies, self.names, self.loads, self.constraints, self.integrator, self.map, self.stabilization,
            self.baumgarte, self.target,
        )  # fmt: skip

    def __setattr__(self, name: str, value: Any) -> None:
        if getattr(self, "_sealed", False):  # runs keep what they begin with
            raise InputError(f"{name} of a simulation does not change.", remedy="Make another Simulation")
        super().__setattr__(name, value)

    def run(
        self,
        duration: float,
        step: float | None = None,
        times: Any = None,
        rtol: float | None = None,
        atol: float | None = None,
        threads: int | None = None,
        project: bool = False,
        events: EventLike | Sequence[EventLike] | None = (),
        progress: ProgressOption = False,
        executor: Executor | None = None,
        strict: bool = False,
        sensitivities: str | Sequence[str] | None = (),
    ) -> Trajectory:
        """Integrate the motion over some time.

        Parameters
        ----------
        duration : float
            In seconds.
        step : float
            Step of integrators with a fixed step, and distance of stored states without ``times``; default: 1e-3.
        times : array (stores,)
            Increasing times of stored states; 0 is added. Integrators with a fixed step shorten steps to meet them;
            adaptive ones use dense output, whose error is of the same order as the step error.
        rtol, atol : float
            Error of a step of adaptive integrators: relative to the body's rates and rotations (and to translations, in
            units of its radius of gyration), and in radians. Default: 1e-12 and 0.
        threads : int
            Threads of batches; default: the package's (`bladesmith.set_threads`). Users' functions run in one.
        project : bool
            Move the start to the nearest one that obeys the constraints.
        events : sequence of `Event` or functions, or a single one
            Events that stop the simulation, which has one body and is not a batch.
        progress : bool or callable
            True: a bar on standard error. A callable gets a `bladesmith.Progress` of the time reached.
        executor : concurrent.futures.Executor
            Runs a batch on its workers; the results have the same bits.
        strict : bool
            Raise if a simulation cannot continue. Otherwise the trajectory ends there, with its ``status`` and
            ``message``; a single one warns.
        sensitivities : sequence of str, or a single one
            Parameters whose gradients the trajectory's ``sensitivities`` hold ("Gradients", :doc:`/motion/dynamics`).

        Returns
        -------
        Trajectory

        Raises
        ------
        InputError, ShapeError
            If an argument is invalid, arguments conflict, or the stored states exceed the available memory.
        ConstraintError
            If the start does not obey the constraints, or they contradict each other.
        SimulationError
            With ``strict``, if a simulation cannot continue (reason, time, and in a batch which); its ``trajectory``
            holds the states until then. Always if the function of an event fails.
        ExecutorError
            If workers of the executor fail or end, and do so again.
        Interrupted
            On an interrupt. As that of an `ExecutorError`, its ``partial`` is the trajectory until then, with the
            ``message`` "interrupted".
        """
        project, strict = as_bool(project, "project"), as_bool(strict, "strict")
        settings = settings_of(duration, step, rtol, atol, times is None)
        stores = stored_times(settings, times, len(self.bodies))
        watched, names = as_events(events), as_names(sensitivities)
        if executor is not None:
            check_executor(executor)
        needs_poses = [n for n, x in {"events": watched, "sensitivities": names, "project": project}.items() if x]
        run_of_tree = self._choice.run(settings, stores, threads, needs_poses, executor is not None)
        if run_of_tree is not None:
            found = self._finish(run_of_tree, settings, progress, executor)
            _tell_ending(run_of_tree, found, strict)
            return found
        task = SimulationTask(self._problem, stores, settings, project, names)
        run, slices, message = self._run_poses(task, threads, progress, executor, bool(watched))
        if self._problem.integrator == "auto" and (run.status == runs.MEETING).any():  # no series: from the begin
            task = replace(task, problem=replace(self._problem, integrator="adaptive"))
            run, slices, message = self._run_poses(task, threads, progress, executor, bool(watched))
        trajectory = Trajectory(run, self.loads, message, slices, self.system)
        try:
            event = stop_at_first_event(run, watched)
        except InputError as error:  # its function failed
            raise SimulationError(error.what, remedy=error.remedy, trajectory=trajectory) from error.__cause__
        if event is not None:
            trajectory = Trajectory(run, self.loads, event.name, slices, self.system)
        if event is None or strict:
            _tell_ending(run, trajectory, strict)
        return trajectory

    def bound(
        self,
        duration: float,
        step: float | None = None,
        times: Any = None,
        rtol: float | None = None,
        atol: float | None = None,
    ) -> BoundRun:
        """A run over some time that is prepared once, for control loops: a call goes on where the last one ended.

        Parameters
        ----------
        duration, step, times, rtol, atol
            As of `run`; times count from the beginning of a call.

        Returns
        -------
        BoundRun
            A function without arguments, with ``time``, ``trajectory`` (the states of the last call) and ``restart()``.

        Raises
        ------
        InputError, ShapeError, ConstraintError
            As `run`; or if this is a batch, a motion in coordinates of joints, or runs on a GPU.
        """
        settings = settings_of(duration, step, rtol, atol, times is None)
        stores = stored_times(settings, times, len(self.bodies))
        if self._choice.problem_of(()) is not None:
            remedy = "Take stepper(dt), or coordinates='maximal'"
            raise InputError("a bound run is of poses, and this motion of coordinates of joints.", remedy=remedy)
        _, driver, motors, twists = self._prepare(SimulationTask(self._problem, stores, settings, False, ()))
        if driver.assembly.batched or driver.program.is_on_gpu:
            raise InputError("a bound run is of one simulation, in this process.", remedy="Take run()")
        check_room(driver, len(stores), None)
        return BoundRun(driver, stores, motors, twists, self.loads, self.system)

    def stepper(self, dt: float, substeps: int = 1) -> Stepper:
        """Steps of a control loop, in the coordinates of the joints: a state and torques in, the next state out.

        Parameters
        ----------
        dt : float
            Time of a step.
        substeps : int
            Steps of the integrator in it: "rk4", if the simulation's has no fixed steps. With "implicit" parts of
            the time, each in as many steps as it takes.

        Raises
        ------
        InputError
            If the system is not one of joints with coordinates, or is a batch.
        """
        problem = self._choice.problem(is_needed=True)
        assert isinstance(problem, TreeProblem) and self.system is not None
        return Stepper(problem, self.system, positive_float(dt, "dt"), as_int(substeps, "substeps", 1))

    def _finish(
        self, run: TreeRun, settings: Settings, progress: ProgressOption, executor: Executor | None
    ) -> Trajectory:
        """Run to the end; the trajectory."""
        with (
            open_progress(progress, "simulate", "s", settings[0]) as report,
            keep_partial(lambda: Trajectory(run, self.loads, INTERRUPTED, system=self.system)),
        ):
            if executor is not None:
                tree_executor.run_on_executor(run, self._choice.task(settings, run.times), executor, report)
                message = message_of(run)
            else:
                message = finish(run, report)
        return Trajectory(run, self.loads, message, system=self.system)

    def _run_poses(
        self, task: SimulationTask, threads: int | None, progress: ProgressOption, executor: Executor | None,
        single: bool,
    ) -> tuple[runs.Run, dict[str, slice], str]:  # fmt: skip
        """A run of poses to its end; places of sensitivities, and the reason of an early ending."""
        slices, driver, motors, twists = self._prepare(task)
        if single:
            check_single(driver.size, driver.bodies)
        check_room(driver, len(task.times), threads)
        driver.assembly.callbacks.error = None  # of a run before, that nobody asked about
        if executor is not None:
            run = runs.Run.blank(driver, task.times)
        else:
            run = runs.Run(driver, task.times, motors, twists, threads, task.project)
            check_start(run, task.project)
        with (
            open_progress(progress, "simulate", "s", task.settings[0]) as report,
            keep_partial(lambda: Trajectory(run, self.loads, INTERRUPTED, slices, self.system)),
        ):
            if executor is not None:
                run_on_executor(run, task, executor, report)
                message = message_of(run)
            else:
                message = finish(run, report)
        return run, slices, message

    def _prepare(self, task: SimulationTask) -> Prepared:
        """Input of a run, from the cache if it was run before: a simulation does not change."""
        problem, settings, project, sensitivities = task.problem, task.settings, task.project, task.sensitivities
        key = (*settings, project, sensitivities, problem.integrator)
        prepared = self._cache.get(key)
        if prepared is None:
            found = problem.assembled(settings, project, sensitivities)
            driver = problem.driver(found.assembly, found.method, directions=found.directions)
            prepared = found.slices, driver, found.motors, found.twists
            for old in list(self._cache)[: 1 - CACHE_SIZE]:  # other threads may run it too
                self._cache.pop(old, None)
            self._cache[key] = prepared
        return prepared

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_cache": {}}  # drivers stay in their process

    def __repr__(self) -> str:
        joints = [] if self.system is None else self.system.joints
        loads, constraints = len(self.loads), len(self._own_constraints) + sum(len(j.conditions()) for j in joints)
        return f"<Simulation of {', '.join(self.names)}; {loads} loads, {constraints} constraints>"


def _tell_ending(run: runs.Run, trajectory: Trajectory, strict: bool) -> None:
    """Raise, or warn, if a run ended early."""
    if strict:
        raise_ending(run, trajectory)
    elif trajectory.message and not run.driver.assembly.batched:
        text = f"the simulation ended early: {trajectory.message} (strict=True raises)"
        warnings.warn(text, RuntimeWarning, stacklevel=3)


__all__ = ["Simulation"]
