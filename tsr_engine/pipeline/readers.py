"""What reads the signs of a run: the classifier of the models, their network, or both together."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from tsr_engine.errors import ModelError
from tsr_engine.io.models import SHIPPED, Component, load_component, read_manifest
from tsr_engine.labels.classes import default_keys
from tsr_engine.params import Reader
from tsr_engine.recognition.classifier import COMPONENT, NETWORK_COMPONENT, SignClassifier
from tsr_engine.recognition.mixture import Mixture

__all__ = ["READING", "load_reader", "reader_of", "reading_parts"]

READING = (COMPONENT, NETWORK_COMPONENT)
"""The components that signs are read with."""


def load_reader(folder: Path | None = None, reader: Reader = "both") -> SignClassifier | Mixture:
    """What reads signs by the models of a folder; unset: the shipped ones.

    Args:
        folder: the model folder.
        reader: as the parameter of this name.

    Raises:
        ModelError: missing, damaged, or of another version.
    """
    return reader_of({name: load_component(name, folder) for name in reading_parts(folder, reader)})


def reading_parts(folder: Path | None, reader: Reader) -> tuple[str, ...]:
    """Names of the components of a folder that read signs.

    Raises:
        ModelError: no manifest, or the network alone is asked for and not there.
    """
    where = SHIPPED if folder is None else folder
    has_network = NETWORK_COMPONENT in read_manifest(where)["components"]
    if reader == "network" and not has_network:
        raise ModelError(
            f"The models in {where} have no network that reads signs. Set reader to both or classifier, or train a "
            "network with `tsr train network`."
        )
    return {
        "both": READING if has_network else (COMPONENT,),
        "classifier": (COMPONENT,),
        "network": (NETWORK_COMPONENT,),
    }[reader]


def reader_of(parts: Mapping[str, Component]) -> SignClassifier | Mixture:
    """What reads signs by the components of ``READING`` among some.

    Raises:
        ModelError: there is neither, or one of them is damaged.
    """
    found = [SignClassifier.from_component(parts[name]) for name in READING if name in parts]
    if not found:
        raise ModelError("Expected a classifier or a network that reads signs. Got neither.")
    if len(found) == 1:
        return found[0]
    classifier, network = found
    own, other = ([key.casefold() for key in one.labels or default_keys()] for one in found)
    places = {key: place for place, key in enumerate(other)}
    return Mixture(classifier, network, tuple(places.get(key, -1) for key in own))
