"""Mechanism files (docs/mechanisms.md) and URDF files: read, checked, and made into what can be asked of them.

Every fault is told with file, line, key and remedy.
"""

from __future__ import annotations

import math
import os
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..codegen.errors import InputError
from ..dynamics.given import shown
from ..dynamics.sketch import Units
from ..tomlread import read_document
from . import schema
from .delta import DeltaRobot
from .document_joints import Ground, KeyPath
from .local import relations
from .mechanism import Mechanism
from .models import ChainModel, DeltaModel
from .models_general import MechanismModel
from .paths import Way
from .setup import AnyModel, Box, Look, Setup, Stand

if TYPE_CHECKING:
    from ..multivector import Multivector
    from .urdf import Robot

#: How a robot's own file is known.
URDF = ".urdf"


def load_mechanism(path: str | os.PathLike[str], tip: str | None = None, root: str | None = None) -> Setup:
    """Read and check a mechanism file, or a URDF file.

    Parameters
    ----------
    path
        TOML, or ``.urdf``.
    tip, root : str, optional
        Of a URDF file: the links between which its chain goes. Default: the root of the file, and the link with the
        most moving joints above it.

    Returns
    -------
    Setup

    Raises
    ------
    InputError
        If it cannot be read, does not fit the schema, or means nothing: with file, line and key.
    MissingExtraError
        For URDF without yourdfpy (extra `urdf`).
    """
    try:
        file = Path(os.fsdecode(path))
    except TypeError:
        raise InputError(f"a mechanism is read from a file, and {shown(path)} names none.") from None
    if "\0" in str(file):
        raise InputError(f"the name {str(file)!r} has a null character.")
    if file.suffix.lower() == URDF:
        from .urdf import load_urdf

        return Setup(chain_model(load_urdf(file), tip, root), name=str(file))
    document = read_document(str(file), schema.FileTable)
    if (tip or root) and document.contents.urdf is None:
        raise InputError("tip and root are of URDF files.", where=document.name)
    return _Reader(document, file.parent, tip, root).setup()


def chain_model(robot: Robot, tip: str | None = None, root: str | None = None) -> ChainModel:
    """A robot and the chain to its tip: the link with the most moving joints above it, if none is named."""
    found = tip
    if found is None:
        above = {joint.child: joint for joint in robot.joints.values()}
        counts = {}
        for name in robot.links:
            count, link = 0, name
            while link in above:
                count += above[link].name in robot.joint_names
                link = above[link].parent
            counts[name] = count
        most = max(counts.values())
        found = [name for name in robot.links if counts[name] == most][-1]  # behind what is welded to it
    return ChainModel(robot, robot.chain(found, root), found, root)


