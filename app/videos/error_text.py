"""Error texts about a video's file, for the person who added it."""

from __future__ import annotations

import re
from pathlib import Path

from app.storage.models import Video


def with_upload_name(video: Video, text: str) -> str:
    """Replace the path of an upload's copy in a text by the upload's name; the path tells people nothing.

    Texts name the copy by its whole path or by its file name, which is the video's SHA-256.
    """
    if not video.owned:
        return text
    copy = f"{re.escape(video.path)}|{re.escape(Path(video.path).name)}"
    return re.sub(copy, lambda _: video.name, text)
