"""Declarations of kernels in specs: formulas by name, operands by kind, and the spec of a plain algebra."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from . import formulas
from .algebra.algebra import Algebra, Kind, numbers, orthonormal, scalar_argument
from .algebra.blades import validated_identifier
from .algebra.loader import data_from_algebra
from .errors import SpecError, suggest
from .trace.kernel import Formula, argument_names


@dataclass(frozen=True)
class Declaration:
    """A kernel of a spec: the operation it serves, its name, its formula and its operands."""

    serves: str
    name: str
    formula: Formula
    operands: tuple[str, ...]
    kinds: tuple[Kind, ...]

    @property
    def module(self) -> str:
        """The module of formulas that it is written in."""
        return self.formula.__module__.rpartition(".")[2]

    @property
    def formula_name(self) -> str:
        """The formula as ``module.function``."""
        return f"{self.module}.{self.formula.__name__}"


def by_module(declared: Sequence[Declaration]) -> dict[str, list[Declaration]]:
    """Declarations by the module of their formula, in the order of their first kernel."""
    modules: dict[str, list[Declaration]] = {}
    for each in declared:
        modules.setdefault(each.module, []).append(each)
    return modules


def declared_kernels(algebra: Algebra, entries: Sequence[Mapping[str, Any]]) -> list[Declaration]:
    """Declarations of the kernels of a spec.

    Raises
    ------
    SpecError
        If a formula is unknown, a name is not an identifier, or two kernels share a name.
    """
    declarations: dict[str, Declaration] = {}
    for entry in entries:
        formula = formula_by_name(entry["formula"])
        for operands in entry["operands"]:
            kinds = [operand_kind(algebra, text) for text in operands]
            names = argument_names(formula)
            if len(kinds) != len(names):
                raise SpecError(
                    f"{entry['formula']} takes {len(names)} operands ({', '.join(names)}), not {len(kinds)}."
                )
            base = entry.get("name") or entry["formula"].rpartition(".")[2]
            parts = [base, *(text.replace("layout ", "any_").replace(" ", "") for text in operands)]
            name = validated_identifier("_".join(parts), "a kernel's name")
            if name in declarations:
                raise SpecError(f"the spec of {algebra.name} declares the kernel {name!r} twice.")
            serves = entry.get("serves") or entry["formula"]
            declarations[name] = Declaration(serves, name, formula, tuple(map(str, operands)), tuple(kinds))
    return list(declarations.values())


def operand_kind(algebra: Algebra, text: str) -> Kind:
    """Kind of an operand as specs write it: ``motor``, ``layout circle``, ``number``, ``numbers 9``."""
    words = str(text).split()
    match words:
        case ["number"]:
            return scalar_argument(algebra)
        case ["numbers", count] if count.isdigit():
            return numbers(algebra, int(count))
        case ["layout", name]:
            return algebra.layout(name)
        case [name]:
            return algebra.kind(name)
    raise SpecError(f"operand {text!r} is not `kind`, `layout kind`, `number` or `numbers n`.")


def formula_by_name(name: str) -> Formula:
    """A function of `codegen.formulas`, named ``module.function``.

    Raises
    ------
    SpecError
        If there is none of that name.
    """
    module_name, _, function = str(name).partition(".")
    validated_identifier(module_name, "a formula's module")
    validated_identifier(function, "a formula's function")
    try:
        module = formulas.load(module_name)
    except LookupError:
        raise SpecError(f"there is no module of formulas {module_name!r} (in {name!r}).") from None
    except (ImportError, SyntaxError) as error:
        raise SpecError(f"the formulas {module_name!r} cannot be imported: {error}.") from None
    formula = getattr(module, function, None)
    if not callable(formula) or getattr(formula, "__module__", None) != module.__name__:
        public = [n for n in vars(module) if not n.startswith("_")]
        raise SpecError(f"{module_name} has no formula {function!r}{suggest(function, public)}.")
    return formula  # type: ignore[no-any-return]


def plain_spec(p: int, q: int, r: int, name: str) -> dict[str, Any]:
    """Spec of Cl(p, q, r) on orthonormal vectors, with dense products (to 6 dimensions) and vector products."""
    data = data_from_algebra(orthonormal(p, q, r, name))
    data["kernels"] = plain_kernels(p + q + r)
    return data


#: Dense products beyond this dimension are left to the general kernel: 4^n terms each.
DENSE_DIMENSION = 5


def plain_kernels(dimension: int) -> list[dict[str, Any]]:
    """Kernels of a plain algebra."""
    kinds = ["multivector", "even"] if dimension <= DENSE_DIMENSION else []
    products = ("geometric", "outer", "inner")
    entries: list[dict[str, Any]] = [
        {"formula": f"products.{p}", "operands": [[k, k] for k in [*kinds, "vector"]]} for p in products
    ]
    if kinds:
        entries.append({"formula": "products.sandwich", "operands": [["even", "vector"]]})
    return entries
