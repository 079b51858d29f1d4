"""Simulations: a body or several, what acts on them and what holds them, run over time."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..arrays import truth
from ..codegen.errors import InputError
from . import engine, methods
from .assembly import Assembly, assemble
from .bodies import RigidBody
from .constraints import Constraint, check_constraints
from .endings import finish, message_of, raise_ending
from .events import Event, check_single, first_event, given_events
from .given import number, several, shown
from .loads import Load, check_loads
from .parameters import Directions
from .pins import is_turn
from .sensitivities import check_refused, directions_of, given_names
from .settings import Settings, check_room, settings_of, stored_times
from .starts import check_pinned_twist, check_start
from .system import System
from .trajectory import Trajectory

Array = NDArray[Any]
#: What ends a run: an event, or its function alone.
Watched = Event | Callable[..., Any]
#: What a run begins with: its sensitivities, the driver, motors and twists. Of each simulation the last few are kept.
Ready = tuple[Any, engine.Driver, Array, Array]
MOST_KEPT = 4
#: Rate at which Baumgarte's terms make errors decay, per second, if none is given.
BAUMGARTE = 10.0


class Simulation:
    """A body, or a system of bodies, with loads and constraints.

    Parameters
    ----------
    body : RigidBody or System
        One, or a batch of n that differ in their numbers: n simulations side by side.
    loads : sequence, or a single one
        `Gravity`, `BodyWrench`, `WorldWrench`, `Spring`, `Damper`.
    constraints : sequence, or a single one
        `Pin`, `PinPath`, `PinLinear`, `Incidence`, `VirtualPower`.
    integrator : str
        "auto" (see docs/integrators.md), "rk4", "rkmk4", "cf4", "midpoint", "strang", "blanes-moan", "yoshida6",
        "taylor" or "adaptive".
    map : {"exponential", "bortz", "cayley", "outer"}
        The chart of integrators that have one (thesis 6.11).
    stabilization : {"auto", "null-space", "projection", "baumgarte", "none"}
        How constraints are kept: pins that never move by moving only as they allow, others by bringing pose and twist
        back after each step ("auto"); or by Baumgarte's terms in the accelerations, or not at all.
    baumgarte : float
        Rate of decay of those terms, per second.
    stabilisation : str
        The same as `stabilization`.
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
    ) -> None:
        self._kept: dict[tuple[Any, ...], Ready] = {}
        self.bodies: tuple[RigidBody, ...]
        self.names: tuple[str, ...]
        held = several(constraints, Constraint, "the constraints")
        self.loads: tuple[Load, ...] = several(loads, Load, "the loads")
        match body:
            case RigidBody():
                self.bodies, self.names = (body,), ("body",)
            case System():
                self.bodies, self.names = tuple(body.bodies.values()), tuple(body.bodies)
            case _:
                raise InputError(f"the body is {shown(body)}; a RigidBody or a System is needed.")
        check_loads(self.loads, self.names)
        check_constraints(held, self.names)
        self.constraints = (*body.constraints(), *held) if isinstance(body, System) else held
        self.integrator = methods.check(integrator, ("auto", *methods.INTEGRATORS), "integrator")
        self.map = methods.check(map, methods.MAPS, "map")
        both = isinstance(stabilization, str) and stabilization != "auto" and stabilisation is not None
        if both and shown(stabilisation) != shown(stabilization):
            raise InputError(
                f"stabilization is {shown(stabilization)} and stabilisation {shown(stabilisation)}; they say the same "
                "thing: give one of them."
            )
        chosen = stabilization if stabilisation is None else stabilisation
        self.stabilization = methods.check(chosen, methods.STABILIZATIONS, "stabilization")
        self.baumgarte = number(baumgarte, "the rate of Baumgarte's terms")
        if self.baumgarte != BAUMGARTE and self.stabilization != "baumgarte":
            raise InputError("the rate baumgarte goes with stabilization='baumgarte'.", remedy="Give both, or neither")
        self._sealed = True

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
        events: Watched | Sequence[Watched] | None = (),
        progress: bool | Callable[[float], None] | None = None,
        executor: Executor | None = None,
        strict: bool = True,
        sensitivities: str | Sequence[str] | None = (),
    ) -> Trajectory:
        """The motion over some time.

        Parameters
        ----------
        duration : float
            In seconds.
        step : float
            Of integrators with a fixed step; and how far apart states are stored where no times are given. 1e-3 if left
            out.
        times : array (stores,)
            When to store states, each after the one before; 0 is added. Steps are shortened to meet them, by
            integrators with a fixed step; others interpolate, to the error of a step.
        rtol, atol : float
            Error of a step that is allowed to integrators that choose their own: as a share of the body's rates and
            turns (and of ways, in units of its radius of gyration), and in radians. 1e-12 and 0 if left out.
        threads : int
            For batches; default: all processors of this process. Functions of users run in one.
        project : bool
            Move the start to the nearest one that obeys the constraints.
        events : sequence of `Event` or functions, or a single one
            Stop where one comes; of one simulation of one body.
        progress : bool or callable
            True: a bar on stderr. A function is called with the time reached.
        executor : concurrent.futures.Executor
            Shares a batch over workers; the same bits.
        strict : bool
            Raise if a single simulation cannot go on; of a batch each has its own ``status``.
        sensitivities : sequence of str, or a single one
            Parameters whose gradients the trajectory's ``sensitivities`` hold: see docs/chapter6.md, "Gradients".

        Returns
        -------
        Trajectory
            Of an interrupt: what there was until then, its ``message`` "interrupted".

        Raises
        ------
        InputError, ShapeError
            If an argument is none, two of them do not go together, or the states take more memory than there is.
        ConstraintError
            If the start does not obey the constraints, or they contradict each other.
        SimulationError
            If the simulation cannot go on: why and when; its ``trajectory`` holds the states until then.
        """
        project, strict = truth(project, "project"), truth(strict, "strict")
        settings = settings_of(duration, step, rtol, atol, times is None)
        stores = stored_times(settings, times, len(self.bodies))
        looked_for, names = given_events(events), given_names(sensitivities)
        if names:
            check_refused(project=project, events=bool(looked_for), executor=executor is not None)
        if executor is not None:
            from .distributed import check_executor, shared

            check_executor(executor)
        asked, driver, motors, twists = self._ready(settings, project, names)
        if looked_for:
            check_single(driver.size, driver.bodies)
        check_room(driver, len(stores))
        if executor is not None:
            run = shared(self, driver, stores, settings, project, executor)
            message = message_of(run)
        else:
            driver.made.called.error = None  # of a run before, that nobody asked about
            run = engine.Run(driver, stores, motors, twists, threads, project)
            check_start(run, project)
            message = finish(run, progress, settings[0])
        found = Trajectory(self, run, places=asked.places if asked else None)
        found.message = message
        if looked_for:
            found = first_event(found, looked_for)
        if strict and driver.made.size == 1:
            raise_ending(run, found)
        return found

    def _ready(self, settings: Settings, project: bool, sensitivities: tuple[str, ...]) -> Ready:
        """What a run begins with; kept, for what a simulation is does not change."""
        key = (*settings, project, sensitivities)
        found = self._kept.get(key)
        if found is None:
            duration = settings[0]
            made, method = self._prepared(*settings, bool(sensitivities))
            asked = directions_of(made, self.loads, sensitivities, duration) if sensitivities else None
            driver = self._driver(made, method, directions=asked.directions if asked else None)
            start = self._projected(made, duration) if project else start_of(made)
            found = asked, driver, *start
            for old in list(self._kept)[: 1 - MOST_KEPT]:  # other threads may run it too
                self._kept.pop(old, None)
            self._kept[key] = found
        return found

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_kept": {}}  # drivers stay in their process

    def _prepared(
        self, duration: float, step: float, rtol: float | None, atol: float | None, sensitivities: bool = False
    ) -> tuple[Assembly, methods.Method]:
        null_space = self.stabilization in ("auto", "null-space")
        made = assemble(self.bodies, self.names, self.loads, self.constraints, duration, null_space)
        if self.stabilization == "null-space" and made.mode == "constrained":
            raise InputError(
                "stabilization='null-space' is for pins of one body that never move.",
                remedy="Use 'auto', 'projection' or 'baumgarte'",
            )
        integrator = methods.differentiable(self.integrator) if sensitivities else self.integrator
        name = methods.chosen(integrator, made)
        if integrator == "auto" and self.stabilization == "baumgarte":  # whose terms have no series
            name = "adaptive"
        tolerance = methods.RTOL if rtol is None else rtol
        least = 0.0 if atol is None else atol
        if name == "taylor" and self.stabilization == "baumgarte":
            raise InputError("stabilization='baumgarte' has no Taylor series.", remedy="Use 'projection'")
        adaptive = methods.INTEGRATORS[name] not in methods.FIXED
        return made, methods.Method(name, duration if adaptive else step, tolerance, least)

    def _projected(self, made: Assembly, duration: float) -> tuple[Array, Array]:
        """The start nearest to the given one that obeys the constraints; drivers do it but for those of a subspace."""
        if made.mode != "subspace":
            return start_of(made)
        whole = assemble(self.bodies, self.names, self.loads, self.constraints, duration, null_space=False)
        driver = self._driver(whole, methods.Method("rk4", 1.0, methods.RTOL, 0.0))
        run = engine.Run(driver, np.zeros(1), *start_of(whole), project=True)
        check_start(run, True)
        run.to(1)
        motor, twist = whole.to_user(0, run.motors[:, 0, 0], run.twists[:, 0, 0])
        frame = made.frames[0]
        motors = (~made.shift * motor * frame.own).as_kind("motor", check=False).values
        twists = (~frame.own >> twist).values
        return motors[:, None], np.where(np.asarray(frame.allowed), twists, 0.0)[:, None]

    def _driver(
        self, made: Assembly, method: methods.Method, part: slice = slice(None), directions: Directions | None = None
    ) -> engine.Driver:
        project = made.mode == "constrained" and self.stabilization in ("auto", "projection")
        rate = self.baumgarte if self.stabilization == "baumgarte" else 0.0
        return engine.Driver(made, method, self.map, project, rate, part, directions)

    def __repr__(self) -> str:
        loads, held = len(self.loads), len(self.constraints)
        return f"<Simulation of {', '.join(self.names)}; {loads} loads, {held} constraints>"


def start_of(made: Assembly) -> tuple[Array, Array]:
    """Motors (n, bodies, 8) and twists (n, bodies, 6) in the driver's frames."""
    motors = np.empty((made.size, len(made.bodies), 8))
    twists = np.empty((made.size, len(made.bodies), 6))
    for i, (body, frame) in enumerate(zip(made.bodies, made.frames, strict=True)):
        motors[:, i] = frame.pose.as_kind("motor", check=False).values
        twists[:, i] = (~frame.own >> body.twist_in_body).values
        if frame.allowed is not None:
            kept = np.where(frame.allowed, twists[:, i], 0.0)
            reach = np.sqrt(frame.moments.max(-1) / body.mass)[..., None]
            check_pinned_twist(twists[:, i], kept, np.where(is_turn(made.algebra), 1.0, reach))
            twists[:, i] = kept
    return motors, twists
