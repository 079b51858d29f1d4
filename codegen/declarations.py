"""Declarations of kernels in specs: formulas by name, operands by kind, and the spec of a plain algebra."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from . import formulas
from .algebra.algebra import Algebra, Kind, numbers, orthonormal, scalar_argument
from .algebra.blades import validated_identifier
from .algebra.loader import PRESETS, STOCK, algebra_from_data, data_from_algebra
from .errors import SpecError, suggest
from .trace.kernel import Formula, argument_names
from .version import site_page


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


@dataclass(frozen=True)
class Omission:
    """Names that a plain algebra is without, and why.

    Attributes
    ----------
    what : {"kernels", "kinds"}
    names : tuple of str
        Kernels as in OPERATIONS.md; kinds.
    reason : str
    """

    what: str
    names: tuple[str, ...]
    reason: str

    def __str__(self) -> str:
        return f"no {self.what} {', '.join(self.names)}: {self.reason}"


def omissions(p: int, q: int, r: int) -> list[Omission]:
    """What the folder of a plain algebra is without, of kernels and kinds that others have.

    Parameters
    ----------
    p, q, r : int
        As for `plain_spec`.
    """
    n = p + q + r
    algebra = algebra_from_data(plain_spec(p, q, r, "plain"))
    kinds = [kind for kind in _plain_kinds() if kind not in algebra.kinds]
    kernels = {d.name for d in declared_kernels(algebra, plain_kernels(n))}
    dense = tuple(d.name for d in _largest() if d.name not in kernels)
    high, wide, other = (
        tuple(name for name in kinds if name in group)
        for group in (("bivector", "trivector", "quadvector"), ("even", "odd", "multivector"), ("pseudoscalar",))
    )
    top = next((k.name for k in algebra.kinds.values() if k.blades == ((1 << n) - 1,)), "")
    found = [
        Omission("kernels", dense, f"dense products in {n} dimensions have up to {4**n} terms; they run by table"),
        Omission("kinds", high, f"grades go to {n}"),
        Omission("kinds", other, f"that grade is called {top}"),
        Omission(
            "kinds", wide, f"these layouts have up to {2**n} coefficients; name the blades or grades that are meant"
        ),
    ]
    return [each for each in found if each.names] + [_without_geometry(p, q, r)]


def _plain_kinds() -> list[str]:
    """Plain kinds of the algebras in which no name is missing."""
    return list(algebra_from_data(plain_spec(DENSE_DIMENSION, 0, 0, "plain")).kinds)


def _largest() -> list[Declaration]:
    """Kernels of the largest plain algebra that has all of them."""
    spec = plain_spec(DENSE_DIMENSION, 0, 0, "plain")
    return declared_kernels(algebra_from_data(spec), spec["kernels"])


def _without_geometry(p: int, q: int, r: int) -> Omission:
    """Kinds of members that constraints single out: a signature has none, and specs of the same signature some."""
    from .algebra.schema import load_spec, stock_spec_path

    specs = [(name, load_spec(stock_spec_path(name))) for name in (*STOCK, *PRESETS)]
    same = [(name, spec["kinds"]) for name, spec in specs if algebra_from_data(spec).signature == (p, q, r)]
    own = {kind: None for _, kinds in same for kind, table in kinds.items() if table["constraints"]}
    names = tuple(own) or ("rotor", "motor", "point", "line", "..")
    where = " and ".join(f"bladesmith.{name}" for name, _ in same)
    remedy = f"declare them in a spec: {site_page('algebra/specs')}"
    if same:
        remedy = f"{where} {'have' if len(same) > 1 else 'has'} them"
    return Omission("kinds", names, f"a signature does not say which members count; {remedy}")
