"""Reads and writes ``manifest.json``: the content of a bundle, its origin, and the hash of every file."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from tsr_engine.bundle.layout import FORMAT, MANIFEST, MAX_FRAMES
from tsr_engine.errors import ImportFormatError
from tsr_engine.json_shapes import JsonObject

_Text = Annotated[str, Field(max_length=20_000, pattern=r"^[^\x00]*$")]
_Digest = Annotated[str, Field(pattern="^[0-9a-f]{64}$")]
_Frame = Annotated[int, Field(ge=0, le=2**31 - 1)]
_Side = Annotated[int, Field(ge=1, le=16_384)]


class _Part(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


class BundleFile(_Part):
    """A file beside the manifest."""

    name: Annotated[str, Field(min_length=1, max_length=200)]
    size: Annotated[int, Field(ge=0)]
    sha256: _Digest


class BundleFrames(_Part):
    """Frame numbers of the original video."""

    start: _Frame
    """First frame of the engine, so that its state at ``first`` is that of the run."""
    first: _Frame
    """First judged frame."""
    stop: Annotated[int, Field(ge=1, le=2**31 - 1)]
    """Frame after the last."""
    whole_lead_in: bool
    """False: tracks that were alive at ``start`` are missing, and the first frames may differ."""
    first_id: Annotated[int, Field(ge=1, le=10**12)]
    """Number of the first track that is born from ``start`` on."""

    @model_validator(mode="after")
    def _check(self) -> BundleFrames:
        if not self.start <= self.first < self.stop <= self.start + MAX_FRAMES:
            raise ValueError(f"frames must be start <= first < stop, at most {MAX_FRAMES} of them")
        return self


class ClipFacts(_Part):
    """The clip."""

    file: Literal["clip.mp4", "clip.mkv"]
    sha256: _Digest
    offset: _Frame
    """Ordinal of the clip's frame 0 in the original video."""
    width: _Side
    height: _Side
    copied: bool
    how: _Text

    @model_validator(mode="after")
    def _check(self) -> ClipFacts:
        if self.width * self.height > 2**28:
            raise ValueError("the pictures are too large")
        return self


class SourceVideo(_Part):
    """The video that the clip was cut from."""

    name: _Text
    sha256: _Digest
    size: Annotated[int, Field(ge=0)]


class BundleRun(_Part):
    """The run of the bundle."""

    id: _Text
    name: _Text
    kind: Literal["engine", "whatif"]
    preset: _Text
    created: _Text
    engine_version: _Text
    parameters: JsonObject
    models: dict[str, str]
    interval: Annotated[float, Field(gt=0, le=1e6)]
    """Nominal seconds between two frames."""


class NetworkFacts(_Part):
    """The ONNX network of the run."""

    sha256: _Digest
    width: _Side
    """Size of its input, px."""
    height: _Side
    layout: Literal["v8", "v5"]
    """Layout of its output, see :mod:`tsr_engine.detection.onnx`."""
    inside: bool


class Got(_Part):
    """The verdict on an expectation when the bundle was made."""

    id: _Text
    met: bool
    text: _Text


class Manifest(_Part):
    """The content of ``manifest.json``."""

    bundle: Literal[1] = FORMAT
    tool_version: _Text
    note: _Text
    tracks: list[_Text]
    """Keys of the tracks that the report is about; empty: all corrected ones."""
    frames: BundleFrames
    clip: ClipFacts
    video: SourceVideo
    run: BundleRun
    models: _Text
    """The models of the run, and whether the bundle has them."""
    models_inside: bool
    network: NetworkFacts | None = None
    """The network that replaced the detector; None: the run used none."""
    recording: _Text
    """Whether there is a recording; if not, the reason."""
    got: list[Got]
    files: list[BundleFile]

    def text(self) -> str:
        """The JSON text that is stored; without a network in the form that earlier versions read."""
        content = self.model_dump(mode="json", exclude={"network"} if self.network is None else None)
        return json.dumps(content, indent=1, sort_keys=True, ensure_ascii=False) + "\n"

    @classmethod
    def read(cls, folder: Path, name: str) -> Manifest:
        """Read and check the manifest of an unpacked bundle; ``name`` is the bundle's in messages.

        Raises:
            ImportFormatError: missing, of another format version, or invalid; names the place.
        """
        path = folder / MANIFEST
        if not path.is_file():
            raise ImportFormatError(f"{name} is not a bug bundle: {MANIFEST} is missing. Make one with `tsr bundle`.")
        try:
            content = json.loads(path.read_text(encoding="utf-8"))
        except (ValueError, RecursionError):
            raise ImportFormatError(f"{name}, {MANIFEST}: is not JSON. Copy the bundle again.") from None
        version = content.get("bundle") if isinstance(content, dict) else None
        if type(version) is not int:
            raise ImportFormatError(
                f"{name} is not a bug bundle: {MANIFEST} does not state its version. Check the file."
            )
        if version != FORMAT:
            advice = "Update tsr" if version > FORMAT else "Create the bundle again"
            raise ImportFormatError(
                f"{name} is a bug bundle of format {version}, this version reads format {FORMAT}. {advice}."
            )
        try:
            return cls.model_validate(content)
        except ValidationError as error:
            first = error.errors()[0]
            key_path = ".".join(map(str, first["loc"]))[:120] or "it"
            message = first["msg"][:200]
            raise ImportFormatError(f"{name}, {MANIFEST}, {key_path}: {message}. Create the bundle again.") from None
