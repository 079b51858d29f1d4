"""Reader of mechanism files (docs/motion/mechanisms.md) and files of robots.

Errors name file, line, key and remedy.
"""

from __future__ import annotations

import math
import os
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.errors import InputError
from ...common.documents import Document, read_document
from ...common.files import as_path
from ...mechanics.io.reader import KeyPath, MechanicsReader
from ...mechanics.joints.local_relations import relations
from ...mechanics.units import Units
from ..delta.robot import DeltaRobot
from ..mechanism.mechanism import Mechanism
from ..task.mechanism_model import MechanismModel
from ..task.report import AnyModel
from ..task.robot_model import DeltaModel
from ..task.task import PoseQuery, Setup, ViewOptions, WorkspaceQuery
from ..task.tool_path import ToolPath
from . import schema
from .robots import SUFFIXES, load_robot, robot_model

Array = NDArray[Any]


def load_mechanism(path: str | os.PathLike[str], tip: str | None = None, root: str | None = None) -> Setup:
    """Read and check a mechanism file, or a robot's.

    Parameters
    ----------
    path
        TOML; or ``.urdf``, ``.sdf``, or ``.xml`` and ``.mjcf``, an MJCF.
    tip, root : str, optional
        Of a robot's file: the links between which its chain goes. Default: the root of the file, or of the largest part
        that floats, and the link with the most moving joints above it.

    Returns
    -------
    Setup

    Raises
    ------
    InputError
        If it cannot be read, does not match the schema, or is inconsistent: with file, line and key.
    """
    file = as_path(path, "a mechanism is read from")
    if file.suffix.lower() in SUFFIXES:
        return Setup(robot_model(load_robot(file), tip, root), name=str(file))
    document = read_document(file, schema.FileTable)
    if (tip or root) and document.contents.urdf is None:
        raise InputError("tip and root are of robots' files.", where=document.name)
    return _Reader(document, file.parent, tip, root).setup()


