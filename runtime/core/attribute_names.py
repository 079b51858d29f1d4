"""Names of an algebra's attributes: which of them users are told of."""

from __future__ import annotations

from collections.abc import Iterable

#: `dir` of an algebra lists its blades in at most so many dimensions.
DIRECTORY = 6
#: Attributes that are for the package itself: `dir` does not list them, and no message suggests them.
INTERNAL = {
    "as_motor", "blade_key", "check_listed", "construct", "formulas", "from_data", "full_blade", "has_wide_labels",
    "intern", "is_diagonal", "item_plans", "label_runs", "layout_of", "motor_parameters", "multivector_class",
    "named_blades", "named_tuple", "order", "parse_blade", "product", "pseudoscalar_name", "pseudoscalar_sign",
    "read", "readers", "remember", "result_kind", "rotor_parameters", "scalar_layout", "space", "spatial", "stock",
    "targets", "translator_parameters", "type_of", "wrap",
}  # fmt: skip


def listed(names: Iterable[str]) -> list[str]:
    """Those that are for users."""
    return [name for name in names if name not in INTERNAL]
