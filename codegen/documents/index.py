"""Lines of the keys of a TOML or JSON text. Reads text that the standard library has already accepted.

`tomllib` and `json` give values without positions; an error message needs the line. Values are skipped, not read.
"""

from __future__ import annotations

import json
import re
import tomllib
from bisect import bisect_right
from collections.abc import Callable

Path = tuple[str | int, ...]  # keys, and positions in arrays: ("surfaces", 2, "radius")

_BLANK = re.compile(r"(?:[ \t\r\n]|#[^\n]*)*")  # between statements and inside arrays, comments included
_KEY = re.compile(r'[A-Za-z0-9_-]+|"(?:\\.|[^"\\])*"|\'[^\']*\'')
_STRING = re.compile(
    r'"""(?:\\.|[^\\])*?"{3,5}(?!")'  # three quotes end it, and up to two before them belong to the text
    r"|'''.*?'{3,5}(?!')"
    r'|"(?:\\.|[^"\\])*"'
    r"|'[^']*'",
    re.DOTALL,
)
_SCALAR = re.compile(r"[^,\]}#\r\n]*")  # a number, date or truth value


def line_index(text: str) -> dict[Path, int]:
    """Line, counted from 1, of every table, key and array item of a valid TOML text.

    A table has the line of its header, or of the first dotted key that names it; an item of an array the line
    where it begins.
    """
    scanner = _Scanner(text, _plain_toml)
    scanner.document()
    return scanner.lines


def json_line_index(text: str) -> dict[Path, int]:
    """Line, counted from 1, of every key and array item of a valid JSON text."""
    scanner = _Scanner(text, json.loads)
    scanner.value(())
    return scanner.lines


def line_of(index: dict[Path, int], path: Path) -> int | None:
    """Line of a path, or, for a key that is missing, of the innermost table around it."""
    for length in range(len(path), 0, -1):
        if path[:length] in index:
            return index[path[:length]]
    return None


class _Scanner:
    """Scanner of TOML; a JSON text is one value of it, with colons for equals signs."""

    def __init__(self, text: str, plain: Callable[[str], str]) -> None:
        self.text, self._plain = text, plain
        self.position = 0
        self.lines: dict[Path, int] = {}
        self._starts = [0, *(match.end() for match in re.finditer("\n", text))]
        self._counts: dict[Path, int] = {}  # tables so far in each array of tables

    def document(self) -> None:
        table: Path = ()
        self._skip(_BLANK)
        while self.position < len(self.text):
            if self.text[self.position] == "[":
                table = self._header()
            else:
                self._pair(table)
            self._skip(_BLANK)

    def _header(self) -> Path:
        start = self.position
        is_array = self.text.startswith("[[", start)
        self.position += 1 + is_array
        keys = self._keys()
        self.position += 1 + is_array
        path: Path = ()
        for i, key in enumerate(keys):
            path += (key,)
            is_new = is_array and i == len(keys) - 1
            if is_new:
                self._note(path, start)
                self._counts[path] = self._counts.get(path, 0) + 1
            if path in self._counts:
                path += (self._counts[path] - 1,)
            self._note(path, start)
        self.lines[path] = self._line(start)  # its own header counts, not an earlier one of a table inside it
        return path

    def _pair(self, table: Path) -> None:
        start = self.position
        path = table
        for key in self._keys():
            path += (key,)
            self._note(path, start)
        self.position += 1  # the equals sign or colon
        self.value(path)

    def _keys(self) -> list[str]:
        """A dotted key, with the space after it."""
        keys = []
        while True:
            self._skip(_BLANK)
            keys.append(self._plain(self._skip(_KEY)))
            self._skip(_BLANK)
            if self.text[self.position] != ".":
                return keys
            self.position += 1

    def value(self, path: Path) -> None:
        """Skip a value and note what is in it."""
        self._skip(_BLANK)
        match self.text[self.position]:
            case "[":
                self._array(path)
            case "{":
                self._inline_table(path)
            case '"' | "'":
                self._skip(_STRING)
            case _:
                self._skip(_SCALAR)

    def _array(self, path: Path) -> None:
        self.position += 1
        self._skip(_BLANK)
        item = 0
        while self.text[self.position] != "]":
            self._note((*path, item), self.position)
            self.value((*path, item))
            self._after_item()
            item += 1
        self.position += 1

    def _inline_table(self, path: Path) -> None:
        self.position += 1
        self._skip(_BLANK)
        while self.text[self.position] != "}":
            self._pair(path)
            self._after_item()
        self.position += 1

    def _after_item(self) -> None:
        self._skip(_BLANK)
        if self.text[self.position] == ",":
            self.position += 1
            self._skip(_BLANK)

    def _skip(self, pattern: re.Pattern[str]) -> str:
        match = pattern.match(self.text, self.position)
        if match is None:  # cannot be in a valid text; better no line than an endless loop
            raise ValueError(f"no TOML at character {self.position}")
        self.position = match.end()
        return match.group()

    def _note(self, path: Path, position: int) -> None:
        self.lines.setdefault(path, self._line(position))

    def _line(self, position: int) -> int:
        return bisect_right(self._starts, position)


def _plain_toml(key: str) -> str:
    """A key without quotation marks and escapes."""
    return next(iter(tomllib.loads(f"{key} = 0"))) if key[0] in "\"'" else key
