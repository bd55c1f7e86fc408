"""The JSON Schema of a type of results, made from its fields and their marks."""

from __future__ import annotations

from typing import Any

from stiffcal.documents import NOT_PROMISED, Document, fields_of_many_keys, marks_of, written_fields

DIALECT = "https://json-schema.org/draft/2020-12/schema"


def schema_of(kind: Any) -> Document:
    """Return the JSON Schema of the documents of a result type.

    Required are the keys that stand in every document, whether or not the field has a default.
    """
    from pydantic import TypeAdapter
    from pydantic.json_schema import GenerateJsonSchema, JsonSchemaValue
    from pydantic_core import core_schema

    class DocumentSchema(GenerateJsonSchema):
        """Schemas of what is written, which pydantic takes for what may be given to a constructor."""

        def dataclass_schema(self, schema: core_schema.DataclassSchema) -> JsonSchemaValue:
            made = super().dataclass_schema(schema)
            kind: Any = schema["cls"]
            written = written_fields(kind)
            many_keys = fields_of_many_keys(kind)
            promised = [(name, mark) for name, mark in written if NOT_PROMISED not in marks_of(kind)[name]]
            properties: Document = {}
            for name, _ in promised:
                of_field = made["properties"][name]
                properties |= of_field.get("properties", {}) if name in many_keys else {name: of_field}
            made["properties"] = properties
            made["required"] = [name for name, mark in promised if mark is None and name not in many_keys]
            if not made["required"]:
                del made["required"]
            return made

        def default_schema(self, schema: core_schema.WithDefaultSchema) -> JsonSchemaValue:
            return self.generate_inner(schema["schema"])

    return {"$schema": DIALECT, **TypeAdapter(kind).json_schema(schema_generator=DocumentSchema)}
