"""The categories of COCO."""

from __future__ import annotations

import json
from pathlib import Path
from typing import get_args

from tsr_engine.exchange.json_stream import read_members
from tsr_engine.exchange.label_files.label_collector import FileLabels, LabelCollector
from tsr_engine.exchange.reading import rule_error
from tsr_engine.labels.model import Category, LabelSet

_CATEGORIES = frozenset(get_args(Category))


def read_categories(path: Path, key: str, name: str) -> FileLabels:
    """Read ids, names and supercategories; the rest of the file is ignored.

    Raises:
        ImportFormatError: not JSON, or no categories; names the line or the place.
    """
    collector = LabelCollector(path.name)
    found = read_members(path, ("categories",)).get("categories")
    if not isinstance(found, list):
        raise rule_error(path.name, None, "has no list of categories.")
    stated = [each.get("supercategory") for each in found if isinstance(each, dict)]
    parents = {each for each in stated if isinstance(each, str)} - {"", "none"}
    for position, each in enumerate(found, start=1):
        where = f"category {position}"
        if not isinstance(each, dict) or not isinstance(each.get("name"), str):
            raise rule_error(path.name, where, "must be an object with a name. Correct it.")
        number, supercategory = each.get("id"), each.get("supercategory")
        if type(number) is not int:
            raise rule_error(path.name, where, "id must be a whole number. Correct it.")
        has_parent = supercategory not in (None, "", "none")
        if not has_parent and each["name"] in parents:
            # Roboflow lists the project itself as category 0.
            collector.note(f"{path.name}: {each['name'][:60]!r} is the supercategory of others; it was left out.")
            continue
        if not isinstance(supercategory, str) or supercategory not in _CATEGORIES:
            if has_parent:
                collector.note(
                    f"{path.name}: the supercategory {str(supercategory)[:60]!r} is unknown; 'other' was used."
                )
            supercategory = "other"
        collector.add(each["name"], where, number, category=supercategory)
    return collector.finish(key, name)


def write_categories(labels: LabelSet) -> str:
    """Write a COCO file with categories only; ids are those of the set."""
    rows = [
        json.dumps({"id": label.id, "name": label.name, "supercategory": label.category}, ensure_ascii=False)
        for label in labels.offered()
    ]
    return '{"info": {}, "images": [], "annotations": [],\n"categories": [\n' + ",\n".join(rows) + "\n]}\n"
