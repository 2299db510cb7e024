"""Every parameter of a run, by name, with its default, range and meaning.

Leaf names are unique over all sections, so ``tau=20`` and ``gate.tau=20`` mean the same.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from pydantic import ValidationError

from tsr_engine.errors import UsageError
from tsr_engine.params.aliases import current_setting
from tsr_engine.params.base import Section
from tsr_engine.params.detector import DetectorParams, PriorParams
from tsr_engine.params.fusion import FusionParams
from tsr_engine.params.gate import GateParams
from tsr_engine.params.online import OnlineParams
from tsr_engine.params.pipeline import PipelineParams, Reader
from tsr_engine.params.presets import PRESETS
from tsr_engine.params.tracking import TrackingParams

__all__ = [
    "PRESETS",
    "DetectorParams",
    "FusionParams",
    "GateParams",
    "OnlineParams",
    "Params",
    "PipelineParams",
    "PriorParams",
    "Reader",
    "Section",
    "TrackingParams",
]


class Params(Section):
    """All parameters of a run. Immutable; stored with every run."""

    detector: DetectorParams = DetectorParams()
    prior: PriorParams = PriorParams()
    tracking: TrackingParams = TrackingParams()
    gate: GateParams = GateParams()
    online: OnlineParams = OnlineParams()
    fusion: FusionParams = FusionParams()
    pipeline: PipelineParams = PipelineParams()

    @classmethod
    def preset(cls, name: str) -> Params:
        """The parameters of a named preset.

        Raises:
            UsageError: the preset is unknown.
        """
        if name not in PRESETS:
            raise UsageError(f"There is no preset '{name}'. Choose one of: {', '.join(sorted(PRESETS))}.")
        return cls().with_settings(PRESETS[name].items())

    def with_settings(self, settings: Iterable[tuple[str, object]]) -> Params:
        """A copy with some parameters changed.

        Args:
            settings: pairs of a name (``tau`` or ``gate.tau``) and a value or its text. Old names of renamed parameters
                are valid; :mod:`tsr_engine.params.aliases` has their warnings.

        Raises:
            UsageError: a name is unknown, or a value is out of range, NaN or of a wrong type.
        """
        tree = self.model_dump()
        places = {leaf: (section, leaf) for section, leaf in self.names()}
        places |= {f"{section}.{leaf}": (section, leaf) for section, leaf in self.names()}
        for given, wanted in settings:
            name, value = current_setting(given, wanted)
            if name not in places:
                raise UsageError(f"There is no parameter '{name}'. `tsr track --help` lists them all.")
            section, leaf = places[name]
            parsed = _parse(value)
            if _has_switch(parsed) and not self._is_switch(section, leaf):
                raise UsageError(f"Parameter {section}.{leaf}: must not be true or false. Got {value!r} instead.")
            alone = isinstance(parsed, str) and isinstance(tree[section][leaf], tuple)
            tree[section][leaf] = (parsed,) if alone else parsed
        try:
            return type(self).model_validate(tree)
        except ValidationError as error:
            first = error.errors()[0]
            where = ".".join(str(part) for part in first["loc"])
            raise UsageError(f"Parameter {where}: {first['msg']}. Got {first['input']!r} instead.") from None

    @classmethod
    def _is_switch(cls, section: str, leaf: str) -> bool:
        annotation = cls.model_fields[section].annotation
        assert isinstance(annotation, type)
        assert issubclass(annotation, Section)
        return annotation.model_fields[leaf].annotation is bool

    @classmethod
    def names(cls) -> Iterator[tuple[str, str]]:
        """All ``(section, leaf)`` names in order."""
        for section, field in cls.model_fields.items():
            annotation = field.annotation
            assert isinstance(annotation, type)
            assert issubclass(annotation, Section)
            for leaf in annotation.model_fields:
                yield section, leaf


def _has_switch(value: object) -> bool:
    """Whether a value is or contains true or false, which pydantic would convert to 1 and 0."""
    return any(isinstance(part, bool) for part in (value if isinstance(value, list | tuple) else (value,)))


def _parse(value: object) -> object:
    """Convert text of the command line to a value for pydantic; ``none`` and comma-separated lists are valid."""
    if not isinstance(value, str):
        return value
    text = value.strip()
    if text.startswith("[") and text.endswith("]"):  # `tsr params` shows lists this way
        text = text[1:-1].strip()
    if text.lower() in {"none", "null"}:
        return None
    if "," in text:
        return tuple(part.strip() for part in text.split(",") if part.strip())
    return text
