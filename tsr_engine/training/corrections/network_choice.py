"""Decides whether a refined version keeps the network that reads signs.

The network does not learn from corrections. A network that is sure of an old reading can outvote the classifier that
the corrections have taught.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from tsr_engine.io.models import Component
from tsr_engine.json_shapes import JsonMapping, JsonObject
from tsr_engine.pipeline import make_reader
from tsr_engine.recognition.classifier import normalise_logarithms
from tsr_engine.recognition.mixture import Mixture, pool_probabilities
from tsr_engine.training.corrections.holdout import right_shares
from tsr_engine.training.corrections.refine_classifier import SignCrop
from tsr_engine.training.synthetic.classifier_augmentation import plain_view

__all__ = ["compare_with_network", "network_note"]


def compare_with_network(parts: Mapping[str, Component], crops: Sequence[SignCrop]) -> JsonObject:
    """Compare both readers of a refined version on the signs that it has learned from.

    Args:
        parts: components of the version, with the refined classifier and the network.
        crops: of the corrected signs, at least one.

    Returns:
        ``signs_right`` and ``signs_right_without``, the shares of signs read right with and without the network, in
        [0, 1]; ``kept``, whether the first is at least as high.
    """
    reader = make_reader(parts)
    assert isinstance(reader, Mixture)
    classifier_logs, network_logs = reader.logarithms([plain_view(item.crop) for item in crops])
    without, both = (
        right_shares(answers, crops)["signs_right"]
        for answers in (
            normalise_logarithms(classifier_logs),
            pool_probabilities(classifier_logs, network_logs, reader.known),
        )
    )
    return {"kept": both >= without, "signs_right": both, "signs_right_without": without}


def network_note(found: JsonMapping | None) -> list[str]:
    """The sentence for people about a network that was left out; none if it was kept or there is none."""
    if found is None or found["kept"]:
        return []
    return [
        f"The network that reads signs: with it {found['signs_right']:.3f} of the corrected signs are read right, "
        f"without it {found['signs_right_without']:.3f}. The classifier of the new version reads alone."
    ]
