"""Views of formats for pages and programs."""

from __future__ import annotations

from app.body_model import Model
from tsr_engine.exchange.formats import Format


class SwitchView(Model):
    """An option of one format."""

    name: str
    values: list[str]
    """Possible values, the default first."""
    help: str
    free: bool
    """Other texts are allowed too."""


class FormatView(Model):
    """One format of annotation files."""

    name: str
    title: str
    summary: str
    """One sentence."""
    can_export: bool
    can_import: bool
    needs_pictures: bool
    allows_pictures: bool
    ignores: bool
    """It can mark regions to ignore."""
    key_frames: bool
    """It marks key frames, so that the limit of thinning matters."""
    export_switches: list[SwitchView]
    import_switches: list[SwitchView]
    docs: str


def format_view(format: Format) -> FormatView:
    """Convert a format to its view."""
    return FormatView.from_row(
        format,
        can_export=format.write is not None,
        can_import=format.read is not None,
        export_switches=[SwitchView.from_row(each, values=list(each.values)) for each in format.export_switches],
        import_switches=[SwitchView.from_row(each, values=list(each.values)) for each in format.import_switches],
    )
