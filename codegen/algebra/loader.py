"""Algebras from plain data: the contents of a spec or of a generated manifest. Light: no SymPy, no pydantic."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from typing import Any

from ..errors import SpecError, suggest
from .algebra import Algebra, Kind, add_plain_kinds
from .blades import metric_entry, validated_identifier

#: The path of the bundled specs inside the package, by algebra.
STOCK = ("cga3d", "pga3d", "cga2d")
#: Algebras with a spec and no generated kernels: products run by the table, formulas are compiled at first use.
PRESETS = ("vga2d", "vga3d", "pga2d", "sta", "qcga", "dcga")


def algebra_from_data(data: Mapping[str, Any]) -> Algebra:
    """Build an algebra with its kinds.

    Parameters
    ----------
    data : mapping
        ``name``, ``vectors`` (labels), ``metric`` (list of [label, label, number]), optional ``pseudoscalar`` and
        ``kinds`` (name -> ``blades`` or ``grades``, ``constraints``, ``member``), as in a spec file.

    Raises
    ------
    SpecError, SignatureError, BladeError
        If a label, a blade or a name is not valid.
    """
    vectors = [str(v) for v in data["vectors"]]
    if len(set(vectors)) != len(vectors):
        raise SpecError(f"vectors names one twice: {', '.join(vectors)}.")
    metric = [[Fraction(0)] * len(vectors) for _ in vectors]
    for first, second, number in data.get("metric", []):
        for label in (first, second):
            if str(label) not in vectors:
                raise SpecError(
                    f"metric names the vector {label!r}{suggest(str(label), vectors)}; there are {vectors}."
                )
        i, j = vectors.index(str(first)), vectors.index(str(second))
        metric[i][j] = metric[j][i] = metric_entry(number)
    algebra = Algebra(data["name"], vectors, metric, data.get("pseudoscalar"))
    for name, entry in data.get("kinds", {}).items():
        algebra.kinds[name] = _kind(algebra, name, entry)
    add_plain_kinds(algebra)
    return algebra


def _kind(algebra: Algebra, name: str, entry: Mapping[str, Any]) -> Kind:
    validated_identifier(name, "a kind's name")
    blades = {algebra.parse_blade(b)[0] for b in entry.get("blades", [])}
    for g in entry.get("grades", []):
        if not 0 <= g <= algebra.dimension:
            raise SpecError(f"kind {name!r}: there is no grade {g} in {algebra.dimension} dimensions.")
        blades.update(algebra.blades_of_grade(g))
    if not blades:
        raise SpecError(f"kind {name!r} has no blades; give `blades` or `grades`.")
    constraints, member = tuple(entry.get("constraints", ())), str(entry.get("member", ""))
    if constraints and not member:
        raise SpecError(f"kind {name!r} has constraints but no `member`; a member is needed to prove them.")
    return Kind(algebra, name, algebra.order(blades), constraints, member)


def data_from_algebra(algebra: Algebra) -> dict[str, Any]:
    """The plain data of an algebra, as `algebra_from_data` reads it (plain kinds left out)."""
    n = algebra.dimension
    metric = [
        [algebra.vectors[i], algebra.vectors[j], str(algebra.metric[i][j])]
        for i in range(n)
        for j in range(i, n)
        if algebra.metric[i][j]
    ]
    data: dict[str, Any] = {"name": algebra.name, "vectors": list(algebra.vectors), "metric": metric}
    if algebra.pseudoscalar_name:
        data["pseudoscalar"] = algebra.pseudoscalar_name
    plain = Algebra(algebra.name, algebra.vectors, algebra.metric)
    add_plain_kinds(plain)
    data["kinds"] = {
        kind.name: {
            "blades": [algebra.blade_name(b) for b in kind.blades],
            "constraints": list(kind.constraints),
            "member": kind.member,
        }
        for kind in algebra.kinds.values()
        if kind.name not in plain.kinds
    }
    return data
