"""The minimum role of every route: one table, by the name of the route's operation.

A route without a row needs an administrator; ``tests/app/people/test_roles.py`` fails for it. A library without people
has one user, who may do everything.
"""

from __future__ import annotations

from typing import Final

from app.people.roles import Role

_VIEWER: Final = frozenset({
    "get_session", "sign_out", "list_people", "get_activity", "list_assignments", "list_parameters", "list_labels",
    "get_pictogram", "list_label_sets", "get_label_set", "get_label_usage", "list_label_versions", "get_label_file",
    "list_videos", "get_video", "get_frame_table", "get_thumbnail", "get_frame", "get_frame_crop", "find_videos",
    "search", "get_search_crop", "get_run_queue", "list_training_sources", "list_runs", "get_run", "follow_events",
    "get_tracks", "get_lanes", "get_overlays", "get_flips", "get_track", "get_crop", "explain_verdict",
    "get_annotation", "list_edits", "get_track_history", "get_earlier_corrections", "find_follow", "get_follow",
    "list_ground_truths", "get_truth_boxes", "compare", "list_outputs", "get_output", "download_output",
    "list_formats", "list_models", "get_models", "get_scene3d", "move_scene3d",
    # not in the OpenAPI document: former addresses, the viewers' pages, files and sockets
    "list_artefacts", "list_truths",  # former names
    "get_page", "get_file", "get_state", "get_recording", "get_socket",
})  # fmt: skip
_ANNOTATOR: Final = frozenset({
    "edit", "take_over", "act_on_tracks", "undo_tracks", "tag_videos", "adopt_edits", "expect_follow", "start_follow",
    "drop_follow", "start_run_by_hand", "start_whatif", "record_run", "bundle_run", "export_scene", "cancel_output",
    "change_assignment", "get_second_opinion", "answer_second_opinion",
})  # fmt: skip
_REVIEWER: Final = frozenset({
    "get_overview", "list_second_opinions", "give_second_opinions", "create_assignments", "remove_assignment",
    "browse", "add_video", "upload_video", "start_run", "rename_run", "cancel_run", "resume_run", "remove_whatifs",
    "import_file", "get_import", "cancel_import", "move_run", "import_bundle", "put_truth", "start_export",
    "remove_output", "bring_label_file", "change_label_set", "use_label_set_in_video",
})  # fmt: skip
_ADMIN: Final = frozenset({
    "create_link", "use_label_set", "remove_video", "remove_run", "remove_truth", "train_models", "roll_back_models",
    "remove_models", "promote_models", "cancel_models", "resume_models",
})  # fmt: skip

MIN_ROLES: Final[dict[str, Role]] = {
    **dict.fromkeys(_VIEWER, "viewer"),
    **dict.fromkeys(_ANNOTATOR, "annotator"),
    **dict.fromkeys(_REVIEWER, "reviewer"),
    **dict.fromkeys(_ADMIN, "admin"),
}
"""Name of an operation -> the lowest role that may carry it out. ``sign_in`` is for everybody."""


def min_role_of(operation: str) -> Role:
    """Return the lowest role that may carry out an operation."""
    return MIN_ROLES.get(operation, "admin")
