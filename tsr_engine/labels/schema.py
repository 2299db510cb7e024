"""Prints the JSON Schema of our set files: ``python -m tsr_engine.labels.schema > docs/label-set.schema.json``."""

from __future__ import annotations

import json
import sys

from tsr_engine.labels.model import LabelSet


def schema_text() -> str:
    """The schema, as stored in ``docs/``."""
    schema = {"$schema": "https://json-schema.org/draft/2020-12/schema", **LabelSet.model_json_schema(by_alias=True)}
    return json.dumps(schema, ensure_ascii=False, indent=2) + "\n"


if __name__ == "__main__":
    sys.stdout.write(schema_text())
