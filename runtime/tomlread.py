"""TOML files of users, checked against a schema. Lives in the code generator, which reads specs and may not
import the runtime; imported only when a file is read, because pydantic is slow to import.
"""

from __future__ import annotations

from .codegen.toml.document import Document, Positive, Table, Vector3, read_document, read_toml

__all__ = ["Document", "Positive", "Table", "Vector3", "read_document", "read_toml"]
