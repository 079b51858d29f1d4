"""Inertia of rigid bodies as a function from twists to momenta, in any frame (thesis 6.4).

The formulas are in `codegen.formulas`: `mechanics` and `inertia`.
"""

from __future__ import annotations

from typing import Any, Literal, overload

import numpy as np

from ..codegen.algebra.mismatch import algebra_mismatch
from ..common.dtypes import common_precision
from ..common.validation import as_instance, broadcast_shapes, positive_array
from ..core.geometry.euclidean import plain
from ..core.multivector import Algebra, Multivector
from ..dispatch.formulas import ArrayOperand, evaluate
from ..dispatch.item_statuses import array_result, merge_statuses
from ..dispatch.multivector_data import Statuses
from .mass_properties import mass_properties
from .principal_axes import principal
from .screws import Array, as_screw, finite_screw, geometry, twist


class Inertia:
    """Inertia Q of a rigid body, or of a batch of them: momentum Psi = Q(Omega).

    Parameters
    ----------
    mass : float or array (...)
    moments : array (..., 3) or (..., 3, 3)
        Moments about the principal axes, or the symmetric tensor, about the center of mass, mass included. A shape
        that ends in (3, 3) means tensors. One moment may be zero, as that of a rod.
    motor : Multivector, optional
        Takes the frame of the moments, its origin at the center of mass, to the frame of twists and momenta.
        Default: the identity.
    algebra : Algebra, optional
        `bladesmith.cga3d` (default) or `pga3d`; that of the motor, if one is given.

    Attributes
    ----------
    mass, moments : array
        Mass (...) and principal moments (..., 3).
    frame : Multivector
        Takes the frame of the principal axes to that of twists and momenta.
    center, tensor : array
        Center of mass (..., 3), and the tensor about it (..., 3, 3), in the frame of twists.
    shape : tuple
        Shape of the batch.

    Raises
    ------
    InputError, ShapeError, AlgebraMismatchError
        If a mass or a moment is not positive, the tensor is not symmetric, or no body can have such moments, with
        the item and the amount.

    Notes
    -----
    In the frame of the principal axes Q(w I3 + v n) = m v I3 + (I w) n, in another R Q(~R Omega R) ~R (6.15, 6.16).
    The pair that is printed for PGA has wrong signs and moments, although it is its own inverse. Results have the
    precision of the screws.
    """

    def __init__(
        self, mass: Any, moments: Any, motor: Multivector | None = None, algebra: Algebra | None = None
    ) -> None:
        home = motor.algebra if algebra is None and isinstance(motor, Multivector) else algebra
        self.algebra = geometry(home)
        self.mass = positive_array(mass, "the mass")
        self.moments, axes = principal(moments, thin=True)
        self.frame: Multivector = self.algebra.motor_from_matrix(axes).as_kind("motor")
        if motor is not None:
            self.frame = self._motor(motor) * self.frame
        self.shape = broadcast_shapes(
            {"mass": self.mass.shape, "moments": self.moments.shape[:-1], "motor": self.frame.shape}
        )

    @classmethod
    def from_mesh(cls, mesh: Any, density: Any = None, mass: Any = None, algebra: Algebra | None = None) -> Inertia:
        """Inertia of the solid inside a closed mesh, in the mesh's frame; arguments as of `mass_properties`."""
        solid = mass_properties(mesh, density, mass)
        home: Any = geometry(algebra)
        return cls(solid.mass, solid.tensor, home.translator(solid.center), home)

    def transformed(self, motor: Multivector) -> Inertia:
        """This inertia moved by a motor R: R Q(~R Omega R) ~R."""
        new = object.__new__(type(self))
        new.algebra, new.mass, new.moments = self.algebra, self.mass, self.moments
        new.frame = self._motor(motor) * self.frame
        new.shape = broadcast_shapes({"bodies": self.shape, "motors": motor.shape})
        return new

    # -- the map, its inverse and rates ---------------------------------------------------------------

    def __call__(self, twist: Multivector, strict: bool = False) -> Multivector:
        """Momentum of a body that moves with a twist."""
        momentum, _ = self._evaluate("mechanics.momentum_in", self._screw(twist, "the twist"))
        return finite_screw(momentum, "momentum", strict)

    def inverse(self, momentum: Multivector, strict: bool = False) -> Multivector:
        """Twist of a momentum. `SINGULAR`: a moment of inertia is zero."""
        return self._answer("inertia.velocity", (self._screw(momentum, "the momentum"),), strict)

    def rate(
        self, momentum: Multivector, wrench: Multivector | None = None, twist: Multivector | None = None,
        strict: bool = False,
    ) -> Multivector:  # fmt: skip
        """Rate of Q^-1(Psi) while the frame of Q moves (6.17, mended).

        Parameters
        ----------
        momentum : Multivector
            Psi.
        wrench : Multivector, optional
            Rate of Psi; default: zero.
        twist : Multivector, optional
            Omega, of the frame of Q. Default: Q^-1(Psi), the body's own; then this is Euler's equation, the rate of
            the body's twist as the world sees it.

        Returns
        -------
        Multivector
            Q^-1(dPsi + Omega x Psi) + Q^-1(Psi) x Omega, with the commutator. `SINGULAR` as for `inverse`.
        """
        psi = self._screw(momentum, "the momentum")
        frame_twist = self.inverse(psi) if twist is None else self._screw(twist, "the twist")
        load = self._zero(psi) if wrench is None else self._screw(wrench, "the wrench")
        return self._answer("inertia.velocity_rate", (psi, load, frame_twist), strict)

    def momentum_rate(
        self, velocity: Multivector, acceleration: Multivector | None = None, twist: Multivector | None = None,
        strict: bool = False,
    ) -> Multivector:  # fmt: skip
        """Rate of Q(V) while V changes at a rate (default zero) and the frame of Q moves with a twist (default V).

        For the body's own twist it is the wrench that causes the motion: inverse dynamics.
        """
        v = self._screw(velocity, "the velocity")
        frame_twist = v if twist is None else self._screw(twist, "the twist")
        rate = self._zero(v) if acceleration is None else self._screw(acceleration, "the acceleration")
        return finite_screw(self._evaluate("inertia.momentum_rate", v, rate, frame_twist)[0], "momentum_rate", strict)

    @overload
    def energy(self, twist: Multivector, *, status: Literal[False] = ..., strict: bool = ...) -> Array: ...
    @overload
    def energy(self, twist: Multivector, *, status: Literal[True], strict: bool = ...) -> tuple[Array, Statuses]: ...
    def energy(
        self, twist: Multivector, *, status: bool = False, strict: bool = False
    ) -> Array | tuple[Array, Statuses]:
        """Kinetic energy (...); NaN and, with ``status=True``, `INVALID` where the twist is not finite."""
        x = self._screw(twist, "the twist")
        energy: Array = plain(self._evaluate("inertia.energy", x)[0])[..., 0]
        return array_result(energy[()], x._status, "energy", status, strict)

    # -- properties --------------------------------------------------------------------------------

    @property
    def center(self) -> Array:
        """Center of mass (..., 3)."""
        return self._center_and_tensor()[0] + 0.0  # no -0.0

    @property
    def tensor(self) -> Array:
        """Tensor about the center of mass (..., 3, 3), along the axes of the frame of twists."""
        rows = self._center_and_tensor()[1]
        return rows.reshape(*rows.shape[:-1], 3, 3)

    def _center_and_tensor(self) -> tuple[Array, Array]:
        center, tensor = evaluate(
            self.algebra, "inertia.center_and_tensor", self.frame, self._moments(np.float64)
        ).values
        return plain(center), plain(tensor)

    def matrix(self) -> Array:
        """Matrix of Q (..., 6, 6), from (w, v) of twists to (f, tau) of momenta (6.14)."""
        rows: Array = evaluate(self.algebra, "inertia.inertia_matrix", self.frame, *self._numbers(np.float64)).value
        return rows.reshape(*rows.shape[:-1], 6, 6)

    def principal_screws(self) -> Multivector:
        """Principal screws of inertia (..., 6): lines of the principal axes, then the couples about them (6.4.4)."""
        screws = evaluate(self.algebra, "inertia.principal_screws", self.frame).values
        kind = self.algebra.layout("twist")
        rows = np.stack([x.as_kind(kind)._data for x in screws], -2)
        return self.algebra.wrap(kind, rows)

    def __repr__(self) -> str:
        if self.shape:
            return f"Inertia of {self.shape} bodies in {self.algebra.name}"
        moments = ", ".join(f"{x:.6g}" for x in self.moments)
        center = ", ".join(f"{x:.6g}" for x in self.center + 0.0)
        return f"Inertia: mass {self.mass:.6g}, principal moments ({moments}), center ({center}), {self.algebra.name}"

    # -- arguments -----------------------------------------------------------------------------------------

    def _motor(self, motor: Any) -> Multivector:
        as_instance(motor, "the motor", Multivector, f"a motor of {self.algebra.name}")
        self._check_home(motor, "the motor")
        unit: Multivector = self.algebra.as_motor(motor)
        return unit.as_kind("motor")

    def _check_home(self, x: Multivector, what: str) -> None:
        if x.algebra is not self.algebra:
            raise algebra_mismatch(
                f"{what} belongs to {x.algebra.name}, the inertia to {self.algebra.name}.", x, self.algebra
            )

    def _screw(self, x: Any, what: str) -> Multivector:
        screw = as_screw(x, what)
        self._check_home(screw, what)
        return screw

    def _zero(self, like: Multivector) -> Multivector:
        return twist(0, 0, self.algebra).astype(like.dtype)

    def _moments(self, dtype: Any) -> ArrayOperand:
        return ArrayOperand(self.moments.astype(dtype), self.algebra.kind("euclidean"), "the moments")

    def _numbers(self, dtype: Any) -> tuple[ArrayOperand, ArrayOperand]:
        return ArrayOperand(self.mass.astype(dtype), 0, "the mass"), self._moments(dtype)

    def _evaluate(self, formula: str, *screws: Multivector) -> tuple[Multivector, Any]:
        dtype = common_precision(*(s._data for s in screws))
        outcome = evaluate(self.algebra, formula, self.frame.astype(dtype), *self._numbers(dtype), *screws)
        return outcome.value, outcome.status

    def _answer(self, formula: str, screws: tuple[Multivector, ...], strict: bool) -> Multivector:
        value, status = self._evaluate(formula, *screws)
        invalid = merge_statuses(*(s._status for s in screws))
        if invalid is not None and status is not None:
            status = merge_statuses(np.broadcast_to(invalid, status.shape), status)
        screw = value._make(value._type, value._data, value.shape, status)
        return finite_screw(screw, formula.rpartition(".")[2], strict)


__all__ = ["Inertia"]
