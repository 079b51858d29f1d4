"""Initial value problems: bodies, loads and constraints with an integrator, assembled for the driver."""

from __future__ import annotations

from dataclasses import dataclass
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
from ..sensitivity.parameters import Directions
from . import driver, integrators
from .initial_conditions import check_pinned_twist, check_start
from .time_grid import Settings

Array = NDArray[Any]


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
        integrator = integrators.differentiable(self.integrator) if sensitivities else self.integrator
        name = integrators.select_integrator(integrator, assembly)
        if integrator == "auto" and self.stabilization == "baumgarte":  # whose terms have no series
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
        return driver.Driver(assembly, method, self.map, project, rate, part, directions)

    def start(self, assembly: Assembly, duration: float, project: bool) -> tuple[Array, Array]:
        """Motors and twists at the start; if wanted, those nearest to the given ones that obey the constraints.

        Drivers project the start themselves, except for those of a subspace.
        """
        if not project or assembly.mode != "subspace":
            return start_of(assembly)
        whole = self._assemble(duration, null_space=False)
        method = integrators.Method("rk4", 1.0, integrators.RTOL, 0.0)
        run = driver.Run(self.driver(whole, method), np.zeros(1), *start_of(whole), project=True)
        check_start(run, True)
        run.run_until(1)
        motor, twist = whole.to_user(0, run.motors[:, 0, 0], run.twists[:, 0, 0])
        frame = assembly.frames[0]
        motors = (~assembly.shift * motor * frame.to_body).as_kind("motor", check=False).values
        twists = (~frame.to_body >> twist).values
        return motors[:, None], np.where(np.asarray(frame.allowed), twists, 0.0)[:, None]


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
