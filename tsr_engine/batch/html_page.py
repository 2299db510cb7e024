"""Makes the plain HTML page of reports on batches and checks."""

from __future__ import annotations

import html
from typing import Final

_STYLE: Final = """
body { font: 15px/1.45 system-ui, sans-serif; margin: 2rem auto; max-width: 70rem; padding: 0 1rem }
:root { color-scheme: light dark }
table { border-collapse: collapse; margin: .5rem 0 1.5rem; width: 100% }
th, td { text-align: left; padding: .25rem .75rem .25rem 0; border-bottom: 1px solid #8884; vertical-align: top }
td.n, th.n { text-align: right; font-variant-numeric: tabular-nums }
"""


def html_page(name: str, heading: str, body: str, style: str = "") -> str:
    """The HTML of a page for the command ``name``; ``body`` is HTML: the caller escapes text from outside.

    The bytes of a file's name that are not UTF-8 are escaped.
    """
    page = (
        f'<!doctype html>\n<html lang="en"><meta charset="utf-8"><title>{html.escape(name)}</title>'
        f"<style>{_STYLE}{style}</style><h1>{html.escape(heading)}</h1>{body}</html>\n"
    )
    return page.encode("utf-8", "backslashreplace").decode()
