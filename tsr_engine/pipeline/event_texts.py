"""Events of one frame in plain sentences, with the values behind them."""

from __future__ import annotations

from tsr_engine.geometry.boxes import to_cxcywh
from tsr_engine.params.gate import GateParams
from tsr_engine.plural import plural
from tsr_engine.protocols import ScoredBox
from tsr_engine.records import Event, FloatArray, GateVerdict, Relocalisation

# Usual factors of a well-tracked sign. Only the choice of the reason in the sentence depends on them.
_USUAL_SYMMETRY = 1.5
_USUAL_BITS = 8.0
_USUAL_PIXELS = 3.0
_USUAL_SIDES = 0.08


def rejected_event(track_id: int, verdict: GateVerdict, gate: GateParams, consequence: str) -> Event:
    """The event of a prediction that the gate rejects and no window replaces."""
    text = f"Prediction of track {track_id} rejected, {_reason(verdict, gate)}; {consequence}."
    return Event("rejected", track_id, text, _values(verdict, gate))


def relocalised_event(
    track_id: int, verdict: GateVerdict, gate: GateParams, prediction: FloatArray, found: Relocalisation
) -> Event:
    """The event of a prediction that the gate rejects and a window of the online detector replaces."""
    dx, dy = _displacement(prediction, found)
    text = f"Prediction of track {track_id} rejected, {_reason(verdict, gate)}; relocalised {_offset_text(dx, dy)}."
    values = _values(verdict, gate) | {"dx": dx, "dy": dy, "probability": found.probability}
    return Event("relocalised", track_id, text, values)


def search_event(
    track_id: int,
    undetected: int,
    prediction: FloatArray,
    found: Relocalisation,
    accepted: ScoredBox | None,
    rejected: ScoredBox | None = None,
) -> Event:
    """The event of a sign that the online detector finds after some frames without a detection.

    Args:
        track_id: the sign's track.
        undetected: number of frames in a row without a detection.
        prediction: predicted box, shape (4,), px.
        found: the online detector's window.
        accepted: the rescored box if window rescoring accepts it as a sign.
        rejected: the rescored box if window rescoring rejects it and the window's noise is increased.
    """
    dx, dy = _displacement(prediction, found)
    text = (
        f"Track {track_id} has had no detection for {plural(undetected, 'frame')}; a window like it is "
        f"{_offset_text(dx, dy)}"
    )
    values: dict[str, float | int | str] = {
        "undetected": undetected, "dx": dx, "dy": dy, "probability": found.probability,
    }  # fmt: skip
    if rejected is not None:
        text += f", which counts little: rescoring rejects it (score {rejected.score:.1f})."
        return Event("relocalised", track_id, text, values | {"score": rejected.score})
    if accepted is None:
        return Event("relocalised", track_id, f"{text}.", values)
    text += f", where rescoring finds a sign with score {accepted.score:.1f}."
    edges = dict(zip(("x1", "y1", "x2", "y2"), accepted.box.tolist(), strict=True))
    return Event("relocalised", track_id, text, values | {"score": accepted.score} | edges)


def too_far_event(
    track_id: int, undetected: int, prediction: FloatArray, window: Relocalisation, sigmas: float
) -> Event:
    """The event of a window that is too far from the prediction to be the sign."""
    dx, dy = _displacement(prediction, window)
    text = (
        f"Track {track_id} has had no detection for {plural(undetected, 'frame')}; a window like it is "
        f"{_offset_text(dx, dy)}, too far from where it is expected ({sigmas:.1f} standard deviations) to be the sign."
    )
    values = {"undetected": undetected, "dx": dx, "dy": dy, "probability": window.probability, "sigmas": sigmas}
    return Event("rejected", track_id, text, values)


def relabelled_event(track_id: int, before: str, after: str, share: float) -> Event:
    """The event of a change of a track's fused class."""
    text = f"Track {track_id} is now '{after}' with {100 * share:.0f} % of the votes, no longer '{before}'."
    return Event("relabelled", track_id, text, {"before": before, "after": after, "share": share})


def _values(verdict: GateVerdict, gate: GateParams) -> dict[str, float | int | str]:
    return {
        "l_positive": verdict.l_positive,
        "tau": gate.tau,
        "symmetry_magnitude": verdict.symmetry_magnitude,
        "hash_distance": verdict.hash_distance,
        "position_distance": verdict.position_distance,
    }


def _reason(verdict: GateVerdict, gate: GateParams) -> str:
    """The product and its largest factor: ``L = 38.2 > 15, symmetry 0.21 is low``."""
    if gate.position_unit == "side":
        distance, usual = f"{verdict.position_distance:.2f} of its side", _USUAL_SIDES
    else:
        distance, usual = f"{verdict.position_distance:.1f} px", _USUAL_PIXELS
    weights = {
        f"symmetry {verdict.symmetry_magnitude:.2f} is low": verdict.symmetry / _USUAL_SYMMETRY,
        f"its appearance has changed in {verdict.hash_distance:.0f} of 64 bits": verdict.hash_distance / _USUAL_BITS,
        f"it lies {distance} from the last result": verdict.position_distance / usual,
    }
    worst = max(weights, key=lambda name: weights[name])
    relation = ">" if verdict.l_positive > gate.tau else "="
    return f"L = {verdict.l_positive:.1f} {relation} {gate.tau:g}, {worst}"


def _displacement(prediction: FloatArray, found: Relocalisation) -> tuple[float, float]:
    """Displacement from the prediction's centre to the window's, px."""
    before, after = to_cxcywh(prediction), to_cxcywh(found.box)
    return float(after[0] - before[0]), float(after[1] - before[1])


def _offset_text(dx: float, dy: float) -> str:
    """A displacement in words: ``6 px left and 2 px down``."""
    parts = []
    if abs(dx) >= 0.5:
        parts.append(f"{abs(dx):.0f} px {'left' if dx < 0 else 'right'}")
    if abs(dy) >= 0.5:
        parts.append(f"{abs(dy):.0f} px {'up' if dy < 0 else 'down'}")
    return " and ".join(parts) if parts else "in place"
