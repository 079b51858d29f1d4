"""TOML and JSON files of users, checked against a schema; imported only when one is read, because pydantic is slow.

The schemas' base and the reader live in the code generator, which reads specs and may not import the runtime.
"""

from __future__ import annotations

from ..codegen.documents.document import Document, JsonDocument, Positive, Table, Vector3, read_document

__all__ = ["Document", "JsonDocument", "Positive", "Table", "Vector3", "read_document"]
