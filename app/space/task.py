"""The job ``scene``: one 3-D scene of a run as a file."""

from __future__ import annotations

from app.artefacts.service import ArtefactService
from app.edits.service import EditService
from app.errors import ApiError
from app.evidence.service import EvidenceService
from app.jobs.context import TaskContext
from app.labels.pictures import Pictograms
from app.runs.of_job import run_of_job
from app.space.data import load_space
from app.space.prior import Prior, find_prior
from app.space.service import first_wish, marked_tracks, pictures_of, stage_of
from app.space.wish import Wish
from app.videos.frames import FrameService
from tsr_engine.errors import InputError

__all__ = ["make_scene"]


def make_scene(task: TaskContext) -> None:
    """Draw the scene that the artefact's options describe, and complete the artefact.

    Raises:
        InputError: the run is gone or has stored nothing.
    """
    from app.space.export import scene_html

    artefacts = ArtefactService.of_task(task)
    artefact, folder = artefacts.begin(task)
    evidence = EvidenceService(task.settings, task.database)
    frames = FrameService(task.settings, task.database)
    try:
        with task.database.read() as session:
            run = run_of_job(session, artefact.run_id)
        run_id, name = run.id, run.name or "Run"
        edits = EditService(task.database, task.events, evidence, task.settings)
        try:
            data = load_space(evidence, run_id, marked_tracks(edits, run_id))
        except ApiError as error:
            raise InputError(error.message) from None
        artefacts.progress(task, artefact.id, 1, 3)
        pictograms = Pictograms(task.database)

        def prior(run: str) -> Prior | None:
            return find_prior(task.settings, task.database, run)

        page = scene_html(
            lambda scene: stage_of(scene, data, evidence, prior, pictograms),
            pictures_of(data, frames.raw),
            _wish(artefact.options, first_wish(data)),
            f"{name} · tsr",
        )
        artefacts.progress(task, artefact.id, 2, 3)
        path = folder / "scene.html"
        path.write_text(page, encoding="utf-8")
        summary = {"mode": artefact.options["mode"], "tracks": len(data.ids), "boxes": len(data.frame)}
        artefacts.complete(task, artefact.id, path, summary)
    finally:
        frames.close()
        evidence.close()


def _wish(options: dict[str, object], start: Wish) -> Wish:
    given = {name: value for name, value in options.items() if value is not None}
    return Wish(**{**{name: getattr(start, name) for name in Wish.__slots__}, **given})  # type: ignore[arg-type]
