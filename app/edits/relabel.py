"""Another class for a whole track. The page does the same in static/js/model/relabel.js."""

from __future__ import annotations

from app.edits.documents import KeyFrame, TrackDoc

__all__ = ["relabelled"]


def relabelled(doc: TrackDoc, class_id: int | None) -> TrackDoc:
    """The whole track means every box: labels of single ones go, and key frames that said nothing else with them.

    Args:
        doc: of the track.
        class_id: the class, -1: none of the classes, None: the engine's.
    """
    keys: dict[str, KeyFrame] = {}
    held = KeyFrame()
    for frame in doc.frames():
        key = doc.keys[str(frame)]
        state = key.occluded, key.outside, key.interpolate
        says = key.box is not None or state != (held.occluded, held.outside, held.interpolate)
        if key.class_id is not None and not says:
            continue
        keys[str(frame)] = held = key.model_copy(update={"class_id": None})
    return doc.model_copy(update={"class_id": class_id, "keys": keys})
