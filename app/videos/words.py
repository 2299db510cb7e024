"""Sentences about a video's file, for the person who added it."""

from __future__ import annotations

from app.storage.models import Video

__all__ = ["in_words"]


def in_words(video: Video, sentence: str) -> str:
    """The sentence with an upload called by its name: where its copy lies, and under which, tells a person nothing."""
    return sentence.replace(video.path, video.name) if video.owned else sentence
