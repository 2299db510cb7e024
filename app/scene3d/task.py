"""The job ``scene``: one 3-D scene of a run as a file."""

from __future__ import annotations

from app.errors import ApiError
from app.evidence.service import EvidenceService
from app.jobs.context import TaskContext
from app.labels.pictures import Pictograms
from app.outputs.service import OutputService
from app.runs.source_run import run_of_job
from app.scene3d.data import load_scene3d
from app.scene3d.export import scene_html
from app.scene3d.prior import Prior, find_prior
from app.scene3d.service import context_of, first_view_state, marked_tracks, pictures_of
from app.scene3d.view_state import ViewState
from app.videos.frames import FrameService
from tsr_engine.errors import InputError


def make_scene(task: TaskContext) -> None:
    """Draw the scene of the output's options, and complete the output.

    Raises:
        InputError: the run was removed or has no results.
    """
    outputs, output, folder = OutputService.begin(task)
    evidence = EvidenceService(task.settings, task.database)
    frames = FrameService(task.settings, task.database)
    try:
        with task.database.read() as session:
            run = run_of_job(session, output.run_id)
        run_id, name = run.id, run.name or "Run"
        try:
            data = load_scene3d(evidence, run_id, marked_tracks(task.database, run_id))
        except ApiError as error:
            raise InputError(error.message) from None
        outputs.progress(task, output.id, 1, 3)
        pictograms = Pictograms(task.database)

        def prior(run: str) -> Prior | None:
            return find_prior(task.settings, task.database, run)

        page = scene_html(
            lambda scene: context_of(scene, data, evidence, prior, pictograms),
            pictures_of(data, frames.raw),
            _view_state(output.options, first_view_state(data)),
            f"{name} · tsr",
        )
        outputs.progress(task, output.id, 2, 3)
        path = folder / "scene.html"
        path.write_text(page, encoding="utf-8")
        summary = {"mode": output.options["mode"], "tracks": len(data.ids), "boxes": len(data.frame)}
        outputs.complete(task, output.id, path, summary)
    finally:
        frames.close()
        evidence.close()


def _view_state(options: dict[str, object], start: ViewState) -> ViewState:
    given = {name: value for name, value in options.items() if value is not None}
    return ViewState(**{**{name: getattr(start, name) for name in ViewState.__slots__}, **given})  # type: ignore[arg-type]
