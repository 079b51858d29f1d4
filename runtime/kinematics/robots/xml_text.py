"""Texts of XML read safely: no document types, bounded in size and depth, with the line of each element.

Nothing is fetched and nothing is expanded. Formats of robots build on it (`urdf`, `sdf`, `mjcf`).
"""

from __future__ import annotations

import os
import stat
from collections.abc import Iterable
from math import isfinite
from xml.etree import ElementTree
from xml.parsers import expat

from ...codegen.errors import InputError, suggest
from ...common.files import as_path
from ...common.validation import short_repr

Element = ElementTree.Element
#: Length of a robot's text at most.
MOST_BYTES = 64 << 20
#: Depth of its elements at most.
MOST_DEPTH = 512


class XmlText:
    """A text of XML: its elements, and errors that say where.

    Parameters
    ----------
    path : str
        For messages.
    data : bytes

    Attributes
    ----------
    document : Element
        The root of the text.

    Raises
    ------
    InputError
        With file and line: not XML, a document type, elements nested too deep.
    """

    def __init__(self, path: str, data: bytes) -> None:
        self.path = path
        self._places: dict[Element, tuple[str, int]] = {}
        self.document = self.parse(path, data)

    def error(self, at: Element, what: str, remedy: str | None = None) -> InputError:
        """An error in an element: file, line and tag."""
        name = f" name={at.get('name')!r}" if at.get("name") is not None else ""
        path, line = self._places.get(at, (self.path, 1))
        return InputError(f"{what} <{at.tag}{name}>", where=f"{path}:{line}", remedy=remedy)

    def line(self, at: Element) -> int:
        """Line of an element."""
        return self._places.get(at, (self.path, 1))[1]

    def copy(self, element: Element, attributes: dict[str, str]) -> Element:
        """An element at the same place, with other attributes and no children."""
        copy = Element(element.tag, attributes)
        self._places[copy] = self._places.get(element, (self.path, 1))
        return copy

    def parse(self, path: str, data: bytes) -> Element:
        """Root element of a text, its elements' places noted."""
        parser, builder, depth = expat.ParserCreate(), ElementTree.TreeBuilder(), 0

        def doctype(*_: object) -> None:
            raise InputError(
                "a document type is declared; entities are neither expanded nor fetched.",
                where=f"{path}:{parser.CurrentLineNumber}",
                remedy="Remove the <!DOCTYPE>, and write out what it defines",
            )

        def start(tag: str, attributes: dict[str, str]) -> None:
            nonlocal depth
            depth += 1
            if depth > MOST_DEPTH:
                raise InputError(
                    f"elements are nested deeper than {MOST_DEPTH}, as <{tag}> is.",
                    where=f"{path}:{parser.CurrentLineNumber}",
                    remedy="A robot's file is a few levels deep: look for tags that are not closed",
                )
            self._places[builder.start(tag, attributes)] = path, parser.CurrentLineNumber

        def end(tag: str) -> None:
            nonlocal depth
            depth -= 1
            builder.end(tag)

        parser.StartDoctypeDeclHandler = doctype
        parser.StartElementHandler, parser.EndElementHandler = start, end
        parser.CharacterDataHandler = builder.data
        try:
            parser.Parse(data, True)
        except expat.ExpatError as error:
            raise InputError(
                f"this is not XML: {expat.ErrorString(error.code)}.", where=f"{path}:{error.lineno}"
            ) from None
        return builder.close()

    # -- parts of elements -----------------------------------------------------------------------------------

    def name(self, element: Element) -> str:
        """Name of an element, which it needs."""
        name = element.get("name", "")
        if not name.strip():
            raise self.error(element, "there is no name in")
        return name

    def only(self, element: Element, tag: str) -> Element | None:
        """The child with a tag, if there is one.

        Raises
        ------
        InputError
            If there are two.
        """
        found = element.findall(tag)
        if len(found) > 1:
            name = f" name={element.get('name')!r}" if element.get("name") else ""
            raise self.error(found[1], f"there is a second <{tag}> in <{element.tag}{name}>:")
        return found[0] if found else None

    def numbers(self, element: Element, what: str, text: str, count: int | None, least: int = 1) -> list[float]:
        """Finite numbers of a text: ``count`` of them, or with None ``least`` and more.

        Parameters
        ----------
        what : str
            For messages, such as ``xyz='...'``.
        """
        try:
            found = [float(x) for x in text.split()]
        except ValueError:
            found = []
        if (len(found) != count if count is not None else len(found) < least) or not all(isfinite(x) for x in found):
            number = least if count is None else count
            more = " or more" if count is None else ""
            needed = "a finite number is" if count == 1 else f"{number}{more} finite numbers are"
            raise self.error(element, f"{what}, where {needed} needed, in")
        return found

    def choice(self, element: Element, attribute: str, value: str, choices: Iterable[str]) -> str:
        """A word of several."""
        words = tuple(choices)
        if value not in words:
            raise self.error(
                element, f"{attribute}={value!r} is not known{suggest(value, words)} in", f"One of: {', '.join(words)}"
            )
        return value


def ignored_names(ignore: Iterable[str]) -> tuple[str, ...]:
    """The names that a user lets be left out.

    Raises
    ------
    InputError
        If they are not a list of texts.
    """
    names = None if isinstance(ignore, str | bytes) or not isinstance(ignore, Iterable) else tuple(ignore)
    if names is None or not all(isinstance(name, str) for name in names):
        raise InputError(
            f"ignore is {short_repr(ignore)}; a list of tags is needed.", remedy="Name them, such as ignore=['include']"
        )
    return names


def bytes_of(path: str | os.PathLike[str], what: str) -> bytes:
    """The file's content.

    Parameters
    ----------
    path
    what : str
        The format, with its article: "a URDF".

    Raises
    ------
    InputError
        If there is no such file, or it is too long.
    """
    file = as_path(path, f"{what} is loaded from")
    try:
        status = file.stat()
        if not stat.S_ISREG(status.st_mode):  # pipes and devices may have no end
            raise InputError("this is not a plain file.", where=str(path))
        if status.st_size > MOST_BYTES:
            raise InputError(f"the file has more than {MOST_BYTES >> 20} MiB.", where=str(path))
        return file.read_bytes()
    except OSError as error:
        raise InputError(f"the file cannot be read: {error.strerror}.", where=str(path)) from None
