"""The corpus of unusual videos, for recordings with clips."""

from __future__ import annotations

from tests.io.conftest import make_video

__all__ = ["make_video"]
