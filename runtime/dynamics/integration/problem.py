"""Initial value problems: bodies, loads and constraints with an integrator, assembled for the driver."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.errors import InputError
from ...mechanics.rigid_body import RigidBody
from ...mechanics.twists import rotational_mask
from ..assembly.assemble import assemble
from ..assembly.data import Assembly
from ..model.constraints import Constraint
from ..model.loads import Load
from ..sensitivity.directions import directions_of
from ..sensitivity.parameters import Directions
from . import driver, integrators, runs
from .initial_conditions import check_pinned_twist, check_start
from .time_grid import Settings

Array = NDArray[Any]


@dataclass(frozen=True, eq=False)
class Assembled:
    """What a run begins with.

    Attributes
    ----------
    assembly : Assembly
    method : integrators.Method
    slices : dict of str to slice
        Of the directions, by the names of parameters.
    directions : Directions, optional
    motors, twists : array (n, bodies, 8 or 6)
        At the start; if it is to be brought to constraints, drivers do so, but in a subspace.
    """

    assembly: Assembly
    method: integrators.Method
    slices: dict[str, slice]
    directions: Directions | None
    motors: Array
    twists: Array


@dataclass(frozen=True, eq=False)
class Problem:
    """Bodies with what acts on them, and how their motion is integrated: all of a simulation that workers need."""

    bodies: tuple[RigidBody, ...]
    names: tuple[str, ...]
    loads: tuple[Load, ...]
    constraints: tuple[Constraint, ...]
    integrator: str
    map: str
    stabilization: str
    baumgarte: float
    target: str = "c"

    def _assemble(self, duration: float, null_space: bool) -> Assembly:
        return assemble(self.bodies, self.names, self.loads, self.constraints, duration, null_space)

    def prepare(self, settings: Settings, sensitivities: bool = False) -> tuple[Assembly, integrators.Method]:
        """Assembly and integrator of a run.

        Raises
        ------
        InputError
            If the integrator or the stabilization does not apply to this problem.
        """
        duration, step, rtol, atol = settings
        assembly = self._assemble(duration, null_space=self.stabilization in ("auto", "null-space"))
        if self.stabilization == "null-space" and assembly.mode == "constrained":
            raise InputError(
                "stabilization='null-space' is for pins of one body that never move.",
                remedy="Use 'auto', 'projection' or 'baumgarte'",
            )
        name = integrators.select_integrator(self.integrator, assembly, duration, sensitivities)
        if self.integrator == "auto" and self.stabilization == "baumgarte":  # whose terms have no series
            name = "adaptive"
        tolerance = integrators.RTOL if rtol is None else rtol
        absolute = 0.0 if atol is None else atol
        if name == "taylor" and self.stabilization == "baumgarte":
            raise InputError("stabilization='baumgarte' has no Taylor series.", remedy="Use 'projection'")
        adaptive = integrators.INTEGRATORS[name] not in integrators.FIXED
        return assembly, integrators.Method(name, duration if adaptive else step, tolerance, absolute)

    def driver(
        self,
        assembly: Assembly,
        method: integrators.Method,
        part: slice = slice(None),
        directions: Directions | None = None,
    ) -> driver.Driver:
        """Driver of a part of the simulations."""
        project = assembly.mode == "constrained" and self.stabilization in ("auto", "projection")
        rate = self.baumgarte if self.stabilization == "baumgarte" else 0.0
        return driver.Driver(assembly, method, self.map, project, rate, part, directions, self.target)

    def assembled(self, settings: Settings, project: bool, sensitivities: tuple[str, ...]) -> Assembled:
        """All that a run begins with.

        Raises
        ------
        InputError
            As `prepare`, or if there is no such parameter, or it is none of this motion.
        """
        duration = settings[0]
        assembly, method = self.prepare(settings, bool(sensitivities))
        splits = method.driver == "composition"
        slices, directions = directions_of(assembly, self.loads, sensitivities, duration, splits)
        if not project or assembly.mode != "subspace":  # drivers project the start themselves, but in a subspace
            return Assembled(assembly, method, slices, directions, *start_of(assembly))
        motors, twists, tangents = self._projected_start(assembly, duration, sensitivities)
        if directions is not None:
            directions = replace(directions, start=tangents)
        return Assembled(assembly, method, slices, directions, motors, twists)

    def _projected_start(
        self, assembly: Assembly, duration: float, sensitivities: tuple[str, ...]
    ) -> tuple[Array, Array, Array]:
        """Motors and twists in a subspace nearest to the given ones, and tangents of the start."""
        whole = self._assemble(duration, null_space=False)
        method = integrators.Method("rk4", 1.0, integrators.RTOL, 0.0)
        _, directions = directions_of(whole, self.loads, sensitivities, duration)
        run = runs.Run(
            self.driver(whole, method, directions=directions), np.zeros(1), *start_of(whole), project=True
        )
        check_start(run, True)
        run.run_until(1)
        motor, twist = whole.to_user(0, run.motors[:, 0, 0], run.twists[:, 0, 0])
        frame = assembly.frames[0]
        motors = (~assembly.shift * motor * frame.to_body).as_kind("motor", check=False).values
        twists = (~frame.to_body >> twist).values
        allowed = np.asarray(frame.allowed)
        tangents = run.tangents[:, 0]
        if directions is not None:
            tangents = tangents / directions.sizes[:, :, None, None, None]
            over = (~frame.to_body * whole.frames[0].to_body).as_kind("motor", check=False)
            over = over.reshape(-1, 1, 1, 1) if over.shape else over
            kind = assembly.algebra.kind("twist")
            tangents = np.where(allowed, (over >> assembly.algebra.wrap(kind, tangents)).values, 0.0)
        return motors[:, None], np.where(allowed, twists, 0.0)[:, None], tangents


def start_of(assembly: Assembly) -> tuple[Array, Array]:
    """Motors (n, bodies, 8) and twists (n, bodies, 6) at the start, in the driver's frames."""
    motors = np.empty((assembly.size, len(assembly.bodies), 8))
    twists = np.empty((assembly.size, len(assembly.bodies), 6))
    for i, (body, frame) in enumerate(zip(assembly.bodies, assembly.frames, strict=True)):
        motors[:, i] = frame.pose.as_kind("motor", check=False).values
        twists[:, i] = (~frame.to_body >> body.twist_in_body).values
        if frame.allowed is not None:
            admissible = np.where(frame.allowed, twists[:, i], 0.0)
            gyration = np.sqrt(frame.moments.max(-1) / body.mass)[..., None]
            check_pinned_twist(twists[:, i], admissible, np.where(rotational_mask(assembly.algebra), 1.0, gyration))
            twists[:, i] = admissible
    return motors, twists


__all__ = ["Problem", "start_of"]