class _Reader(MechanicsReader[schema.FileTable]):
    """Builder of a setup from a checked file.

    ``tip`` and ``root`` are the ends of the chain of a robot's file, in place of the file's.
    """

    def __init__(self, document: Document[schema.FileTable], folder: Path, tip: str | None, root: str | None) -> None:
        mechanism = document.contents.mechanism
        super().__init__(document, folder, "cga3d" if mechanism is None else mechanism.algebra)
        self.tip, self.root = tip, root

    def position(self, value: Any, path: KeyPath, owner: Any = None) -> Array:
        if isinstance(value, str):
            value = self.table.points[self.one_of(value, self.table.points, path, "a point")]
        return np.array(value)

    def setup(self) -> Setup:
        """The setup of the file."""
        table, look = self.table, self.table.picture
        model = self._model()
        view = None
        if look.elevation is not None or look.azimuth is not None:
            view = (20.0 if look.elevation is None else look.elevation, -60.0 if look.azimuth is None else look.azimuth)
        units = Units(table.units.length, table.units.mass, table.units.time)
        return Setup(
            model, self._stand(model), self._box(model), self._tool_path(model),
            ViewOptions(look.title or "", view, look.poses, look.legend), units, self.document.name,
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
            delta = table.delta
            lengths = (delta.base_radius, delta.effector_radius, delta.upper_arm, delta.forearm)
            return DeltaModel(self.document.build(("delta",), partial(DeltaRobot, *lengths)), delta.elbow, delta.root)
        if table.urdf is not None:
            return self._chain(table.urdf)
        return self._mechanism()

    def _chain(self, spec: schema.UrdfTable) -> AnyModel:
        from ..urdf.reader import urdf_example

        file = self.folder / spec.path if spec.path is not None else urdf_example(str(spec.example))
        robot = self.document.build(("urdf", "path"), partial(load_robot, file, spec.mimic, spec.ignore))
        for key, name in (("tip", spec.tip), ("root", spec.root)):
            if name is not None:
                self.one_of(name, robot.links, ("urdf", key), "a link")
        return self.document.build(("urdf",), partial(robot_model, robot, self.tip or spec.tip, self.root or spec.root))

    def _mechanism(self) -> MechanismModel:
        spec = self.table.mechanism
        assert spec is not None
        path: KeyPath = ("mechanism",)
        for i, name in enumerate(spec.bodies):
            if name in spec.bodies[:i]:
                raise self.document.error((*path, "bodies", i), f"is {name!r}, a duplicate body name")
        fixed = (
            spec.bodies[0] if spec.fixed is None else self.one_of(spec.fixed, spec.bodies, (*path, "fixed"), "a body")
        )
        if not self.table.joints:
            raise self.document.error(path, "has no joints", "Describe them under [[joints]]")
        mechanism = Mechanism(spec.bodies, fixed)
        index_of = {name: i for i, name in enumerate(spec.bodies)}
        for i, table in enumerate(self.table.joints):
            joint = self.joint(table, ("joints", i), spec.bodies)
            name = table.name if table.name is not None else _free(f"{table.a}-{table.b}", index_of)
            if name in index_of:
                raise self.document.error(
                    ("joints", i, "name"), f"is {name!r}, a duplicate name; names of joints and bodies are distinct"
                )
            index_of[name] = i
            self.document.build(("joints", i), partial(mechanism.add, joint, name))
            self.document.build(("joints", i), partial(relations, self.algebra, [joint]))  # checks its mobility
        for i, name in enumerate(spec.inputs):
            self.one_of(name, mechanism.joint_names, (*path, "inputs", i), "a joint")
            if name in spec.inputs[:i]:
                raise self.document.error((*path, "inputs", i), f"is {name!r}, a duplicate input")
        self.document.build(("joints",), mechanism.mobility)  # checks that joints connect all bodies
        limits = self._limits(spec)
        if spec.tool is None:
            return self.document.build(
                (*path, "inputs"), partial(MechanismModel, mechanism, spec.inputs, limits=limits)
            )
        where = (*path, "tool")
        body = self.one_of(spec.tool.body, [x for x in spec.bodies if x != fixed], (*where, "body"), "a moving body")
        point = self.position(spec.tool.point, (*where, "point"))
        return self.document.build(
            (*path, "inputs"), partial(MechanismModel, mechanism, spec.inputs, body, point, limits)
        )

    def _limits(self, spec: schema.MechanismTable) -> dict[str, tuple[float, float]]:
        for name, (low, high) in spec.limits.items():
            path: KeyPath = ("mechanism", "limits", name)
            self.one_of(name, spec.inputs, path, "an input")
            if not low <= high:
                raise self.document.error(path, f"goes from {low:g} to {high:g}; the least is first")
        return spec.limits

    # -- tasks -----------------------------------------------------------------------------------------

    def _stand(self, model: AnyModel) -> PoseQuery:
        spec = self.table.pose
        values = {}
        for name, value in spec.joints.items():
            self.one_of(name, model.inputs, ("pose", "joints", name), "an actuated joint")
            turns = bool(model.is_revolute[model.inputs.index(name)])
            values[name] = math.radians(value) if spec.degrees and turns else value
        position = None if spec.position is None else self.position(spec.position, ("pose", "position"))
        rotor = None
        if spec.orientation is not None:
            if position is None:
                raise self.document.error(("pose", "orientation"), "goes with a position")
            rotor = self.rotor(spec.orientation, ("pose", "orientation"))
        return PoseQuery(values, position, rotor)

    def _box(self, model: AnyModel) -> WorkspaceQuery | None:
        spec = self.table.workspace
        if spec is None:
            return None
        for i, (low, high) in enumerate(spec.box or ()):
            if low > high:
                raise self.document.error(("workspace", "box", i), f"goes from {low:g} to {high:g}; the least is first")
        if spec.show != "condition" and not isinstance(model, DeltaModel):
            raise self.document.error(("workspace", "show"), f"is {spec.show!r}, a measure of Delta robots only")
        return WorkspaceQuery(spec.box, spec.samples, spec.show, spec.across, spec.at)

    def _tool_path(self, model: AnyModel) -> ToolPath | None:
        spec = self.table.path
        if spec is None:
            return None
        path: KeyPath = ("path",)
        rest = (spec.duration, spec.samples, spec.timing == "smooth")
        if spec.joints is not None:
            ends = {}
            for name, pair in spec.joints.items():
                self.one_of(name, model.inputs, (*path, "joints", name), "an actuated joint")
                turns = bool(model.is_revolute[model.inputs.index(name)])
                ends[name] = tuple(math.radians(x) if spec.degrees and turns else x for x in pair)
            return ToolPath("joints", ends, *rest)
        if not model.tool:
            raise self.document.error(
                path, "is a path of a tool, and the mechanism has none", "Name it: mechanism.tool"
            )
        if spec.line is not None:
            start = None if spec.line.start is None else self.position(spec.line.start, (*path, "line", "start"))
            return ToolPath(
                "line", {"start": start, "end": self.position(spec.line.end, (*path, "line", "end"))}, *rest
            )
        if spec.circle is not None:
            center = self.position(spec.circle.center, (*path, "circle", "center"))
            circle = {"center": center, "normal": spec.circle.normal, "radius": spec.circle.radius}
            return ToolPath("circle", {**circle, "turns": spec.circle.turns}, *rest)
        points = [self.position(x, (*path, "points", i)) for i, x in enumerate(spec.points or ())]
        for i in range(1, len(points)):
            if np.array_equal(points[i], points[i - 1]):
                raise self.document.error((*path, "points", i), f"equals path.points[{i - 1}]")
        return ToolPath("points", {"points": points}, *rest)


def _free(name: str, used_names: Any) -> str:
    """The name, with a number if it is taken."""
    candidate, number = name, 2
    while candidate in used_names:
        candidate, number = f"{name} {number}", number + 1
    return candidate


__all__ = ["load_mechanism"]
