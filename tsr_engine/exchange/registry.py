"""Lists all formats by name, in the order in which they are offered and recognised."""

from __future__ import annotations

from tsr_engine.errors import UsageError
from tsr_engine.exchange.coco import writer as coco
from tsr_engine.exchange.cvat import images as cvat_images
from tsr_engine.exchange.cvat import video as cvat_video
from tsr_engine.exchange.datumaro import writer as datumaro
from tsr_engine.exchange.formats import Format
from tsr_engine.exchange.gtsdb import writer as gtsdb
from tsr_engine.exchange.gtsrb import writer as gtsrb_crops
from tsr_engine.exchange.label_studio import writer as label_studio
from tsr_engine.exchange.mot import writer as mot
from tsr_engine.exchange.tracks_csv import writer as tracks_csv
from tsr_engine.exchange.tracks_json import writer as tracks_json
from tsr_engine.exchange.voc import writer as voc
from tsr_engine.exchange.yolo import writer as yolo

FORMATS: dict[str, Format] = {
    known.name: known
    for known in (
        cvat_video.FORMAT,
        cvat_images.FORMAT,
        coco.FORMAT,
        yolo.FORMAT,
        voc.FORMAT,
        mot.FORMAT,
        gtsrb_crops.FORMAT,
        gtsdb.FORMAT,
        datumaro.FORMAT,
        label_studio.FORMAT,
        tracks_csv.FORMAT,
        tracks_json.FORMAT,
    )
}


def format_named(name: str) -> Format:
    """Look up a format by name.

    Raises:
        UsageError: the name is unknown; lists the known names.
    """
    try:
        return FORMATS[name]
    except KeyError:
        raise UsageError(f"There is no format {name!r}. Choose one of {', '.join(FORMATS)}.") from None


def complete_switches(format: Format, given: dict[str, str], *, reading: bool) -> dict[str, str]:
    """The options of a format, with defaults for missing ones.

    Args:
        format: the format.
        given: options by name.
        reading: take the options of the reader, else of the writer.

    Raises:
        UsageError: an option that the format does not have, or a value that is not allowed.
    """
    known = {switch.name: switch for switch in (format.import_switches if reading else format.export_switches)}
    for name, value in given.items():
        if name not in known:
            have = ", ".join(known) or "none"
            raise UsageError(f"{format.title} has no option {name!r}; its options are: {have}. Leave it out.")
        if value not in known[name].values and not (known[name].free and value.strip()):
            can = ", ".join(known[name].values)
            raise UsageError(f"The option {name} of {format.title} must be one of {can}. Got {value!r}.")
    return {name: given.get(name, switch.values[0]) for name, switch in known.items()}
