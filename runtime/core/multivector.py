"""Multivectors and algebras as users hold them.

A `Multivector` adds to its data (`dispatch.multivector_data`) the operators and the functions of the core. An `Algebra`
makes multivectors from numbers. Each is in the other's signatures: therefore they share a module.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any, ClassVar, Literal, overload

import numpy as np
from numpy.typing import NDArray

from ..codegen.algebra.algebra import Kind
from ..codegen.algebra.blades import validated_identifier
from ..codegen.algebra.loader import algebra_from_data
from ..codegen.errors import BladeError, GradeError, InputError, suggest
from ..common.deprecation import renamed_attribute
from ..common.dtypes import F64, as_precision
from ..common.rich_display import Displayed
from ..common.validation import as_bool, as_choice, real_array
from ..dispatch.arrays.backends import Backend, Node, backend_of
from ..dispatch.arrays.types import wrap
from ..dispatch.item_statuses import array_result
from ..dispatch.multivector_data import Statuses
from ..dispatch.stock_kernels import StockKernels
from . import construction, formatting, interning, kind_constraints, linear_maps
from .arrays import multivector as arrays
from .attribute_names import DIRECTORY, listed
from .constructors import Constructors
from .functions import exponentials, inverses, norms, powers
from .geometry.parameters import FIELDS
from .operators import Number, Operators

if TYPE_CHECKING:
    from .geometry.parameters import Parameters
    from .outermorphisms import Outermorphism
    from .symbolic.multivector import SymbolicMultivector


#: The representation of motors by matrices on homogeneous coordinates of points.
HOMOGENEOUS = "homogeneous"


class Multivector(Operators, Displayed):
    """Multivectors of one kind: ``shape`` of them, as rows of coefficients. Made by an algebra, not directly.

    Operators: ``a * b`` geometric, ``a ^ b`` outer, ``a | b`` inner product, ``a & b`` meet (in PGA: join), ``~a``
    reverse, ``R >> x`` sandwich R x ~R, ``a + b``, ``a - b``, ``2 * a``, ``a / 2``, ``a / b``. Numbers and arrays of
    numbers broadcast over items, not over coefficients.
    """

    __slots__ = ()

    @property
    def algebra(self) -> Algebra:
        """The algebra it belongs to."""
        return self._type.algebra  # type: ignore[return-value]

    if not TYPE_CHECKING:  # else any name would be an attribute

        def __getattr__(self, name: str) -> Any:
            where = f"; objects that have one give it as .parameters().{name}" if name in FIELDS else ""
            raise AttributeError(f"'Multivector' object has no attribute {name!r}{where}", name=name, obj=self)

    # -- functions -----------------------------------------------------------------------------------------

    @overload
    def norm(self, *, status: Literal[False] = ..., strict: bool = ...) -> NDArray[Any]: ...
    @overload
    def norm(self, *, status: Literal[True], strict: bool = ...) -> tuple[NDArray[Any], Statuses]: ...
    def norm(self, *, status: bool = False, strict: bool = False) -> NDArray[Any] | tuple[NDArray[Any], Statuses]:
        """``sqrt |<x ~x>_0|`` of each item; (norm, status) if requested, ``strict`` raises instead of giving NaN."""
        return array_result(norms.norm(self), self._status, "norm", status, strict)

    def normalized(
        self, kind: str | Kind | None = None, strict: bool = False, tolerance: float | None = None
    ) -> Multivector:
        """Each item at unit scale, of a constrained kind where that holds; see `norms.normalized`.

        With a ``tolerance`` the nearest member of the kind, and how far that is in `deviation`.
        """
        return norms.normalized(self, kind, strict, tolerance)

    normalised = normalized

    def __abs__(self) -> NDArray[Any]:
        """`norm` of each item."""
        return self.norm()

    def __pos__(self) -> Multivector:
        return self

    def inverse(self, method: str = "auto", strict: bool = False) -> Multivector:
        """The y with x y = 1; `SINGULAR` without one. ``method``: "auto", "shirokov", "hitzer" or "matrix"."""
        return inverses.inverse(self, method, strict)

    def exp(self, strict: bool = False) -> Multivector:
        """Exponential: a motor from the bivector of a motion, a series for anything else."""
        return exponentials.exp(self, strict)

    def log(self, strict: bool = False) -> Multivector:
        """The bivector whose exponential is this motor; its angle lies in [0, 2 pi)."""
        return exponentials.log(self, strict)

    def sqrt(self, strict: bool = False) -> Multivector:
        """The motor of half the motion."""
        return exponentials.sqrt(self, strict)

    def reflect(self, mirror: Multivector, strict: bool = False) -> Multivector:
        """This object reflected, or inverted, in a blade."""
        return norms.reflect(self, mirror, strict)

    def __truediv__(self, other: Any) -> Multivector:
        return self * other.inverse() if isinstance(other, Operators) else super().__truediv__(other)  # type: ignore[attr-defined]

    def __rtruediv__(self, other: Any) -> Multivector:
        return self.inverse().__rmul__(other)

    def __pow__(self, exponent: Any) -> Multivector:
        """A power: of whole numbers the product, else exp(exponent log(x)), for what has a logarithm; see `power`."""
        return powers.power(self, exponent)

    def __rpow__(self, base: Any) -> Multivector:
        """``e ** B`` is exp(B), and other positive numbers are powers of e."""
        return powers.power_of_number(base, self)

    def power(self, exponent: Any, strict: bool = False) -> Multivector:
        """``x ** exponent``, of whole numbers by products, of other numbers and arrays of them by exp and log.

        Negative powers are those of the inverse, with its statuses. An array of exponents broadcasts over the items:
        ``R ** np.linspace(0, 1, 5)`` are five steps from the identity to R.
        """
        return powers.power(self, exponent, strict)

    # -- comparison and conversion -------------------------------------------------------------------------

    def isclose(
        self, other: Multivector | Number, rtol: float | None = None, atol: float = 0.0
    ) -> np.bool_ | NDArray[np.bool_]:
        """For each item, whether the coefficients differ by at most ``atol + rtol * largest coefficient``.

        ``rtol`` is 1e-9 by default, 1e-4 in single precision.
        """
        lifted = other if isinstance(other, Multivector) else self.algebra.scalar(other)
        if rtol is None:
            rtol = 1e-9 if self.dtype == lifted.dtype == F64 else 1e-4
        return linear_maps.is_close(self, lifted, rtol, atol)[()]

    def as_kind(self, kind: str | Kind, check: bool = True) -> Multivector:
        """Convert to another kind of the algebra; `KindError` if an item does not belong to it.

        ``kind`` is a kind or its name; constraints are checked within `kind_constraints.tolerance`, unless they are
        proved by the kind that it has.
        """
        return kind_constraints.convert_to_kind(self, construction.as_kind(self.algebra, kind), check)

    def to_basis(self, basis: str = "orthonormal") -> Multivector:
        """This in the algebra of the same signature on orthonormal vectors (in CGA e4 = e+, e5 = e-)."""
        from .conversion import basis_change

        target = self.algebra.on_basis(basis)
        return self if target is self.algebra else basis_change.convert(self, target)

    def to_clifford(self, layout: Any = None) -> Any:
        """This as a multivector (an array of them, for a batch) of the package `clifford`."""
        from .conversion import clifford_layouts

        return clifford_layouts.to_clifford(self.to_basis(), layout)

    def parameters(self) -> Parameters:
        """Parameters of the constructor of this kind of object, as a named tuple; see the algebra's ``parameters``."""
        return self.algebra.parameters(self)

    @overload
    def to_matrix(
        self, representation: str = ..., *, status: Literal[False] = ..., strict: bool = ...
    ) -> NDArray[Any]: ...
    @overload
    def to_matrix(
        self, representation: str = ..., *, status: Literal[True], strict: bool = ...
    ) -> tuple[NDArray[Any], Statuses]: ...
    def to_matrix(
        self, representation: str = HOMOGENEOUS, *, status: bool = False, strict: bool = False
    ) -> NDArray[Any] | tuple[NDArray[Any], Statuses]:
        """The 4 x 4 matrix of a motor, or of another versor that keeps points points; options as of `norm`.

        Or a matrix that stands for any multivector: ``representation`` "left" or "right", of its products with others,
        "complex", the smallest complex ones (Pauli's, for three vectors); see `representations.to_matrix`.
        """
        if representation == HOMOGENEOUS:
            return array_result(self.algebra.matrix(self), self._status, "to_matrix", status, strict, 2)
        from .conversion import representations

        return array_result(
            representations.to_matrix(self, representation), self._status, "to_matrix", status, strict, 2
        )

    # -- as formulas see it --------------------------------------------------------------------------------

    @property
    def terms(self) -> dict[int, NDArray[Any]]:
        """Coefficients by blade, as the code generator's multivectors have them: formulas can run on both."""
        return {blade: self._data[..., i] for i, blade in enumerate(self._type.blades)}

    def constant(self, value: float) -> Multivector:
        """A scalar of the same algebra and precision."""
        return self.algebra.scalar(float(value), self.dtype)

    def scale_blades(self, weight: Callable[[int], float]) -> Multivector:
        """Each blade's coefficient times a number that depends on the blade."""
        weights = np.array([float(weight(blade)) for blade in self._type.blades], self.dtype)
        return self._make(self._type.unconstrained, self._data * weights, self._lead)

    scaled = renamed_attribute("scale_blades")

    # -- objects -------------------------------------------------------------------------------------------

    def __reduce__(self) -> tuple[Any, ...]:
        kind = self.kind
        return _rebuilt, (self.algebra, kind.name, kind.blades, kind.is_layout, self._data, self._status)

    def __repr__(self) -> str:
        return formatting.plain(self)

    def _repr_latex_(self) -> str:
        return formatting.latex(self)


