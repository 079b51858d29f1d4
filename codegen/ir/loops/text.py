"""The text of an algorithm: its syntax tree, what its names mean, and refusals that quote it."""

from __future__ import annotations

import ast
import builtins
import inspect
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from enum import Enum, IntEnum
from types import ModuleType
from typing import Any, NoReturn

from ...errors import AlgorithmError, suggest
from .static import fold_binary
from .types import INT, Annotation, Parameter, Scalar, StaticType

#: Types of static values; tuples hold them.
STATIC = (int, float, str, bool, Enum, type(None))


class AlgorithmText:
    """A Python function as the reader sees it.

    Parameters
    ----------
    function : callable
        Defined in a file or a notebook's cell: its text is needed.

    Raises
    ------
    AlgorithmError
        If there is no text, or the signature has something that algorithms have not.
    """

    def __init__(self, function: Callable[..., Any]) -> None:
        self.function = function
        self.name = function.__name__
        self.file = function.__code__.co_filename
        try:
            lines, self.first = inspect.getsourcelines(function)
        except (OSError, TypeError):
            raise _no_text(self.name) from None
        self.lines = [line.rstrip("\r\n") for line in lines]
        tree = _definition("".join(lines))
        defined = function.__code__.co_name
        if defined != "<lambda>" and getattr(tree, "name", "") != defined:  # what was found is not its text
            raise _no_text(self.name)
        if not isinstance(tree, ast.FunctionDef):
            raise AlgorithmError(
                "an algorithm is a function that begins with def", where=f"{self.file}:{self.first}", remedy="Use def."
            )
        self.tree = tree
        if not self.name.isascii():
            self.refuse(tree, "its name has letters that C has not", "Use letters of ASCII.")
        self.note = (inspect.getdoc(function) or self.name).splitlines()[0]
        self.names = self._names()
        self.parameters = self._parameters()
        self.results = self._results()

    def refuse(self, node: ast.AST, what: str, remedy: str) -> NoReturn:
        """Raise with file, line and text."""
        row = getattr(node, "lineno", 1) - 1
        quoted = self.lines[row].strip() if row < len(self.lines) else ""
        raise AlgorithmError(f"{what}, in `{quoted}`", where=self.place(node), remedy=remedy)

    def place(self, node: ast.AST) -> str:
        """File and line of a part of the text."""
        return f"{self.file}:{self.first + getattr(node, 'lineno', 1) - 1}"

    def _names(self) -> dict[str, Any]:
        """Values of names from outside the function."""
        cells = zip(self.function.__code__.co_freevars, self.function.__closure__ or (), strict=False)
        return {**vars(builtins), **self.function.__globals__, **dict(_filled_cells(cells))}

    def _parameters(self) -> tuple[Parameter, ...]:
        arguments = self.tree.args
        if arguments.vararg or arguments.kwarg or arguments.kwonlyargs or arguments.posonlyargs or arguments.defaults:
            self.refuse(self.tree, "parameters are plain names", "Leave out *, / and default values.")
        found = []
        for each in arguments.args:
            if each.annotation is None:
                self.refuse(each, f"{each.arg} has no type", "Annotate it, for example with Real or Vector[3].")
            given = self.function.__annotations__.get(each.arg)  # a value in modules that evaluate annotations
            declared = given if isinstance(given, Annotation) else self.annotation(each.annotation)
            found.append(Parameter(self.identifier(each, each.arg), declared.type, declared.access))
        return tuple(found)

    def _results(self) -> tuple[Scalar, ...] | None:
        """Types of what it returns, as annotated; None: not said."""
        node = self.tree.returns
        if node is None:
            return None
        if isinstance(node, ast.Constant) and node.value is None:
            return ()
        items = [node]
        if isinstance(node, ast.Subscript) and isinstance(node.value, ast.Name) and node.value.id == "tuple":
            items = node.slice.elts if isinstance(node.slice, ast.Tuple) else [node.slice]
        found = []
        for item in items:
            value = self._annotation_value(item)
            if isinstance(value, type) and issubclass(value, IntEnum):
                found.append(INT)
            elif isinstance(value, Annotation) and isinstance(value.type, Scalar):
                found.append(value.type)
            else:
                self.refuse(node, f"{ast.unparse(item)} is returned", "Return numbers; write arrays into Out[...].")
        return tuple(found)

    def annotation(self, node: ast.expr) -> Annotation:
        """The value of an annotation."""
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            self.refuse(node, "an annotation in quotes", "Write the type itself.")
        declared = self._annotation_value(node)
        if not isinstance(declared, Annotation):
            self.refuse(
                node,
                f"{ast.unparse(node)} is not a type of algorithms",
                "Use Real, Int, Bool, Static, Vector, Matrix, Rows, Reals, IntVector, IntRows, Ints, Out[...] or "
                "InOut[...].",
            )
        return declared

    def _annotation_value(self, node: ast.expr) -> Any:
        """Names, attributes of modules, and subscripts of them by numbers."""
        match node:
            case ast.Subscript(value, index):
                outer = self._annotation_value(value)
                items = index.elts if isinstance(index, ast.Tuple) else [index]
                inner = [self._annotation_value(item) for item in items]
                try:
                    return outer[inner[0] if len(inner) == 1 else tuple(inner)]
                except (AlgorithmError, TypeError) as error:
                    said = error.what if isinstance(error, AlgorithmError) else str(error)
                    self.refuse(node, said, "Write for example Vector[3] or Out[Matrix[4, 4]].")
            case ast.Constant(value):
                return value
            case ast.Name(name):
                return self.outside(node, name)
            case ast.Attribute(value, attribute):
                return self.attribute(node, self._annotation_value(value), attribute)
            case ast.BinOp():
                left, right = self._annotation_value(node.left), self._annotation_value(node.right)
                return fold_binary(self.refuse, node, left, right)
            case _:
                return None

    def outside(self, node: ast.AST, name: str) -> Any:
        """Value of a name that the function does not bind."""
        if name == self.name:
            self.refuse(node, f"{name} calls itself", "Write a loop with a stack of its own.")
        if name not in self.names:
            known = [n for n in self.names if not hasattr(builtins, n)]
            self.refuse(node, f"{name} is not known{suggest(name, known)}", "Define it before the algorithm.")
        return self.names[name]

    def attribute(self, node: ast.AST, value: Any, name: str) -> Any:
        """An attribute of a module, of an enumeration, or of a named tuple."""
        is_readable = isinstance(value, (ModuleType, Enum)) or (isinstance(value, type) and issubclass(value, Enum))
        if (is_readable or name in getattr(value, "_fields", ())) and hasattr(value, name):
            return getattr(value, name)
        return self.refuse(
            node,
            f"{name} is not an attribute that algorithms read",
            "Attributes are those of modules, of enumerations and of static named tuples.",
        )

    def identifier(self, node: ast.AST, name: str) -> str:
        """A name that every target can have."""
        if not name.isascii():
            self.refuse(node, f"the name {name} has letters that C has not", "Use letters of ASCII.")
        return name


