"""Tables of joints in files of mechanisms and simulations: by positions and directions, or by shared objects."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Annotated, Any, Literal

from numpy.typing import NDArray
from pydantic import Field, model_validator

from ...common.documents import Table
from ..joints import bilinear, standard
from ..joints.base import Joint
from .fields import Direction, Name, Place, present_keys
from .geometry import AnyObject

if TYPE_CHECKING:
    from ...core.multivector import Algebra

Array = NDArray[Any]
#: Keys of directions.
DIRECTIONS = ("axis", "normal", "axis_a", "axis_b")
#: Classes of joints by their kind in a file.
KINDS: dict[str, Callable[..., Joint]] = {
    "spherical": standard.Spherical, "revolute": standard.Revolute, "cylindrical": standard.Cylindrical,
    "prismatic": standard.Prismatic, "planar": standard.Planar, "universal": bilinear.Universal,
    "screw": standard.Screw, "rigid": standard.Rigid, "bilinear": bilinear.Bilinear,
}  # fmt: skip


class JointTable(Table):
    """A joint between two bodies at the start, by positions and directions or by shared objects."""

    a: Name
    b: Name
    name: Name | None = None
    objects: list[AnyObject] | None = None

    @model_validator(mode="after")
    def _check_one_form(self) -> JointTable:
        own = [key for key in type(self).model_fields if key not in (*JointTable.model_fields, "kind", *self.options())]
        own, required = present_keys(self, *own), self.required_keys()
        if self.objects is not None and own:
            raise ValueError(f"objects and {' and '.join(own)} are alternatives; give one of them")
        if self.objects is None:
            for key in required:
                if key == "objects":
                    raise ValueError("has no objects; it is between two")
                if getattr(self, key) is None:
                    raise ValueError(f"has neither {key} nor objects; one is needed")
        return self

    def required_keys(self) -> tuple[str, ...]:
        """Keys that are required without objects."""
        return tuple(key for key in ("point", *DIRECTIONS) if key in type(self).model_fields)

    def options(self) -> dict[str, Any]:
        """Further arguments of the joint's class, by their names, which are those of keys."""
        return {}

    def placement(self, point: Array, algebra: Algebra) -> dict[str, Any]:
        """Arguments of the joint's class from the table's position, found, and its directions."""
        return {"point": point, "algebra": algebra} | {
            key: getattr(self, key) for key in DIRECTIONS if key in type(self).model_fields
        }


class SphericalTable(JointTable):
    """Rotation about a point; or a sphere."""

    kind: Literal["spherical"]
    point: Place | None = None


class AxisTable(JointTable):
    """A joint with an axis."""

    point: Place | None = None
    axis: Direction | None = None


class RevoluteTable(AxisTable):
    """Rotation about an axis; or a circle, a point pair, a line and a point."""

    kind: Literal["revolute"]


class CylindricalTable(AxisTable):
    """Rotation about an axis and translation along it; or a line."""

    kind: Literal["cylindrical"]


class ScrewTable(AxisTable):
    """Rotation about an axis that translates along it, by a pitch for each radian; or a line."""

    kind: Literal["screw"]
    pitch: float

    def options(self) -> dict[str, Any]:
        return {"pitch": self.pitch}


class PrismaticTable(AxisTable):
    """Translation along an axis; or two objects."""

    kind: Literal["prismatic"]

    def required_keys(self) -> tuple[str, ...]:
        return ("axis",)


class PlanarTable(JointTable):
    """Translation in a plane and rotation about its normal; or a plane."""

    kind: Literal["planar"]
    point: Place | None = None
    normal: Direction | None = None


class UniversalTable(JointTable):
    """Two axes at right angles, one of each body; or two circles."""

    kind: Literal["universal"]
    point: Place | None = None
    axis_a: Direction | None = None
    axis_b: Direction | None = None


class RigidTable(JointTable):
    """Two bodies as one."""

    kind: Literal["rigid"]
    point: Place | None = None

    def required_keys(self) -> tuple[str, ...]:
        if self.objects is not None:
            raise ValueError("a rigid joint has no objects; its point says where the bodies meet")
        return ()

    def placement(self, point: Array, algebra: Algebra) -> dict[str, Any]:
        return {"position": point, "algebra": algebra}


class BilinearTable(JointTable):
    """A product of two objects, one of each body, that stays zero."""

    kind: Literal["bilinear"]
    product: Literal["outer", "inner", "meet", "anticommutator"] = "outer"

    def options(self) -> dict[str, Any]:
        return {"product": self.product}

    def required_keys(self) -> tuple[str, ...]:
        return ("objects",)


AnyJoint = Annotated[
    SphericalTable | RevoluteTable | CylindricalTable | ScrewTable | PrismaticTable | PlanarTable | UniversalTable
    | RigidTable | BilinearTable,
    Field(discriminator="kind"),
]  # fmt: skip
