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

READER_COMPONENTS = (COMPONENT, NETWORK_COMPONENT)
"""The components that signs are read with."""


def load_reader(folder: Path | None = None, reader: Reader = "both") -> SignClassifier | Mixture:
    """What reads signs by the models of a folder; unset: the shipped ones. ``reader`` is the parameter of this name.

    Raises:
        ModelError: missing, damaged, or of another version.
    """
    return make_reader({name: load_component(name, folder) for name in reader_components(folder, reader)})


def reader_components(folder: Path | None, reader: Reader) -> tuple[str, ...]:
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
        "both": READER_COMPONENTS if has_network else (COMPONENT,),
        "classifier": (COMPONENT,),
        "network": (NETWORK_COMPONENT,),
    }[reader]


def make_reader(components: Mapping[str, Component]) -> SignClassifier | Mixture:
    """What reads signs by the components of ``READER_COMPONENTS`` among some.

    Raises:
        ModelError: there is neither, or one of them is damaged.
    """
    readers = [SignClassifier.from_component(components[name]) for name in READER_COMPONENTS if name in components]
    if not readers:
        raise ModelError("Expected a classifier or a network that reads signs. Got neither.")
    if len(readers) == 1:
        return readers[0]
    classifier, network = readers
    classifier_keys, network_keys = ([key.casefold() for key in each.labels or default_keys()] for each in readers)
    indices = {key: index for index, key in enumerate(network_keys)}
    return Mixture(classifier, network, tuple(indices.get(key, -1) for key in classifier_keys))
