"""Every exception of the project, so that code generation and runtime share one family.

Light on purpose: the standard library only, and no other room of this package comes in. Users meet these
names as `bladesmith.errors`. A message says what is wrong, where, and what to do about it, in one line.
"""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from reprlib import repr as shortened
from typing import Any

_CLOSE_ENOUGH = 0.6  # difflib's own default ratio: half a dozen letters with one or two slips


def nearest(word: object, candidates: Iterable[str]) -> str | None:
    """The valid word that is most like what the user wrote, or None when none is near."""
    valid = list(dict.fromkeys(candidates))
    text = str(word)
    folded = {each.lower(): each for each in reversed(valid)}
    near = difflib.get_close_matches(text, valid, n=1, cutoff=_CLOSE_ENOUGH) or [
        folded[each] for each in difflib.get_close_matches(text.lower(), folded, n=1, cutoff=_CLOSE_ENOUGH)
    ]
    return near[0] if near else None


def suggest(word: object, candidates: Iterable[str]) -> str:
    """The nearest valid word in brackets, for the middle or the end of a sentence; nothing when none is near.

    Parameters
    ----------
    word
        What the user wrote.
    candidates
        What would have been valid.

    Returns
    -------
    str
        `" (did you mean 'radius'?)"`, or the empty string.
    """
    near = nearest(word, candidates)
    return f" (did you mean {near!r}?)" if near else ""


def one_line(value: object) -> str:
    """An invalid value as messages repeat it: shortened, on one line."""
    return " ".join(shortened(value).split())


class BladesmithError(Exception):
    """Base of every error that this package raises on purpose.

    Parameters
    ----------
    what
        What is wrong. May be the whole message.
    where
        The file, line, key, kernel or item that it is wrong in.
    remedy
        What the user can do.
    """

    def __init__(self, what: str, *, where: str | None = None, remedy: str | None = None) -> None:
        self.what = what
        self.where = where
        self.remedy = remedy
        super().__init__(self._message())

    def _message(self) -> str:
        text = f"{_on_one_line(self.where)}: {self.what}" if self.where else self.what
        if not self.remedy:
            return text
        joint = " " if text.endswith((".", "?", "!")) else "; " if self.remedy[0].islower() else ". "
        return f"{text}{joint}{self.remedy}"

    def __reduce__(self) -> tuple[object, ...]:  # keyword arguments survive pickling to another process
        return _rebuild, (type(self), self.args, self.__dict__)


def _on_one_line(name: str) -> str:
    """The name of a file may have line breaks; a message has none."""
    return "".join(c if c.isprintable() else repr(c)[1:-1] for c in name)


def _rebuild(kind: type[BladesmithError], args: tuple[object, ...], state: dict[str, object]) -> BladesmithError:
    error = kind.__new__(kind, *args)
    error.args = args
    error.__dict__.update(state)
    return error


class InputError(BladesmithError, ValueError):
    """A file, an argument or an option that the user gave is wrong."""


class SceneError(InputError):
    """A scene, as a file or as objects, is wrong."""


class SpecError(InputError):
    """The specification of an algebra or of a kernel is wrong."""


class AlgorithmError(SpecError):
    """The text of an algorithm has something that the language of algorithms has not."""


class SignatureError(InputError):
    """A signature is out of range, of a wrong type, or asks for more than an algebra of that size serves."""


class AlgebraMismatchError(BladesmithError, TypeError):
    """Operands of different algebras meet in one operation."""


class BladeError(BladesmithError, ValueError):
    """A blade's name is unknown, or a blade is not there."""


class KindError(BladesmithError, ValueError):
    """A kind is unknown, or a value or a formula is not of the kind that was promised."""


class GradeError(BladesmithError, ValueError):
    """Operands have grades for which the operation means nothing."""


class ShapeError(InputError):
    """Shapes do not broadcast, or the last axis has the wrong length."""


class SingularError(BladesmithError, ArithmeticError):
    """An item has no answer, or no unique one (raised on request, where statuses would tell)."""


