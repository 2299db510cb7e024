"""A label of the whole track replaces labels of single frames.

The page does the same in static/js/model/relabel.js.
"""

from __future__ import annotations

from collections.abc import Callable

from app.edits.documents import Attributes, AttributeValue, KeyFrame, TrackDoc


def relabelled(doc: TrackDoc, class_id: int | None) -> TrackDoc:
    """Set the label of a whole track; labels of single frames are removed, and so are key frames with nothing else.

    Args:
        doc: document of the track.
        class_id: the label, -1: none of the set, None: the engine's.
    """
    keys = _reduce_keys(doc, lambda key: key.model_copy(update={"class_id": None}))
    return doc.model_copy(update={"class_id": class_id, "keys": keys})


def with_attribute(doc: TrackDoc, name: str, value: AttributeValue | None, frame: int | None) -> TrackDoc:
    """Set an attribute.

    Args:
        doc: document of the track.
        name: name of the attribute.
        value: its value; None removes it.
        frame: None: in the whole track; else from this frame on, up to its next change.
    """
    if frame is None:
        keys = _reduce_keys(doc, lambda key: key.model_copy(update={"attributes": _put(key.attributes, name, None)}))
        return doc.model_copy(update={"attributes": _put(doc.attributes, name, value), "keys": keys})
    doc = doc.with_key(frame)
    keys = dict(doc.keys)
    old = keys[str(frame)].attributes.get(name)
    for later in doc.frames():
        key = keys[str(later)]
        if later < frame:
            continue
        if not _equal(key.attributes.get(name), old):
            break
        keys[str(later)] = key.model_copy(update={"attributes": _put(key.attributes, name, value)})
    return doc.model_copy(update={"keys": keys})


def _reduce_keys(doc: TrackDoc, reduce: Callable[[KeyFrame], KeyFrame]) -> dict[str, KeyFrame]:
    """Key frames after a value was removed from each; those with nothing else are dropped."""
    keys: dict[str, KeyFrame] = {}
    carried = carried_before = KeyFrame()
    for frame in doc.frames():
        before = doc.keys[str(frame)]
        key = reduce(before)
        if _changes_values(key, carried) or not _changes_values(before, carried_before):
            keys[str(frame)] = carried = key
        carried_before = before
    return keys


def _changes_values(key: KeyFrame, carried: KeyFrame) -> bool:
    """Whether a key frame changes any value that already applies."""
    return key.box is not None or key.class_id is not None or key.state() != carried.state()


def _put(attributes: Attributes, name: str, value: AttributeValue | None) -> Attributes:
    others = {key: present for key, present in attributes.items() if key != name}
    return others if value is None else {**others, name: value}


def _equal(a: AttributeValue | None, b: AttributeValue | None) -> bool:
    """Equal, and of one kind: true is not 1."""
    return type(a) is type(b) and a == b
