"""`bladesmith export`: kernels, algorithms, algebras and robots as source files of other languages."""

from __future__ import annotations

import pkgutil
import re
import sys
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import click

from ..codegen.export.options import LANGUAGES, PRECISIONS, ExportOptions
from ..errors import InputError, SpecError
from . import options

#: Files of robots.
ROBOTS = (".urdf", ".sdf", ".xml", ".mjcf")
_OBJECT = re.compile(r"[\w.]+:[\w.]+")
_OBJECT_OF_FILE = re.compile(r"(.+)\.py:([\w.]+)")


@dataclass(frozen=True)
class Target:
    """What is written: language, folder, name of the files if it is given, and other options."""

    language: str
    folder: Path
    name: str | None
    options: dict[str, Any]


@options.command("export pga3d --language c99 -o include --only 'sandwich_motor_*'", "algebra/export")
@click.argument("source")
@click.option("--language", "-l", type=click.Choice(list(LANGUAGES)), required=True)
@options.output_folder(".")
@click.option("--name", help="Of the files, and before or around all names in them. Default: the source's.")
@click.option("--dtype", type=click.Choice(list(PRECISIONS)), help="Default: what is usual in the language.")
@click.option("--only", multiple=True, metavar="PATTERN", help="Kernels of an algebra: names with * and ?; repeatable.")
@click.option("--derivative", "derivatives", multiple=True, metavar="ARGUMENT",
              help="Of a kernel: the forward derivative along this argument, too; repeatable.")  # fmt: skip
@click.option("--jacobian", "jacobians", multiple=True, metavar="ARGUMENT",
              help="Of a kernel: all partial derivatives with respect to it, too; repeatable.")  # fmt: skip
@options.flag("--split", "C99 as a header and a source file; default: all in the header.")
@options.flag("--force", "Also over a file that is there and holds something else than this export.")
@click.option("--tip", help="Of a robot's file: the link that is moved; default: the one behind most joints.")
@click.option("--root", help="Of a robot's file: the link that is fixed; default: its root.")
@options.feedback
def command(
    source: str, language: str, out: Path, name: str | None, only: tuple[str, ...], derivatives: tuple[str, ...],
    jacobians: tuple[str, ...], tip: str | None, root: str | None, dtype: str | None, split: bool, force: bool,
    feedback: options.Feedback,
) -> None:  # fmt: skip
    """Write source files that need nothing of this package.

    SOURCE is an algebra (pga2d, pga3d, cga2d, cga3d, vga2d, vga3d, sta, ...); a spec file of an algebra (.toml); a
    kernel or an algorithm of Python, module:name; a robot's file (.urdf, .sdf, .xml, .mjcf); or a file of a mechanism
    or of a Delta robot (.toml), as `bladesmith kinematics` takes it.

    What is exported is yours, without conditions.
    """
    path = Path(source)
    target = Target(language, out, name, {"dtype": dtype or "", "split": split, "overwrite": force})
    derived = {"--derivative": derivatives, "--jacobian": jacobians}
    _check_source(path)
    with feedback.preparing(f"exporting {source}"):
        if _OBJECT.fullmatch(source) and not path.exists():
            _refuse(source, {"--only": only, "--tip": tip, "--root": root})
            written = _export_object(source, target, derived)
        elif path.suffix.lower() in ROBOTS or (path.suffix == ".toml" and not _is_spec(path)):
            _refuse(source, {"--only": only, **derived})
            written = _export_robot(path, target, tip, root)
        else:
            _refuse(source, {**derived, "--tip": tip, "--root": root})
            written = _export_algebra(source, target, only, feedback)
    feedback.wrote(written)


def _refuse(source: str, given: Mapping[str, Any]) -> None:
    for option, value in given.items():
        if value:
            raise InputError(f"{option} has no meaning here.", where=source)


def _check_source(path: Path) -> None:
    if path.is_dir():
        raise InputError(
            "is a folder.", where=str(path), remedy="Give the spec file (.toml) that it was generated from"
        )
    if not path.exists() and (found := _OBJECT_OF_FILE.fullmatch(str(path))):
        module = ".".join(Path(found[1]).parts)
        raise InputError(
            "names a file; a kernel or an algorithm is that of a module.", where=str(path),
            remedy=f"Write {module}:{found[2]}",
        )  # fmt: skip


def _is_spec(path: Path) -> bool:
    """Whether a TOML file describes an algebra; what cannot be read says so where it is loaded."""
    try:
        return "vectors" in tomllib.loads(path.read_text("utf-8"))
    except (OSError, ValueError):
        return False


def _identifier(text: str) -> str:
    return re.sub(r"[^A-Za-z0-9]+", "_", text).strip("_").lower() or "exported"


def _export_algebra(source: str, target: Target, only: tuple[str, ...], feedback: options.Feedback) -> list[Path]:
    from ..codegen.algebra.schema import load_spec, stock_spec_path
    from ..codegen.export.export import export
    from ..codegen.library.kernels import library_variants

    try:
        path = Path(source) if source.endswith(".toml") else stock_spec_path(source)
    except SpecError as error:
        raise SpecError(error.what, remedy="A kernel of a module is module:name") from None
    spec = load_spec(path)
    chosen = ExportOptions(target.language, target.name or str(spec["name"]), **target.options)
    variants = library_variants(spec, only, feedback.shows_bars)
    return export(variants, target.folder, chosen)


def _export_object(source: str, target: Target, derived: Mapping[str, tuple[str, ...]]) -> list[Path]:
    from ..codegen.algorithm_api import CompiledAlgorithm
    from ..codegen.api import KernelFunction

    sys.path.insert(0, "")
    try:
        found = pkgutil.resolve_name(source)
    except (Exception, SystemExit) as error:  # what a user's module does when it is imported
        kind = "" if isinstance(error, (ImportError, AttributeError)) else f"{type(error).__name__}: "
        raise InputError(
            f"cannot be imported: {kind}{error}.",
            where=source,
            remedy=f"See `python -c 'import {source.partition(':')[0]}'`.",
        ) from error
    finally:
        sys.path.remove("")
    if isinstance(found, KernelFunction):
        own: dict[str, Any] = {"derivatives": derived["--derivative"], "jacobians": derived["--jacobian"]}
        return found.export(target.language, target.folder, name=target.name or "", **own, **target.options)
    if isinstance(found, CompiledAlgorithm):
        _refuse(source, derived)
        return found.export(target.language, target.folder, name=target.name or "", **target.options)
    raise InputError("is no kernel and no algorithm.", where=source, remedy="Name one: module:name.")


def _export_robot(path: Path, target: Target, tip: str | None, root: str | None) -> list[Path]:
    from ..kinematics.io.reader import load_mechanism
    from ..kinematics.task.mechanism_model import MechanismModel
    from ..kinematics.task.robot_model import ChainModel, DeltaModel

    model = load_mechanism(path, tip, root).model
    name = target.name or _identifier(path.stem)
    if isinstance(model, ChainModel):
        return model.chain.export(target.language, target.folder, name, **target.options)
    if isinstance(model, DeltaModel):
        own = {"elbow": model.elbow, "root": model.root, **target.options}
        return model.robot.export(target.language, target.folder, name, **own)
    assert isinstance(model, MechanismModel)
    if not model.inputs:
        raise InputError("no joint is driven.", where=str(path), remedy="Name driven joints in the file.")
    return model.mechanism.export(target.language, target.folder, model.inputs, name, **target.options)