def _no_text(name: str) -> AlgorithmError:
    return AlgorithmError(
        "an algorithm is compiled from its text, and there is none",
        where=name,
        remedy="Define it in a file or a notebook, not at a prompt or by exec.",
    )


def _definition(source: str) -> ast.AST | None:
    """The syntax tree of a function, which may be indented; None: there is no statement by itself."""
    is_inside = source[:1].isspace()
    try:
        tree = ast.parse(f"if True:\n{source}" if is_inside else source).body[0]
    except SyntaxError:
        return None
    if not isinstance(tree, ast.If):
        return tree
    return ast.increment_lineno(tree.body[0], -1)


def _filled_cells(cells: Iterable[tuple[str, Any]]) -> Iterator[tuple[str, Any]]:
    """Names of an enclosing function that have a value by now: the algorithm's own has not."""
    for name, cell in cells:
        with suppress(ValueError):
            yield name, cell.cell_contents


def is_static(value: Any) -> bool:
    """Whether a value can be known when the text is printed: algorithms and kernels can, too."""
    if isinstance(value, tuple):
        return all(is_static(v) for v in value)
    return isinstance(value, STATIC) or getattr(value, "is_callable_in_algorithms", False)


def is_static_parameter(parameter: Parameter) -> bool:
    return isinstance(parameter.type, StaticType)
