"""`bladesmith kinematics`: a file of a robot into what it can do: a report, pictures, motions, workspaces."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from . import options

if TYPE_CHECKING:
    from ..kinematics.task.joint_trajectory import Motion
    from ..kinematics.task.task import Setup

NOTICE = "preparing: what such a mechanism needs is compiled once, and kept"


@options.command("kinematics delta.toml -o robot.png --motion motion.csv --workspace slices.png", "motion/mechanisms")
@options.input_file("robot")
@options.output_file(None, f"The robot at its pose, with its path if it has one: {options.IMAGES}", "picture")
@options.file("--motion", "motions", multiple=True,
             help="What the driven joints do along the path: .csv or .npz, may be repeated.")  # fmt: skip
@options.file("--workspace", "slices", help=f"What the tool reaches, and how well, in slices: {options.IMAGES}")
@click.option("--joint", "-j", "joints", multiple=True, metavar="NAME=VALUE", help="Coordinate of a driven joint.")
@options.flag("--degrees", "Angles of --joint are degrees, not radians.")
@click.option("--position", type=float, nargs=3, metavar="X Y Z", help="Where the tool is, in place of joints.")
@click.option(
    "--to", type=float, nargs=3, metavar="X Y Z", help="A path: the tool goes straight from its pose to here."
)
@click.option("--duration", type=float, help="Of the path; default: the file's, or 1.")
@click.option("--samples", type=int, help="Times of the path; default: the file's, or 101.")
@click.option("--box", type=float, nargs=6, metavar="X X Y Y Z Z", help="Of the workspace: least and greatest.")
@click.option("--tip", help="Of a robot's file: the link that is moved; default: the one behind most joints.")
@click.option("--root", help="Of a robot's file: the link that is fixed; default: its root.")
@click.option("--json", "as_json", is_flag=True, help="The report as JSON.")
@options.feedback
def command(
    robot: Path, picture: Path | None, motions: tuple[Path, ...], slices: Path | None, tip: str | None,
    root: str | None, as_json: bool, feedback: options.Feedback, **changes: Any,
) -> int:  # fmt: skip
    """Say what a mechanism can do, draw it, move it.

    ROBOT is a .toml file that describes a Delta robot, a mechanism of bodies and joints or names a robot's file, or
    that file itself: .urdf, .sdf, or .xml and .mjcf of MuJoCo. The report on stdout has bodies, joints, mobility, free
    motions, redundant constraints, and the Jacobian with its condition number at the pose. The exit status is 1 if the
    robot cannot take the pose, or not all of its path: what there is of that goes to motion.partial.csv, beside the
    file that was asked for.
    """
    from ..kinematics.io.reader import load_mechanism

    _check(robot, motions, [x for x in (picture, slices) if x is not None])
    setup = load_mechanism(robot, tip, root)
    setup = _apply_options(setup, **changes)
    if slices is not None:
        setup.check_workspace()
    with feedback.preparing(NOTICE):
        report = setup.report()
        moved = setup.motion_with_poses() if motions or (picture and setup.tool_path is not None) else None
    click.echo(json.dumps(report.data, indent=1, allow_nan=False) if as_json else report.text())
    trouble = _unreached_message(moved[0], setup) if moved is not None else ""
    kept = [options.partial_name(place) if trouble else place for place in motions]
    for place in kept:
        assert moved is not None
        moved[0].save(place)
    if picture is not None:
        setup.picture(picture, moved)
    if slices is not None:
        setup.slices(slices, setup.workspace(feedback.shows_bars))
    feedback.wrote((*kept, picture, slices))
    if trouble:
        click.echo(trouble, err=True)
        return 1
    return 0


def _check(robot: Path, motions: tuple[Path, ...], pictures: list[Path]) -> None:
    """Refuse what could not be written, before any work."""
    from ..kinematics.task.joint_trajectory import checked_name
    from ..plot.style import check_suffix

    for place in motions:
        checked_name(place)
    for place in pictures:
        check_suffix(place)
    options.check_outputs([*motions, *pictures], [robot], "the robot's file")


def _apply_options(
    setup: Setup, joints: tuple[str, ...], degrees: bool, position: Any, to: Any, duration: float | None,
    samples: int | None, box: Any,
) -> Setup:  # fmt: skip
    """Apply the command's options to a setup."""
    import math

    import numpy as np

    from ..common.validation import as_int, finite_array, positive_float
    from ..errors import InputError
    from ..kinematics.io.schema import MOST_SAMPLES
    from ..kinematics.task.task import PoseQuery, WorkspaceQuery
    from ..kinematics.task.tool_path import ToolPath

    for name, numbers in (("--position", position), ("--to", to), ("--box", box), ("--duration", duration)):
        if numbers is not None:
            finite_array(numbers, name)
    pose_query = setup.pose_query
    values = dict(pose_query.joints)
    for text in joints:
        name, _, value = text.rpartition("=")
        try:
            number = float(value)
        except ValueError:
            number = math.nan
        if not name or not math.isfinite(number):
            raise InputError(f"--joint is {text!r}; it is NAME=VALUE, such as {_example(setup)}=0.5.")
        turns = name in setup.model.inputs and setup.model.is_revolute[setup.model.inputs.index(name)]
        values[name] = math.radians(number) if degrees and turns else number
    if joints or position is not None:
        place = None if position is None else np.array(position)
        pose_query = PoseQuery(values, place, pose_query.rotor if place is not None else None)
    tool_path = setup.tool_path
    if to is not None:
        known = tool_path or ToolPath("line")
        tool_path = replace(known, kind="line", numbers={"start": None, "end": np.array(to)})
    if duration is not None or samples is not None:
        if tool_path is None:
            raise InputError(
                "--duration and --samples are of a path, and there is none.", remedy="Give --to, or [path]"
            )
        if duration is not None:
            positive_float(duration, "--duration")
        if samples is not None:
            as_int(samples, "--samples", 2, MOST_SAMPLES)
        tool_path = replace(tool_path, duration=duration or tool_path.duration, samples=samples or tool_path.samples)
    room = setup.box
    if box is not None:
        room = replace(room or WorkspaceQuery(), bounds=np.array(box).reshape(3, 2))
    return replace(setup, pose_query=pose_query, tool_path=tool_path, box=room)


def _example(setup: Setup) -> str:
    return setup.model.inputs[0] if setup.model.inputs else "motor"


def _unreached_message(motion: Motion, setup: Setup) -> str:
    """Message about unreached points of a motion; empty if all are reached."""
    from ..status import Status

    missed = ~motion.is_reached
    if not missed.any():
        return ""
    first = int(missed.argmax())
    code, share = Status(int(motion.status[first])).name, f"{int(missed.sum())} of {len(missed)}"
    return f"the path is not reached at {share} times, first at t = {motion.time[first]:.6g} {setup.units.time}: {code}"