class _Reader(Ground):
    """A checked file on its way to a setup."""

    def setup(self) -> Setup:
        """Everything."""
        table, look = self.table, self.table.picture
        model = self._model()
        view = None
        if look.elevation is not None or look.azimuth is not None:
            view = (20.0 if look.elevation is None else look.elevation, -60.0 if look.azimuth is None else look.azimuth)
        units = Units(table.units.length, table.units.mass, table.units.time)
        return Setup(
            model, self._stand(model), self._box(model), self._way(model),
            Look(look.title or "", view, look.poses, look.legend), units, self.document.name,
        )  # fmt: skip

    # -- the model ---------------------------------------------------------------------------------------------

    def _model(self) -> AnyModel:
        table = self.table
        kinds = [key for key in ("delta", "urdf", "mechanism") if getattr(table, key) is not None]
        if len(kinds) != 1:
            if kinds:
                raise self.document.error((kinds[1],), f"and {kinds[0]} are both there; a file describes one robot")
            raise InputError(
                "describes no robot.", where=self.document.name, remedy="Give a table [delta], [urdf] or [mechanism]"
            )
        if table.joints and table.mechanism is None:
            raise self.document.error(("joints", 0), f"goes with [mechanism]; this file has [{kinds[0]}]")
        if table.delta is not None:
            own = table.delta
            lengths = (own.base_radius, own.effector_radius, own.upper_arm, own.forearm)
            return DeltaModel(self.made(("delta",), partial(DeltaRobot, *lengths)), own.elbow, own.root)
        if table.urdf is not None:
            return self._chain(table.urdf)
        return self._mechanism()

    def _chain(self, own: schema.UrdfTable) -> ChainModel:
        from .urdf import load_urdf, urdf_example

        file = self.folder / own.path if own.path is not None else urdf_example(str(own.example))
        robot = self.made(("urdf", "path"), partial(load_urdf, file, mimic=own.mimic, ignore=own.ignore))
        for key, name in (("tip", own.tip), ("root", own.root)):
            if name is not None:
                self.among(name, robot.links, ("urdf", key), "link")
        return self.made(("urdf",), partial(chain_model, robot, self.tip or own.tip, self.root or own.root))

    def _mechanism(self) -> MechanismModel:
        own = self.table.mechanism
        assert own is not None
        path: KeyPath = ("mechanism",)
        for i, name in enumerate(own.bodies):
            if name in own.bodies[:i]:
                raise self.document.error((*path, "bodies", i), f"is {name!r}, as of another body")
        fixed = own.bodies[0] if own.fixed is None else self.among(own.fixed, own.bodies, (*path, "fixed"), "body")
        if not self.table.joints:
            raise self.document.error(path, "has no joints", "Describe them under [[joints]]")
        made = Mechanism(own.bodies, fixed)
        taken = {name: i for i, name in enumerate(own.bodies)}
        for i, table in enumerate(self.table.joints):
            joint = self.joint(table, ("joints", i))
            name = table.name if table.name is not None else _free(f"{table.a}-{table.b}", taken)
            if name in taken:
                raise self.document.error(
                    ("joints", i, "name"), f"is {name!r}, as of another joint or body; each has a name of its own"
                )
            taken[name] = i
            self.made(("joints", i), partial(made.add, joint, name))
            self.made(("joints", i), partial(relations, self.algebra, [joint]))  # what it leaves is what it should
        for i, name in enumerate(own.inputs):
            self.among(name, made.joint_names, (*path, "inputs", i), "joint")
            if name in own.inputs[:i]:
                raise self.document.error((*path, "inputs", i), f"is {name!r}, which is there twice")
        self.made(("joints",), made.mobility)  # that joints hang together, and hold everything
        limits = self._limits(own, made)
        if own.tool is None:
            return self.made((*path, "inputs"), partial(MechanismModel, made, own.inputs, limits=limits))
        where = (*path, "tool")
        body = self.among(own.tool.body, [x for x in own.bodies if x != fixed], (*where, "body"), "body that moves")
        point = self.place(own.tool.point, (*where, "point"))
        return self.made((*path, "inputs"), partial(MechanismModel, made, own.inputs, body, point, limits))

    def _limits(self, own: schema.MechanismTable, made: Mechanism) -> dict[str, tuple[float, float]]:
        for name, (low, high) in own.limits.items():
            path: KeyPath = ("mechanism", "limits", name)
            self.among(name, own.inputs, path, "input")
            if not low <= high:
                raise self.document.error(path, f"goes from {low:g} to {high:g}; the least is first")
        return own.limits

    # -- what is asked -----------------------------------------------------------------------------------------

    def _stand(self, model: AnyModel) -> Stand:
        own = self.table.pose
        values = {}
        for name, value in own.joints.items():
            self.among(name, model.inputs, ("pose", "joints", name), "joint that is driven")
            turns = bool(model.turning[model.inputs.index(name)])
            values[name] = math.radians(value) if own.degrees and turns else value
        position = None if own.position is None else self.place(own.position, ("pose", "position"))
        turn = None
        if own.orientation is not None:
            if position is None:
                raise self.document.error(("pose", "orientation"), "goes with a position")
            turn = self._turn(own.orientation)
        return Stand(values, position, turn)

    def _turn(self, own: Any) -> Multivector:
        path: KeyPath = ("pose", "orientation")
        found: Multivector
        if own.matrix is None:
            found = self.made(path, partial(self.algebra.rotor, own.axis, own.radians, strict=True))
        else:
            matrix = np.eye(4)
            matrix[:3, :3] = own.matrix
            found = self.made((*path, "matrix"), partial(self.algebra.motor_from_matrix, matrix, strict=True))
        return found

    def _box(self, model: AnyModel) -> Box | None:
        own = self.table.workspace
        if own is None:
            return None
        for i, (low, high) in enumerate(own.box or ()):
            if low > high:
                raise self.document.error(("workspace", "box", i), f"goes from {low:g} to {high:g}; the least is first")
        if own.show != "condition" and not isinstance(model, DeltaModel):
            raise self.document.error(("workspace", "show"), f"is {own.show!r}, which Delta robots have")
        return Box(own.box, own.samples, own.show, own.across, own.at)

    def _way(self, model: AnyModel) -> Way | None:
        own = self.table.path
        if own is None:
            return None
        path: KeyPath = ("path",)
        rest = (own.duration, own.samples, own.timing == "smooth")
        if own.joints is not None:
            ends = {}
            for name, pair in own.joints.items():
                self.among(name, model.inputs, (*path, "joints", name), "joint that is driven")
                turns = bool(model.turning[model.inputs.index(name)])
                ends[name] = tuple(math.radians(x) if own.degrees and turns else x for x in pair)
            return Way("joints", ends, *rest)
        if not model.tool:
            raise self.document.error(path, "is one of a tool, and the mechanism has none", "Name it: mechanism.tool")
        if own.line is not None:
            start = None if own.line.start is None else self.place(own.line.start, (*path, "line", "start"))
            return Way("line", {"start": start, "end": self.place(own.line.end, (*path, "line", "end"))}, *rest)
        if own.circle is not None:
            center = self.place(own.circle.center, (*path, "circle", "center"))
            given = {"center": center, "normal": own.circle.normal, "radius": own.circle.radius}
            return Way("circle", {**given, "turns": own.circle.turns}, *rest)
        points = [self.place(x, (*path, "points", i)) for i, x in enumerate(own.points or ())]
        for i in range(1, len(points)):
            if np.array_equal(points[i], points[i - 1]):
                raise self.document.error((*path, "points", i), "is where the one before it is")
        return Way("points", {"points": points}, *rest)


def _free(name: str, taken: Any) -> str:
    """A name of its own: one that is taken gets a number."""
    found, number = name, 2
    while found in taken:
        found, number = f"{name} {number}", number + 1
    return found


__all__ = ["load_mechanism"]
