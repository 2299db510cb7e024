"""Handles the ONNX network of a run, which a bundle contains or identifies by name and hash.

A network is untrusted code that a C++ library reads. It goes into a bundle only if the bundle's maker names the file.
A network from a bundle is run only if the person who replays it asks for it.
"""

from __future__ import annotations

import re
import shutil
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Final

from tsr_engine.bundle.layout import NETWORK
from tsr_engine.bundle.manifest import NetworkFacts
from tsr_engine.errors import InputError, ModelError, UsageError
from tsr_engine.io.digest import file_sha256

if TYPE_CHECKING:
    from tsr_engine.bundle.load import Bundle
    from tsr_engine.pipeline import Network

MAX_BYTES: Final = 256 << 20
"""Largest network in a bundle: 256 MiB; a large YOLO of today has 220 MB."""
_NAME = re.compile(r"onnx ([1-9][0-9]{0,4})x([1-9][0-9]{0,4}) (v8|v5)")


def network_of(models: Mapping[str, str]) -> NetworkFacts | None:
    """The network among the models of a run, as :func:`tsr_engine.pipeline.load_components` records it; None: none."""
    for name, digest in models.items():
        found = _NAME.fullmatch(name)
        if found is not None and re.fullmatch("[0-9a-f]{64}", digest):
            layout = "v8" if found[3] == "v8" else "v5"
            return NetworkFacts.model_validate(
                {"sha256": digest, "width": int(found[1]), "height": int(found[2]), "layout": layout, "inside": False}
            )
    return None


def add_network(models: Mapping[str, str], path: Path | None, folder: Path) -> NetworkFacts | None:
    """Copy the network of a run into a bundle, if its file is named and not too large.

    Args:
        models: component -> sha256, from the run.
        path: the network's file; None: not named.
        folder: folder of the new bundle.

    Returns:
        The manifest's entry; None: the run used no network.

    Raises:
        UsageError: a network was named that the run did not use.
        InputError: the file cannot be read.
    """
    info = network_of(models)
    if path is None or info is None:
        if path is not None:
            raise UsageError(f"The run used no ONNX network, so {path} does not belong to it. Leave --onnx out.")
        return info
    try:
        digest, size = file_sha256(path), path.stat().st_size
    except OSError as error:
        raise InputError(f"Cannot read the network {path}: {error.strerror}. Check --onnx.") from None
    if digest != info.sha256:
        raise UsageError(
            f"{path} is not the network of the run: its SHA-256 is {digest[:12]}..., the run used "
            f"{info.sha256[:12]}... . Name that file."
        )
    if size > MAX_BYTES:
        return info
    shutil.copyfile(path, folder / NETWORK)
    return info.model_copy(update={"inside": True})


def network_text(info: NetworkFacts) -> str:
    """One or two sentences for people: the network, whether the bundle has it, and what to do."""
    description = (
        f"The run detected with an ONNX network ({info.width}x{info.height}, {info.layout}, SHA-256 {info.sha256})"
    )
    if info.inside:
        return f"{description}, which is inside. Replay with --bundled-models to use it."
    return (
        f"{description}, which is NOT inside: it was not named with --onnx when the bundle was made, or has more than "
        f"{MAX_BYTES >> 20} MiB. Ask for that file and replay with --onnx FILE."
    )


def replay_network(bundle: Bundle, path: Path | None, use_bundled: bool, use_detector: bool) -> Network | None:
    """The network for a replay; None: the detector of the model folder is used.

    Args:
        bundle: the bundle.
        path: a network that the person names.
        use_bundled: whether to use the network in the bundle.
        use_detector: whether to replay without the run's network.

    Raises:
        UsageError: a network is named, but the run used none.
        ModelError: the run used a network, and no option says which one to use; names it by its hash.
    """
    from tsr_engine.pipeline import Network

    info = bundle.manifest.network or network_of(bundle.manifest.run.models)
    if info is None:
        if path is not None:
            raise UsageError(f"The run of {bundle.name} used no ONNX network. Leave --onnx out.")
        return None
    if path is None and use_bundled and info.inside:
        path = bundle.folder / NETWORK
    if path is not None:
        return Network(path, (info.width, info.height), info.layout)
    if use_detector:
        return None
    description = f"an ONNX network ({info.width}x{info.height}, {info.layout}, SHA-256 {info.sha256})"
    if info.inside:
        raise ModelError(
            f"The run of {bundle.name} detected with {description}, which came with the bundle. Say --bundled-models "
            "to run it, --onnx FILE for a file of yours, or --other-models for the detector of this installation."
        )
    raise ModelError(
        f"The run of {bundle.name} detected with {description}, which is not in the bundle. Ask its maker for that "
        "file and name it with --onnx FILE, or say --other-models to replay with the detector of this installation."
    )
