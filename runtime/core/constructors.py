"""What every algebra makes: multivectors of a grade, random members of kinds, basis blades by name."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cached_property
from typing import Any, Generic, SupportsIndex, overload

import numpy as np
from numpy.typing import NDArray

from ..codegen.algebra.algebra import Kind
from ..codegen.algebra.members import NumericSource, sample
from ..codegen.errors import InputError
from ..common.dtypes import F64, as_precision
from ..common.validation import as_int, as_shape
from ..dispatch.types import Blade, TypedAlgebra
from . import construction
from .cayley import CayleyTable
from .operators import P


class BasisBlades(tuple[Blade, ...], Generic[P]):
    """All basis blades in storage order; by name each is a multivector, ``blades["e12"]``.

    ``globals().update(alg.blades)`` makes variables of all but the scalar.
    """

    algebra: Constructors[P]

    @overload
    def __getitem__(self, key: str) -> P: ...
    @overload
    def __getitem__(self, key: SupportsIndex) -> Blade: ...
    @overload
    def __getitem__(self, key: slice) -> tuple[Blade, ...]: ...
    def __getitem__(self, key: Any) -> Any:
        return self.algebra.basis_blade(key) if isinstance(key, str) else super().__getitem__(key)

    def keys(self) -> list[str]:
        """Names of the blades, without that of the scalar."""
        return [blade.name for blade in self if blade]

    def __reduce__(self) -> tuple[Any, ...]:
        return getattr, (self.algebra, "blades")


class Constructors(TypedAlgebra, Generic[P]):
    """An algebra as the maker of multivectors; `core.multivector.Algebra` is the one that users hold."""

    def multivector(self, values: Any, *arguments: Any, **options: Any) -> P:
        """Multivectors from coefficients; see `core.multivector.Algebra.multivector`."""
        raise NotImplementedError

    def symbols(self, name: str = "x", kind: str | Kind | None = None, grades: Iterable[int] | None = None) -> Any:
        """A symbolic multivector; see `core.multivector.Algebra.symbols`."""
        raise NotImplementedError

    def wrap(self, kind: Kind, values: NDArray[Any], status: NDArray[np.uint8] | None = None) -> P:
        """Rows of coefficients as multivectors; see `core.multivector.Algebra.wrap`."""
        raise NotImplementedError

    # -- of one grade --------------------------------------------------------------------------------------

    def vector(self, values: Any = None, dtype: Any = None, *, name: str | None = None, **coefficients: Any) -> P:
        """Vectors from coefficients (..., n) in the order of the basis vectors, or by name: ``vector(e1=2.0, e3=1.0)``.

        A dictionary is as good as names. ``vector(name="u")`` has symbols for coefficients, as `symbols` makes them.
        """
        return self._of_grade(1, values, dtype, name, coefficients)

    def bivector(self, values: Any = None, dtype: Any = None, *, name: str | None = None, **coefficients: Any) -> P:
        """Bivectors from coefficients (..., k) in storage order (e12, e13, ...), or by name; see `vector`."""
        return self._of_grade(2, values, dtype, name, coefficients)

    def trivector(self, values: Any = None, dtype: Any = None, *, name: str | None = None, **coefficients: Any) -> P:
        """Trivectors; parameters as of `vector`."""
        return self._of_grade(3, values, dtype, name, coefficients)

    def pseudoscalar(self, value: Any = 1.0, dtype: Any = None) -> P:
        """Numbers times `I`."""
        blade = self.multivector({self.named_blades[self.full_blade]: value}, dtype=dtype)
        return blade if self.pseudoscalar_sign > 0 else -blade

    @property
    def I(self) -> P:  # noqa: E743
        """The unit pseudoscalar: the blade of all vectors, in the order that duals are taken with."""
        return self.pseudoscalar()

    def _of_grade(self, grade: int, values: Any, dtype: Any, name: str | None, coefficients: dict[str, Any]) -> P:
        if name is not None:
            if values is not None or coefficients or dtype is not None:
                raise InputError("name= makes symbols: there are no other values with it.")
            return self.symbols(name, grades=[grade])  # type: ignore[no-any-return]
        if not coefficients and not isinstance(values, dict):
            return self.multivector(values, grades=[grade], dtype=dtype)
        x = self.multivector(values, dtype=dtype, **coefficients)
        if set(x.grades) - {grade}:
            wrong = next(blade for blade in x.blades if blade.grade != grade)
            raise InputError(f"{wrong} is not of grade {grade}.", remedy="Use alg.multivector for mixed grades")
        return x

    # -- blades by name ------------------------------------------------------------------------------------

    @cached_property
    def blades(self) -> BasisBlades[P]:
        """All basis blades in storage order: bit masks that print as names, and multivectors by name."""
        blades: BasisBlades[P] = BasisBlades(super().blades)
        blades.algebra = self
        return blades

    def basis_blade(self, name: str) -> P:
        """The blade of a name, in the sign of the name's order of vectors: "e21" is -e12.

        Raises
        ------
        BladeError
            If the name is none.
        """
        blade, sign = self.parse_blade(name)
        return self.multivector({self.named_blades[blade]: float(sign)})

    def cayley(self, operation: str = "geometric") -> CayleyTable:
        """The table of a product of all basis blades, up to eight dimensions; it prints as one.

        Rows are the left factor, columns the right one.

        Parameters
        ----------
        operation : str
            "geometric", "outer", "inner", "left_contraction", "right_contraction", "scalar_product", "commutator",
            "anticommutator" or "regressive".
        """
        return CayleyTable(self, operation)

    # -- random members ------------------------------------------------------------------------------------

    def random(
        self,
        kind: str | Kind = "multivector",
        n: int | tuple[int, ...] | None = None,
        seed: int | np.random.Generator | None = None,
        dtype: Any = None,
    ) -> P:
        """Random members of a kind: exact ones up to rounding, so that unit versors are unit.

        Parameters
        ----------
        kind : str or Kind
            Default: all blades, in up to ten dimensions.
        n : int or tuple of int, optional
            Number of items, or shape of the batch. Default: a single multivector.
        seed : int or numpy.random.Generator, optional
            The same seed gives the same multivectors.
        dtype : float64 or float32, optional

        Raises
        ------
        KindError, ShapeError, InputError
            If there is no such kind; if ``n`` or ``seed`` is none.

        Notes
        -----
        Free coefficients are normal with deviation 1; those of constrained kinds are made of such numbers by the
        kind's member, which is no uniform distribution over the kind.
        """
        wanted = construction.as_kind(self, kind)
        lead = () if n is None else as_shape(n, "n")
        count = int(np.prod(lead, dtype=np.int64))
        if not isinstance(seed, np.random.Generator) and seed is not None:
            seed = as_int(seed, "seed", 0)
        member = sample(wanted, NumericSource(count, seed))
        data = np.empty((count, wanted.size))
        for i, value in enumerate(wanted.values(member)):
            data[:, i] = value
        precision = as_precision(dtype) or F64
        return self.wrap(wanted, data.reshape(*lead, wanted.size).astype(precision))