class Algebra(Constructors[Multivector]):
    """A geometric algebra whose multivectors hold numbers. Made by `algebra`, or one of the stock ones.

    Basis blades are attributes: ``alg.e12``, ``cga.ni``.

    Attributes
    ----------
    blades : BasisBlades
        All basis blades in storage order: by grade, then by index. They are bit masks that print as names; by name,
        ``alg.blades["e12"]``, each is a multivector.
    kinds : dict of str to Kind
    signature : (p, q, r)
    """

    multivector_class = Multivector
    #: Gives Cl(p, q, r); set by `registry`, which makes each algebra once.
    _by_signature: ClassVar[Callable[[int, int, int], Algebra]]
    #: Kernels that were generated for this algebra.
    stock: StockKernels | None
    _origin: tuple[Callable[..., Algebra], tuple[Any, ...]] | None = None

    def remember(self, maker: Callable[..., Algebra], *arguments: Any) -> None:
        """Pickle this algebra as a call that gives it back."""
        self._origin = maker, arguments

    @classmethod
    def from_data(cls, data: Mapping[str, Any]) -> Algebra:
        """An algebra with its kinds from plain data, as in a spec or a manifest."""
        plain = algebra_from_data(data)
        new = cls(plain.name, plain.vectors, plain.metric, plain.pseudoscalar_name)
        new.kinds.update({name: replace(kind, algebra=new) for name, kind in plain.kinds.items()})
        return new

    # -- multivectors --------------------------------------------------------------------------------------

    def multivector(
        self,
        values: Any = None,
        grades: Iterable[int] | None = None,
        *,
        blades: Iterable[Any] | None = None,
        kind: str | Kind | None = None,
        basis: str | None = None,
        dtype: Any = None,
        copy: bool = True,
        **coefficients: Any,
    ) -> Multivector:
        """Multivectors from coefficients.

        Parameters
        ----------
        values : dict, array of shape (..., k), or Multivector
            A dictionary gives arrays by blade: a name in any order of vectors (``"e21"`` is ``-e12``), a tuple
            (``(1, 12)``) or a `Blade`; the arrays broadcast. An array holds k coefficients per item: of the blades
            of ``grades``, of ``blades``, of ``kind``, or of all blades of the algebra, in storage order. A
            multivector of an algebra of the same signature is converted. With SymPy expressions among the values the
            result is a `SymbolicMultivector`.
        grades : iterable of int, optional
        blades : iterable of str, tuple or Blade, optional
        kind : str or Kind, optional
            Kind of the result; its constraints are checked.
        basis : "orthonormal", optional
            The names, or the order of the values, are those of orthonormal vectors (in CGA e4 = e+, e5 = e-).
        dtype : float64 or float32, optional
        copy : bool
            False: the multivector is a view of an array, or of what has a buffer, ``__array__`` or ``__dlpack__`` on
            the host. Its kind is a layout, since others may write to the array, and its `values` are writable where
            the array is. JAX arrays and PyTorch tensors are never copied; see :doc:`/algebra/arrays`.
        **coefficients
            Instead of a dictionary, by blade: ``multivector(e1=2.0, e12=[1.0, 3.0])``.

        Raises
        ------
        BladeError, KindError, ShapeError, InputError
            For unknown blades, items that are not of the kind, shapes that do not fit, values that are no numbers; for
            an array that cannot be shared where ``copy`` is False.
        """
        from .conversion import basis_change

        if (values is None) != bool(coefficients):
            raise InputError(
                "a multivector has coefficients of blades by name, or values.",
                remedy='Write multivector(e1=2.0), multivector({"e1": 2.0}) or multivector(values, grades=[1])',
            )
        values = coefficients or values
        precision = as_precision(dtype)
        if as_bool(copy, "copy") is False and backend_of(values) is None:
            if basis is not None or precision is not None:
                raise InputError("basis= and dtype= need a copy; leave out copy=False.")
            return self._on_shared(*construction.shared_array(self, values, grades, blades, kind))
        if construction.has_expressions(values):
            return construction.symbolic(self, values, grades, blades, kind, basis, dtype)  # type: ignore[no-any-return]
        x: Any = arrays.from_any(self, values, grades, blades, kind, basis)
        if x is not None:
            pass
        elif isinstance(values, Multivector):
            x = values if values.algebra is self else basis_change.from_algebra(self, values)
        elif basis is not None:
            other = self.on_basis(basis)
            x = other.multivector(values, grades, blades=blades)
            x = x if other is self else basis_change.from_algebra(self, x)
        elif isinstance(values, Mapping):
            x = self.wrap(*construction.from_mapping(self, values))
        else:
            x = self.wrap(*construction.from_array(self, values, grades, blades, kind))
        x = x if precision is None else x.astype(precision)
        return x if kind is None else x.as_kind(kind)  # type: ignore[no-any-return]

    def _on_shared(self, layout: Kind, rows: NDArray[Any]) -> Multivector:
        """Multivectors on memory that others may write to."""
        shared = self.wrap(layout, rows)
        shared._is_open = True  # nothing of the numbers is kept
        return shared

    def on_basis(self, basis: str = "orthonormal") -> Algebra:
        """The algebra of the same signature on orthonormal vectors.

        Raises
        ------
        InputError
            If ``basis`` is another word.
        """
        from .conversion import basis_change

        as_choice(basis, "basis", ("orthonormal",))
        return self if basis_change.is_orthonormal(self) else Algebra._by_signature(*self.signature)

    def scalar(self, value: Any, dtype: Any = None) -> Multivector:
        """Scalars from an array of numbers."""
        if (backend := backend_of(value)) is not None:
            on_array = wrap(self, self.scalar_layout, backend.floating(value, "the scalar")[..., None], backend)
            return on_array if dtype is None else on_array.astype(dtype)  # type: ignore[no-any-return]
        data = real_array(value, "the scalar")
        data = np.array(data, dtype=as_precision(dtype) or data.dtype)[..., None]
        return Multivector._make(self.type_of(self.scalar_layout, data.dtype), data, data.shape[:-1])

    def wrap(self, kind: Kind, values: NDArray[Any], status: NDArray[np.uint8] | None = None) -> Multivector:
        """Results of a compiled kernel as multivectors; the array is taken over, not copied where it is native."""
        if not values.dtype.isnative:
            values = values.astype(values.dtype.newbyteorder("="))
        return Multivector._make(self.type_of(kind, values.dtype), values, values.shape[:-1], status)

    def symbols(
        self, name: str = "x", kind: str | Kind | None = None, grades: Iterable[int] | None = None
    ) -> SymbolicMultivector:
        """A symbolic multivector whose coefficients are SymPy symbols ``x_e12``, for formulas in GA notation."""
        import sympy

        from .symbolic.multivector import from_expressions

        name = validated_identifier(name, "a symbol's name")
        graded = kind is None
        layout = construction.layout_for(self, grades, None, None)[0] if graded else construction.as_kind(self, kind)
        blades = layout.blades
        symbols = [sympy.Symbol(f"{name}_{self.blade_name(b)}" if b else name, real=True) for b in blades]
        return from_expressions(self, dict(zip(blades, symbols, strict=True)))

    def from_matrix(self, matrix: Any, representation: str = HOMOGENEOUS) -> Multivector:
        """Multivectors from matrices (..., d, d) of `Multivector.to_matrix`, of the same ``representation``.

        Raises
        ------
        InputError
            If a matrix is that of no multivector of the algebra.
        """
        from .conversion import representations

        if representation == HOMOGENEOUS:
            motor: Multivector = representations.as_homogeneous(self)(self, matrix)
            return motor
        made: Multivector = representations.from_matrix(self, matrix, representation)
        return made

    def reciprocal_frame(self, frame: Multivector, strict: bool = False) -> Multivector:
        """The reciprocal frame of vectors (..., k), in their span: a_i . a^j = 1 where i = j, and 0 elsewhere.

        SINGULAR: they are dependent, or their span has a degenerate metric.
        """
        from .frames import reciprocal_frame

        return reciprocal_frame(self, frame, strict)

    def outermorphism(self, given: Any) -> Outermorphism[Multivector]:
        """A linear map of vectors, extended to all blades.

        Parameters
        ----------
        given : array (n, n), function, or Multivector
            A matrix on coefficients of vectors; a function that gives the image of a vector; or a versor R, of which
            the map is x -> R x R^-1, for odd ones the reflection x -> -R x R^-1.
        """
        from .outermorphisms import outermorphism

        return outermorphism(self, given)

    # -- geometry, where the algebra has one ---------------------------------------------------------------

    def parameters(self, x: Multivector) -> Parameters:
        """Parameters of a geometric object.

        Raises
        ------
        GradeError
            If the algebra stands for no geometry.
        """
        raise GradeError(f"{self.name} has no geometric objects; they are those of cga3d and pga3d.")

    def matrix(self, x: Multivector) -> NDArray[Any]:
        """Matrix of a versor's action on points.

        Raises
        ------
        GradeError
            If the algebra stands for no geometry.
        """
        from .conversion.representations import OTHER_MATRICES

        raise GradeError(
            f"{self.name} has no points to act on; they are those of cga3d and pga3d.", remedy=OTHER_MATRICES
        )

    # -- objects -------------------------------------------------------------------------------------------

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_") or name == "vectors":
            raise AttributeError(name)
        try:
            return self.basis_blade(name)
        except BladeError as error:
            near = suggest(name, [known for known in listed(super().__dir__()) if not known.startswith("_")])
            raise AttributeError(f"{self.name} has no {name!r}{near}, and it is not a blade: {error}") from None

    def __dir__(self) -> list[str]:
        return [*listed(super().__dir__()), *(self.blades.keys() if self.dimension <= DIRECTORY else [])]

    def __reduce__(self) -> tuple[Any, ...]:
        if self._origin:
            return self._origin
        return interning.keep(self)

    @classmethod
    def intern(cls, data: Mapping[str, Any]) -> Algebra:
        """The one algebra of this class, in this process, of plain data."""
        return interning.intern(cls, data)


def _rebuilt(
    algebra: Algebra, name: str, blades: tuple[int, ...], is_layout: bool, data: NDArray[Any], status: Any
) -> Multivector:
    """Rebuild a pickled multivector; its kind is looked up by name, so that no code travels."""
    kind = algebra.layout_of(blades) if is_layout else algebra.kind(name)
    return Multivector._make(algebra.type_of(kind, data.dtype), data, data.shape[:-1], status)


Backend.nodes.append(Node(Multivector, arrays.flatten, arrays.unflatten))
