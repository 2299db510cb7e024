"""Reads and writes the class names in YOLO's ``data.yaml``, and reads the shape of keypoints."""

from __future__ import annotations

import json
import re
from collections.abc import Collection
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import yaml

from tsr_engine.errors import ImportFormatError
from tsr_engine.exchange.reading import read_text, rule_error

MAX_YAML_BYTES: Final = 1 << 20
"""Largest file that is read, bytes; 30,000 names take less."""
_UNPRINTABLE = re.compile("[\x7f-\x9f\u2028\u2029\ufeff\ufffe\uffff]")
_SURROGATE = re.compile("[\ud800-\udfff]")
_LOADER: Final = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
"""Both loaders are safe: no tag creates an object. The one in C is in every wheel and faster."""
_STANDARD_TAG: Final = "tag:yaml.org,2002:"
_NUMBER = re.compile(r"\d{1,6}")


def quoted_name(name: str) -> str:
    """Write a name as a double-quoted YAML scalar."""
    text = json.dumps(_SURROGATE.sub("\ufffd", name), ensure_ascii=False)
    return _UNPRINTABLE.sub(lambda found: f"\\u{ord(found[0]):04x}", text)


@dataclass(frozen=True, slots=True)
class DataYaml:
    """What ``data.yaml`` says about the rows of label files.

    Attributes:
        names: class names by number; None: there is no ``names``.
        keypoint_count: how many numbers each row has after its box (``kpt_shape``); 0: it has no keypoints.
    """

    names: dict[int, str] | None
    keypoint_count: int


def read_data_yaml(path: Path) -> DataYaml:
    """Read class names, as :func:`read_class_names`, and the shape of keypoints.

    Raises:
        ImportFormatError: as there, or ``kpt_shape`` is not a number of points and 2 or 3 numbers for each.
    """
    members, file = _members(path, ("names", "kpt_shape")), path.name
    names = members.get("names")
    return DataYaml(None if names is None else _names(names, file), _keypoint_count(members.get("kpt_shape"), file))


def read_class_names(path: Path) -> dict[int, str] | None:
    """Read class names by number; None: there is no ``names``.

    Names are read as text: ``no`` and ``1.50`` are not a truth value and a number.

    Raises:
        ImportFormatError: not YAML, or ``names`` is neither a list nor a map of names; names the line.
    """
    names = _members(path, ("names",)).get("names")
    return None if names is None else _names(names, path.name)


def _keypoint_count(node: yaml.Node | None, file: str) -> int:
    if node is None:
        return 0
    values = [each.value for each in node.value] if isinstance(node, yaml.SequenceNode) else []
    if len(values) != 2 or not _NUMBER.fullmatch(str(values[0])) or values[1] not in ("2", "3"):
        raise _error(file, node, "kpt_shape must be the number of points and 2 or 3, as '[4, 3]'. Correct it.")
    return int(values[0]) * int(values[1])


def _members(path: Path, wanted: Collection[str]) -> dict[str, yaml.Node]:
    """The values of some keys of the file, if it has them."""
    file = path.name
    text = read_text(path, limit=MAX_YAML_BYTES)
    try:
        root = yaml.compose(text, Loader=_LOADER)
    except yaml.MarkedYAMLError as error:
        line = None if error.problem_mark is None else error.problem_mark.line + 1
        raise rule_error(
            file, line, f"is not YAML: {error.problem}. Quote names that hold marks like ':', or export it again."
        ) from None
    except yaml.YAMLError as error:
        reason = str(error).splitlines()[0]
        raise rule_error(file, None, f"is not YAML: {reason}. Export it again.") from None
    except RecursionError:
        raise rule_error(file, None, "is nested too deeply. Export it again.") from None
    if root is None:
        return {}
    if not isinstance(root, yaml.MappingNode):
        raise _error(file, root, "must be a map with names. Export it again.")
    found: dict[str, yaml.Node] = {}
    for key, value in root.value:
        if _is_text(key) and key.value == "<<":
            raise _error(file, key, "a merge key (<<) is not read. Write its entries out.")
        if _is_text(key) and key.value in wanted:
            if key.value in found:
                raise _error(file, key, f"has {key.value} twice. Delete one.")
            found[key.value] = value
    return found


def _names(node: yaml.Node, file: str) -> dict[int, str]:
    _check_tag(node, file)
    if isinstance(node, yaml.SequenceNode):
        return {number: _name(value, file) for number, value in enumerate(node.value)}
    if isinstance(node, yaml.ScalarNode) and node.tag == f"{_STANDARD_TAG}null":
        return {}
    if not isinstance(node, yaml.MappingNode):
        raise _error(file, node, f"names must be a list or a map, as 'names: [stop, yield]'. Got {_describe(node)}.")
    out: dict[int, str] = {}
    for key, value in node.value:
        if not _is_text(key) or not _NUMBER.fullmatch(key.value):
            raise _error(
                file, key, f"a name must be written '0: stop', by the number of its class. Got {_describe(key)}."
            )
        number = int(key.value)
        if number in out:
            raise _error(file, key, f"class {number} occurs twice. Give each class its own number.")
        out[number] = _name(value, file)
    return out


def _name(node: yaml.Node, file: str) -> str:
    _check_tag(node, file)
    if not _is_text(node):
        raise _error(file, node, f"a name must be a text. Got {_describe(node)}.")
    return str(node.value)


def _is_text(node: yaml.Node) -> bool:
    return isinstance(node, yaml.ScalarNode)


def _check_tag(node: yaml.Node, file: str) -> None:
    if not node.tag.startswith(_STANDARD_TAG) or node.tag.startswith(f"{_STANDARD_TAG}python/"):
        raise _error(file, node, f"the tag {node.tag[:60]!r} is not read. Delete it.")


def _describe(node: yaml.Node) -> str:
    if _is_text(node):
        return repr(str(node.value)[:60])
    return "a list" if isinstance(node, yaml.SequenceNode) else "a map"


def _error(file: str, node: yaml.Node, rule: str) -> ImportFormatError:
    return rule_error(file, node.start_mark.line + 1, rule)
