"""Names the files of a bug bundle and the verdicts of its replay."""

from __future__ import annotations

from typing import Final, Literal

FORMAT: Final = 1
"""Version of the layout; increased when older readers would misunderstand a newer bundle."""

MANIFEST: Final = "manifest.json"
README: Final = "README.txt"
CLIP_STEM: Final = "clip"
FRAMES: Final = "frames.csv"
OUTPUT: Final = "output.csv"
EVIDENCE: Final = "evidence"
EXPECTATION: Final = "expectation.json"
CORRECTIONS: Final = "corrections.json"
RECORDING: Final = "recording.rrd"
MODELS: Final = "models"
NETWORK: Final = "network.onnx"

MAX_FRAMES: Final = 3000
"""Most frames of a bundle, with the lead-in: two minutes of video."""

Verdict = Literal["fixed", "still broken", "unchanged", "different"]

EXIT_CODES: Final[dict[Verdict, int]] = {"fixed": 0, "still broken": 20, "unchanged": 20, "different": 21}
"""Exit codes of a replay; those of errors are below 10 or above 100."""
