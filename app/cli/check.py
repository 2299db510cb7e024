"""``tsr check``: reviewed drives as a regression suite for models and parameters."""

# ruff: noqa: D301 - "\b" keeps the examples in help texts from being wrapped

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from app.cli.library import HomeOption
from tsr_engine.cli.batch import BatchProgressPrinter, CoresOption, JobsOption, MemoryOption, PlaceOption, batch_request
from tsr_engine.cli.common import JsonOption, ModelsOption, PresetOption, SetOption, out_console, print_json, say
from tsr_engine.errors import InputError
from tsr_engine.plural import plural

if TYPE_CHECKING:
    from app.check.reviewed import ReviewedDrive
    from app.check.run import CheckReport

EXIT_OVER_BUDGET = 22


def check(
    out: Annotated[Path, typer.Option("--out", metavar="DIR", help="Folder of the report and the new results.")],
    videos: Annotated[
        list[str] | None,
        typer.Argument(metavar="[VIDEO...]", help="Reviewed videos or runs; unset: all of the data folder."),
    ] = None,
    home: HomeOption = None,
    models: ModelsOption = None,
    preset: PresetOption = "default",
    settings: SetOption = [],  # noqa: B006 - typer copies it
    budget: Annotated[
        list[str], typer.Option("--budget", metavar="FIGURE=DIFF", help="How much worse a figure may get; repeatable.")
    ] = [],  # noqa: B006 - typer copies it
    bundles: Annotated[
        int, typer.Option("--bundles", min=0, max=100, help="Number of worst regressions to pack as bug bundles.")
    ] = 3,
    place: PlaceOption = "local",
    jobs: JobsOption = None,
    cores: CoresOption = None,
    memory: MemoryOption = 6144,
    json: JsonOption = False,
) -> None:
    """Run reviewed drives again with other models or parameters, and compare.

    Accepted and drawn tracks are the signs to find, rejected tracks must not come back, and undecided tracks are
    ignored. The figures are found, coverage, read (higher is better, in %), false (false tracks per 1,000 frames) and
    error (Eq. 7). A budget says how much worse a figure may get. Exit code 22: a budget is exceeded.

    \b
    Examples:
      tsr check --models new --out check
      tsr check drive.mp4 --models new --budget coverage=-0.5 --budget read=0 --out check
      tsr check --set tau=25 --budget false=1 --on ray://head:10001 --out /shared/check
    """
    from app.check.figures import budgets
    from app.check.run import check as run_check
    from tsr_engine.cli.interrupt import leave_interrupted, stop_on_interrupt

    allowed = budgets(budget)
    drives = _reviewed(videos or [], home)
    request = batch_request(
        [], out, place, jobs, cores, {"csv", "evidence"}, memory, preset, settings, models, None, count=len(drives)
    )
    with stop_on_interrupt() as stopped:
        report = run_check(drives, request, allowed, BatchProgressPrinter(), stopped)
        if report is None:
            leave_interrupted(f"Finished drives are kept in {out}. Run the same command again to go on.")
    from app.check.report import CHECK_HTML, as_json, write_bundles, write_report

    write_report(report, out)
    made = write_bundles(report, out / "bundles", bundles, say)
    if json:
        print_json(as_json(report))
    else:
        _print(report, out / CHECK_HTML, len(made))
    for video, error in report.failures:
        say(f"{video}: {error}")
    for sentence in report.over:
        say(f"over budget: {sentence}")
    if report.over:
        raise typer.Exit(EXIT_OVER_BUDGET)
    if report.failures:
        raise InputError(f"{plural(len(report.failures), 'drive')} could not be tracked; the others are compared.")


def _reviewed(videos: list[str], home: Path | None) -> list[ReviewedDrive]:
    """The reviewed drives of the names; without names, the newest run with edits of each video of the data folder.

    Imported runs count only for a video of which no run of the engine has edits.
    """
    from sqlalchemy import select

    from app.check.reviewed import reviewed_drive
    from app.cli.data_folder import find_run, open_home
    from app.cli.run_names import as_command_error
    from app.exchange.run_sources import run_source
    from app.storage.lookup import current_run_last
    from app.storage.models import Run, TrackDocument

    with as_command_error(), open_home(home) as (settings, database), database.read() as session:
        if videos:
            wanted = list(dict.fromkeys(find_run(session, name) for name in videos))
        else:
            query = select(Run).where(Run.state == "complete", Run.kind != "whatif")
            query = query.where(Run.id.in_(select(TrackDocument.run_id).distinct()))
            newest = {run.video_id: run.id for run in session.scalars(query.order_by(*current_run_last()))}
            wanted = list(newest.values())
        found = [reviewed_drive(run_source(session, settings, run_id)) for run_id in wanted]
    drives = [drive for drive in found if drive is not None]
    if not drives:
        raise InputError("There is nothing to check against: no track has been accepted, drawn or rejected yet.")
    return drives


def _print(report: CheckReport, page: Path, bundles: int) -> None:
    from rich.table import Table

    from app.check.figures import FIGURES
    from app.check.report import describe_regression

    table = Table(box=None, pad_edge=False, header_style="bold")
    table.add_column("figure")
    for name in ("before", "after", "difference", "95 % of samples"):
        table.add_column(name, justify="right")
    for change in report.changes:
        table.add_row(FIGURES[change.name][0], *change.shown())
    console = out_console()
    signs = sum(len(drive.after.signs) for drive in report.drives)
    console.print(f"{plural(len(report.drives), 'reviewed drive')} with {plural(signs, 'sign')}.", soft_wrap=True)
    console.print(table)
    for place in report.places[:10]:
        console.print(describe_regression(place, report.drives), soft_wrap=True)
    more = len(report.places) - 10
    rest = f" {more} more places got worse." if more > 0 else ""
    console.print(f"See {page}; {plural(bundles, 'bug bundle')}.{rest}", soft_wrap=True)