class UndeterminedError(SingularError):
    """Models leave motions free, so that no pose of theirs can be told.

    Parameters
    ----------
    what, where, remedy
        As for every error.
    motions
        The twists of the free motions, in the world of the model that ``where`` names.
    result
        What could be found all the same.
    """

    def __init__(
        self, what: str, *, where: str | None = None, remedy: str | None = None, motions: object = None,
        result: object = None,
    ) -> None:  # fmt: skip
        self.motions = motions
        self.result = result
        super().__init__(what, where=where, remedy=remedy)


class ExecutorError(BladesmithError):
    """Workers of an executor failed or ended.

    Parameters
    ----------
    what, where, remedy
        As for every error.
    partial
        What the others computed.
    """

    def __init__(
        self, what: str, *, where: str | None = None, remedy: str | None = None, partial: object = None
    ) -> None:
        self.partial: Any = partial
        super().__init__(what, where=where, remedy=remedy)


class Interrupted(KeyboardInterrupt):
    """An interrupt of long work.

    Parameters
    ----------
    partial
        What was computed until then: a result of the same type, unless the function says otherwise.
    """

    def __init__(self, partial: object) -> None:
        self.partial: Any = partial
        super().__init__("interrupted; `partial` holds what was computed until then")


class ConstraintError(InputError):
    """Constraints that the start does not obey, or that contradict each other."""


class SimulationError(BladesmithError, ArithmeticError):
    """A simulation that could not go on.

    Parameters
    ----------
    what, where, remedy
        As for every error.
    trajectory
        What was computed until then.
    """

    def __init__(
        self, what: str, *, where: str | None = None, remedy: str | None = None, trajectory: object = None
    ) -> None:
        self.trajectory = trajectory
        super().__init__(what, where=where, remedy=remedy)


class NotInvertibleError(SingularError):
    """The inverse of something that has none."""


class NotARotorError(SingularError, ValueError):
    """Logarithm or root of something that is not a rotor."""


class TraceError(BladesmithError, TypeError):
    """A formula cannot be run on symbolic multivectors."""


class CompileError(BladesmithError, RuntimeError):
    """The compiler refused a generated source.

    Parameters
    ----------
    what, where, remedy
        As for every error.
    source
        The file that it refused.
    """

    def __init__(
        self, what: str, *, where: str | None = None, remedy: str | None = None, source: Path | None = None
    ) -> None:
        self.source = source
        super().__init__(what, where=where, remedy=remedy)

    def set_folder(self, folder: Path) -> None:
        """Note where the folder of the refused file was put aside."""
        if self.source is not None:
            self.source = folder / self.source.name
            self.remedy = f"The source is kept in {self.source}"
            self.args = (self._message(),)


class CompilerMissingError(CompileError):
    """There is no compiler to be found, or the one asked for does not run."""


class DeviceError(BladesmithError, RuntimeError):
    """The GPU's driver is missing, or refuses something."""


class MissingExtraError(BladesmithError, ImportError):
    """An optional dependency is not installed.

    Parameters
    ----------
    extra
        The extra of this package that brings it, such as `"plot"`.
    purpose
        What it is needed for, as the beginning of a sentence: `"Saving images"`.
    otherwise
        What does it without, as a sentence.
    """

    def __init__(self, extra: str, purpose: str = "This", otherwise: str = "") -> None:
        self.extra = extra
        remedy = f"Run: pip install 'bladesmith[{extra}]'{'. ' if otherwise else ''}{otherwise}"
        super().__init__(f"{purpose} needs the extra {extra!r}", remedy=remedy)


@contextmanager
def needed(package: str, purpose: str, otherwise: str = "") -> Iterator[None]:
    """Around imports of what needs a package: where it is not installed, its extra, of the same name, is named."""
    try:
        yield
    except ModuleNotFoundError as error:
        if (error.name or "").partition(".")[0] not in (package, f"{package}lib"):
            raise
        raise MissingExtraError(package, purpose, otherwise) from None


__all__ = [
    "AlgebraMismatchError",
    "BladeError",
    "BladesmithError",
    "CompileError",
    "CompilerMissingError",
    "DeviceError",
    "ExecutorError",
    "GradeError",
    "InputError",
    "Interrupted",
    "KindError",
    "MissingExtraError",
    "NotARotorError",
    "NotInvertibleError",
    "SceneError",
    "ShapeError",
    "SignatureError",
    "SingularError",
    "SpecError",
    "TraceError",
    "UndeterminedError",
    "nearest",
    "suggest",
]
