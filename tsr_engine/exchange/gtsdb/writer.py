"""Writes ``gt.txt`` and the list of pictures."""

from __future__ import annotations

from tsr_engine.exchange.dataset import Dataset, Skipped
from tsr_engine.exchange.formats import ExportOptions, Format, Switch, Written
from tsr_engine.exchange.gtsdb.reader import GROUND_TRUTH_FILE, PICTURE_LIST, read_gtsdb, sniff_gtsdb
from tsr_engine.exchange.labels import benchmark_numbers
from tsr_engine.exchange.linking import LINK_SWITCH
from tsr_engine.exchange.output_sink import OutputSink
from tsr_engine.exchange.picture_lists import IMAGE_SWITCH, PictureList, make_picture_lists, write_listed_pictures
from tsr_engine.exchange.picture_sequences import PICTURE_SWITCHES
from tsr_engine.exchange.rounding import round_to_pixels
from tsr_engine.exchange.split import names_of_subsets
from tsr_engine.plural import plural


def _write(dataset: Dataset, out: OutputSink, options: ExportOptions) -> Written:
    suffix = options.switches.get("image", "jpg")
    corners = options.switches.get("corners", "inclusive")
    numbers = benchmark_numbers(dataset.labels)
    lists = make_picture_lists(dataset, options)
    total = sum(len(part.frames) for part in lists)
    done = ignored = unknown = 0
    for subset in names_of_subsets(options.split):
        prefix = f"{subset}/" if options.split else ""
        with (
            out.text(prefix + GROUND_TRUTH_FILE, encoding="ascii") as ground_truth,
            out.text(prefix + PICTURE_LIST, encoding="ascii") as picture_list,
        ):
            for part in lists:
                rows = part.rows
                boxes = round_to_pixels(rows.table.boxes, part.video.width, part.video.height)
                if corners == "inclusive":
                    boxes[:, 2:] -= 1
                edges = boxes.tolist()
                for frame, row_range in part.frames_and_rows(subset):
                    name = _name(part, frame, suffix)
                    picture_list.write(f"{name}\n")
                    for k in range(row_range.start, row_range.stop):
                        label = int(rows.table.class_id[k])
                        if rows.table.ignore[k]:
                            ignored += 1
                        elif label not in numbers:
                            unknown += 1
                        else:
                            ground_truth.write(f"{name};{';'.join(map(str, edges[k]))};{numbers[label]}\n")
                    done += 1
                    options.progress(done, total)
    pictures = write_listed_pictures(
        lists,
        out,
        options,
        lambda part, frame, subset: (f"{subset}/" if options.split else "") + _name(part, frame, suffix),
    )
    skipped = [Skipped(plural(ignored, "box", "boxes") + " to ignore", "gt.txt has no such mark.")] if ignored else []
    reason = "Their label is not one of the 43 classes that gt.txt has numbers for."
    skipped += [Skipped(plural(unknown, "box", "boxes"), reason)] if unknown else []
    meaning = (
        "right and bottom are the last pixels of the sign" if corners == "inclusive" else "right, bottom are edges"
    )
    return skipped, {"origin": 0, "corners": corners, "meaning": meaning, "pictures": pictures}


def _name(part: PictureList, frame: int, suffix: str) -> str:
    """As in the benchmark, ``00010.ppm``; with several videos, the video's name comes first."""
    return f"{part.stem(frame) if part.prefix else f'{frame:05d}'}.{suffix}"


FORMAT = Format(
    name="gtsdb",
    title="GTSDB gt.txt",
    summary="One line per sign in whole pixels, as in the German detection benchmark; without tracks.",
    write=_write,
    read=read_gtsdb,
    sniff=sniff_gtsdb,
    export_switches=(
        Switch("corners", ("inclusive", "exclusive"), "Right and bottom: the last pixels of the sign, or its edges."),
        Switch("image", ("jpg", "png", "ppm"), IMAGE_SWITCH.help),
    ),
    import_switches=(
        Switch(
            "corners", ("auto", "inclusive", "exclusive"), "As for export; auto: as the manifest says, else inclusive."
        ),
        *PICTURE_SWITCHES,
        LINK_SWITCH,
    ),
    attributes="none",
    ignores=False,
    docs="gtsdb.md",
)
