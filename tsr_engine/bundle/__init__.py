"""Bug bundles: one ZIP file that shows a problem to another person and replays it.

::

    make_bundle(BundleRequest(Path("runs/drive"), Path("drive.mp4"), Path("bug.zip"), 100, 160, "the 50 reads as 80"))
    with open_bundle(Path("bug.zip")) as bundle:
        params, strange = bundle_params(bundle)
        report = replay_bundle(bundle, params, load_components(params))

Names are imported on first use, so that opening a bundle does not load the engine.
"""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from tsr_engine.bundle.expectation import Bounds, Expectation, Expected, ExpectedSign, read_expectation
    from tsr_engine.bundle.layout import EXIT_CODES, MAX_FRAMES, Verdict
    from tsr_engine.bundle.load import Bundle, is_bundle, open_bundle
    from tsr_engine.bundle.make import make_bundle
    from tsr_engine.bundle.network import replay_network
    from tsr_engine.bundle.replay import BundleReplay, bundle_params, bundled_models, replay_bundle
    from tsr_engine.bundle.request import BundleReport, BundleRequest

__all__ = [
    "EXIT_CODES",
    "MAX_FRAMES",
    "Bounds",
    "Bundle",
    "BundleReplay",
    "BundleReport",
    "BundleRequest",
    "Expectation",
    "Expected",
    "ExpectedSign",
    "Verdict",
    "bundle_params",
    "bundled_models",
    "is_bundle",
    "make_bundle",
    "open_bundle",
    "read_expectation",
    "replay_bundle",
    "replay_network",
]

_EXPORTS_BY_MODULE = {
    "expectation": ("Bounds", "Expectation", "Expected", "ExpectedSign", "read_expectation"),
    "layout": ("EXIT_CODES", "MAX_FRAMES", "Verdict"),
    "load": ("Bundle", "is_bundle", "open_bundle"),
    "make": ("make_bundle",),
    "network": ("replay_network",),
    "replay": ("BundleReplay", "bundle_params", "bundled_models", "replay_bundle"),
    "request": ("BundleReport", "BundleRequest"),
}


def __getattr__(name: str) -> object:
    for module, names in _EXPORTS_BY_MODULE.items():
        if name in names:
            return getattr(import_module(f"{__name__}.{module}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
