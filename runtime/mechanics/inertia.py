"""Inertia of rigid bodies as a function from twists to momenta, in any frame (thesis 6.4).

The formulas are in `codegen.formulas`: `mechanics` and `inertia`.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from .. import arrays
from ..algebras import Algebra
from ..arrays import truth
from ..calls import Numbers, call, finite, merged, raise_first
from ..codegen.errors import AlgebraMismatchError, InputError, ShapeError
from ..euclidean import plain
from ..multivector import Multivector
from .given import positive
from .principal import principal
from .screws import Array, as_screw, geometry, twist
from .solids import mass_properties


class Inertia:
    """The inertia Q of a rigid body, or of a batch of them: momentum Psi = Q(Omega).

    Parameters
    ----------
    mass : float or array (...)
    moments : array (..., 3) or (..., 3, 3)
        Moments about the principal axes, or the symmetric tensor, about the centre of mass, mass included. What ends
        in (3, 3) is a tensor. One moment may be zero, as of a rod.
    motor : Multivector, optional
        Takes the frame of the moments, its origin at the centre of mass, to the frame that twists and momenta are in.
        Default: that frame itself.
    algebra : Algebra, optional
        `bladesmith.cga3d` (default) or `pga3d`, of a motor its own.

    Attributes
    ----------
    mass, moments : array
        Mass (...) and principal moments (..., 3).
    frame : Multivector
        Takes the frame of the principal axes to that of twists and momenta.
    center, tensor : array
        Centre of mass (..., 3), and the tensor about it (..., 3, 3), in the frame of twists.
    shape : tuple
        Of the batch.

    Raises
    ------
    InputError, ShapeError, AlgebraMismatchError
        If a mass or a moment is not positive, the tensor is not symmetric, or no body can have such moments: which
        item, and by how much.

    Notes
    -----
    In the frame of the principal axes Q(w I3 + v n) = m v I3 + (I w) n, in another R Q(~R Omega R) ~R (6.15, 6.16).
    The pair that is printed for PGA has wrong signs and moments, and is its own inverse all the same. Results have
    the precision of the screws that are given.
    """

    def __init__(
        self, mass: Any, moments: Any, motor: Multivector | None = None, algebra: Algebra | None = None
    ) -> None:
        home = motor.algebra if algebra is None and isinstance(motor, Multivector) else algebra
        self.algebra: Any = geometry(home)
        self.mass = positive(mass, "the mass")
        self.moments, axes = principal(moments, thin=True)
        self.frame: Multivector = self.algebra.motor_from_matrix(axes).as_kind("motor")
        if motor is not None:
            self.frame = self._motor(motor) * self.frame
        shapes = self.mass.shape, self.moments.shape[:-1], self.frame.shape
        try:
            self.shape: tuple[int, ...] = np.broadcast_shapes(*shapes)
        except ValueError:
            raise ShapeError(f"mass, moments and motor have shapes {shapes}, which do not broadcast.") from None

    @classmethod
    def from_mesh(cls, mesh: Any, density: Any = None, mass: Any = None, algebra: Algebra | None = None) -> Inertia:
        """Inertia of the solid inside a closed mesh, in the mesh's frame; arguments as of `mass_properties`."""
        found = mass_properties(mesh, density, mass)
        home: Any = geometry(algebra)
        return cls(found.mass, found.tensor, home.translator(found.center), home)

    def transformed(self, motor: Multivector) -> Inertia:
        """This inertia moved by a motor R: R Q(~R Omega R) ~R."""
        new = object.__new__(type(self))
        new.algebra, new.mass, new.moments = self.algebra, self.mass, self.moments
        new.frame = self._motor(motor) * self.frame
        try:
            new.shape = np.broadcast_shapes(self.shape, motor.shape)
        except ValueError:
            raise ShapeError(f"motors of shape {motor.shape} do not fit bodies of shape {self.shape}.") from None
        return new

    # -- the function, its inverse and rates ---------------------------------------------------------------

    def __call__(self, twist: Multivector) -> Multivector:
        """Momentum of a body that moves with a twist."""
        return finite(self._called("mechanics.momentum_in", self._screw(twist, "the twist"))[0])

    def inverse(self, momentum: Multivector, strict: bool = False) -> Multivector:
        """The twist that has a momentum. `SINGULAR`: a moment of inertia is zero."""
        return self._answer("inertia.velocity", (self._screw(momentum, "the momentum"),), strict)

    def rate(
        self, momentum: Multivector, wrench: Multivector | None = None, twist: Multivector | None = None,
        strict: bool = False,
    ) -> Multivector:  # fmt: skip
        """The rate of Q^-1(Psi) while the frame of Q moves (6.17, mended).

        Parameters
        ----------
        momentum : Multivector
            Psi.
        wrench : Multivector, optional
            The rate of Psi; default: zero.
        twist : Multivector, optional
            Omega, of the frame of Q. Default: Q^-1(Psi), the body's own; then this is Euler's equation, the rate of
            the body's twist as the world sees it.

        Returns
        -------
        Multivector
            Q^-1(dPsi + Omega x Psi) + Q^-1(Psi) x Omega, with the commutator. `SINGULAR` as for `inverse`.
        """
        psi = self._screw(momentum, "the momentum")
        own = self.inverse(psi) if twist is None else self._screw(twist, "the twist")
        load = self._none(psi) if wrench is None else self._screw(wrench, "the wrench")
        return self._answer("inertia.velocity_rate", (psi, load, own), strict)

    def momentum_rate(
        self, velocity: Multivector, acceleration: Multivector | None = None, twist: Multivector | None = None
    ) -> Multivector:
        """The rate of Q(V) while V changes at a rate (default zero) and the frame of Q moves with a twist (default V).

        Of the body's own twist it is the wrench that moves it so: inverse dynamics.
        """
        v = self._screw(velocity, "the velocity")
        own = v if twist is None else self._screw(twist, "the twist")
        rate = self._none(v) if acceleration is None else self._screw(acceleration, "the acceleration")
        return finite(self._called("inertia.momentum_rate", v, rate, own)[0])

    def energy(self, twist: Multivector) -> Array:
        """Kinetic energy (...)."""
        found: Array = plain(self._called("inertia.energy", self._screw(twist, "the twist"))[0])[..., 0]
        return found[()]

    # -- what it is made of --------------------------------------------------------------------------------

    @property
    def center(self) -> Array:
        """Centre of mass (..., 3)."""
        return self._center_and_tensor()[0] + 0.0  # no -0.0

    @property
    def tensor(self) -> Array:
        """The tensor about the centre of mass (..., 3, 3), along the axes of the frame of twists."""
        rows = self._center_and_tensor()[1]
        return rows.reshape(*rows.shape[:-1], 3, 3)

    def _center_and_tensor(self) -> tuple[Array, Array]:
        center, tensor = call(self.algebra, "inertia.center_and_tensor", self.frame, self._moments(np.float64)).values
        return plain(center), plain(tensor)

    def matrix(self) -> Array:
        """The matrix of Q (..., 6, 6), from (w, v) of twists to (f, tau) of momenta (6.14)."""
        rows: Array = call(self.algebra, "inertia.inertia_matrix", self.frame, *self._numbers(np.float64)).value
        return rows.reshape(*rows.shape[:-1], 6, 6)

    def principal_screws(self) -> Multivector:
        """Principal screws of inertia (..., 6): lines of the principal axes, then the couples about them (6.4.4)."""
        found = call(self.algebra, "inertia.principal_screws", self.frame).values
        kind = self.algebra.layout("twist")
        rows = np.stack([x.as_kind(kind)._data for x in found], -2)
        return self.algebra.wrap(kind, rows)  # type: ignore[no-any-return]

    def __repr__(self) -> str:
        if self.shape:
            return f"Inertia of {self.shape} bodies in {self.algebra.name}"
        moments = ", ".join(f"{x:.6g}" for x in self.moments)
        center = ", ".join(f"{x:.6g}" for x in self.center + 0.0)
        return f"Inertia: mass {self.mass:.6g}, principal moments ({moments}), centre ({center}), {self.algebra.name}"

    # -- arguments -----------------------------------------------------------------------------------------

    def _motor(self, motor: Any) -> Multivector:
        if not isinstance(motor, Multivector):
            raise InputError(f"the motor is a {type(motor).__name__}; a motor of {self.algebra.name} is needed.")
        self._check_home(motor, "the motor")
        found: Multivector = self.algebra.as_motor(motor)
        return found.as_kind("motor")

    def _check_home(self, x: Multivector, what: str) -> None:
        if x.algebra is not self.algebra:
            raise AlgebraMismatchError(f"{what} belongs to {x.algebra.name}, the inertia to {self.algebra.name}.")

    def _screw(self, x: Any, what: str) -> Multivector:
        found = as_screw(x, what)
        self._check_home(found, what)
        return found

    def _none(self, like: Multivector) -> Multivector:
        return twist(0, 0, self.algebra).astype(like.dtype)

    def _moments(self, dtype: Any) -> Numbers:
        return Numbers(self.moments.astype(dtype), self.algebra.kind("euclidean"), "the moments")

    def _numbers(self, dtype: Any) -> tuple[Numbers, Numbers]:
        return Numbers(self.mass.astype(dtype), 0, "the mass"), self._moments(dtype)

    def _called(self, formula: str, *screws: Multivector) -> tuple[Multivector, Any]:
        dtype = arrays.precision(*(s._data for s in screws))
        outcome = call(self.algebra, formula, self.frame.astype(dtype), *self._numbers(dtype), *screws)
        return outcome.value, outcome.status

    def _answer(self, formula: str, screws: tuple[Multivector, ...], strict: bool) -> Multivector:
        value, status = self._called(formula, *screws)
        invalid = merged(*(s._status for s in screws))
        if invalid is not None and status is not None:
            status = merged(np.broadcast_to(invalid, status.shape), status)
        found = finite(value._make(value._type, value._data, value.shape, status))
        if truth(strict, "strict"):
            raise_first(found._status, formula.rpartition(".")[2])
        return found


__all__ = ["Inertia"]
