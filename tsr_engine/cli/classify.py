"""`tsr classify`: the class of single crops."""

# ruff: noqa: D301 - "\b" keeps the examples in help texts from being wrapped

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from tsr_engine.cli.common import (
    FormerNetworkOption,
    JsonOption,
    ModelsOption,
    ReaderOption,
    make_reader,
    print_json,
    say,
)
from tsr_engine.errors import InputError
from tsr_engine.plural import plural

BATCH_SIZE = 256


def classify(
    sources: Annotated[
        list[Path],
        typer.Argument(metavar="FOLDER_OR_CSV...", help="GTSRB class folders, tables, or crops in a folder."),
    ],
    csv: Annotated[Path, typer.Option("--csv", metavar="OUT", help="Write filename,class_id,probability.")],
    models: ModelsOption = None,
    reader: ReaderOption = None,
    network: FormerNetworkOption = False,
    json: JsonOption = False,
) -> None:
    """Classify crops of signs.

    Reads GTSRB class folders (with GT-000CC.csv), the benchmark's test table (Filename;Width;Height;Roi.X1;...), and
    folders of loose crops. The region of interest of a table is used; a loose crop is expected to have a border of
    about a tenth on each side, as in GTSRB. File names are relative to the named folder or table. After Ctrl-C the
    finished rows are kept.

    \b
    Examples:
      tsr classify Final_Training/Images --csv classes.csv
      tsr classify Final_Test/Images/GT-final_test.csv --csv classes.csv
    """
    from tsr_engine.cli.interrupt import leave_interrupted, stop_on_interrupt
    from tsr_engine.cli.progress import progress_bar
    from tsr_engine.evaluation.classification import crop_of
    from tsr_engine.io.atomic import atomic_text, refuse_inputs
    from tsr_engine.io.gtsrb import read_items
    from tsr_engine.pipeline import load_reader

    reader_kind = make_reader(reader, network)
    items = [(source if source.is_dir() else source.parent, item) for source in sources for item in read_items(source)]
    refuse_inputs([csv], [*sources, *(item.path for _, item in items)])
    classifier = load_reader(models, reader_kind)
    unreadable = done = correct = labelled = 0
    with stop_on_interrupt() as stopped, atomic_text(csv) as out, progress_bar("classifying", "crops") as show:
        out.write("filename,class_id,probability\n")
        for first in range(0, len(items), BATCH_SIZE):
            batch = items[first : first + BATCH_SIZE]
            names, crops, truth = [], [], []
            for root, item in batch:
                try:
                    crops.append(crop_of(item, classifier.margin))
                except InputError as error:
                    say(str(error))
                    unreadable += 1
                    continue
                names.append(item.path.relative_to(root).as_posix())
                truth.append(item.class_id)
            if crops:
                table = classifier.probabilities(crops)
                for name, row, class_id in zip(names, table, truth, strict=True):
                    best = int(row.argmax())
                    out.write(f"{_quoted(name)},{best},{float(row[best]):.6f}\n")
                    labelled += class_id is not None
                    correct += class_id == best
            done += len(crops)
            show(done + unreadable, len(items), "")
            if stopped():
                break
    read = done + unreadable
    interrupted = read < len(items)
    if json:
        counts = {"crops": done, "unreadable": unreadable, "labelled": labelled}
        accuracy = correct / labelled if labelled else None
        print_json({**counts, "accuracy": accuracy, "interrupted": interrupted, "csv": str(csv)})
    else:
        agreement = (
            f", {100 * correct / labelled:.2f} % of {labelled} labelled ones agree with their table" if labelled else ""
        )
        typer.echo(f"{plural(done, 'crop')}{agreement}: {csv}")
    unreadable_message = f"{unreadable} of {read} crops could not be read; the others are in {csv}."
    if interrupted:
        leave_interrupted(
            f"{read} of {len(items)} crops are done. {unreadable_message if unreadable else f'See {csv}.'}"
        )
    if unreadable:
        raise InputError(unreadable_message)


def _quoted(name: str) -> str:
    name = name.encode("utf-8", "backslashreplace").decode()  # a file's name may be no UTF-8
    return '"' + name.replace('"', '""') + '"' if set(name) & set(',"\n\r') else name
