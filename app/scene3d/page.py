"""Serves viser's page: the file of the installed package, with a separate content security policy."""

from __future__ import annotations

import base64
import gzip
import hashlib
import re
from dataclasses import dataclass
from functools import lru_cache
from importlib.util import find_spec
from pathlib import Path
from typing import Final

import numpy as np

from tsr_engine.errors import StorageError

HUSH: Final = (
    "addEventListener('unhandledrejection', (event) => { "
    "if (event.reason instanceof EvalError) event.preventDefault(); });"
)
"""Our script that silences an error: viser prepares a renderer for Gaussian splats with ``eval``, which the policy
forbids. Nothing here needs that renderer."""

BAR: Final = (
    "{ const given = matchMedia; "
    "window.matchMedia = (asked) => given.call(window, /max-width/.test(asked) ? 'not all' : asked); }"
)
"""Our script that turns off viser's layout for narrow frames: its panel always starts open and covers half of the
scene. In the other layout the panel can be a bar."""

AWAKE: Final = "document.hasFocus = () => true;"
"""Our script that lets viser connect again after the server was away: it tries only while its frame has the focus,
which the review page usually keeps."""

PLAIN: Final = """(() => {
  const given = HTMLCanvasElement.prototype.getContext;
  const probe = given.call(document.createElement('canvas'), 'webgl2');
  const debug = probe?.getExtension('WEBGL_debug_renderer_info');
  const name = debug ? String(probe.getParameter(debug.UNMASKED_RENDERER_WEBGL)) : '';
  probe?.getExtension('WEBGL_lose_context')?.loseContext();
  if (!/swiftshader|llvmpipe|softpipe|software|basic render/i.test(name)) return;
  HTMLCanvasElement.prototype.getContext = function (kind, asked) {
    if (kind !== 'webgl2') return given.call(this, kind, asked);
    return given.call(this, kind, {...asked, antialias: false, preserveDrawingBuffer: false});
  };
  const extension = WebGL2RenderingContext.prototype.getExtension;
  WebGL2RenderingContext.prototype.getExtension = function (asked) {
    return asked === 'WEBGL_debug_renderer_info' ? null : extension.call(this, asked);
  };
  const here = new URL(location.href);
  if (here.searchParams.has('fixedDpr')) return;
  const pixels = Math.max(1, innerWidth * innerHeight);
  here.searchParams.set('fixedDpr', String(Math.min(devicePixelRatio, Math.max(0.5, Math.sqrt(250000 / pixels)))));
  history.replaceState(history.state, '', here);
})();"""
"""Our script for machines without a graphics card: pictures are drawn without antialiasing (four samples per pixel),
are not copied and have at most a quarter of a million pixels, which saves a third of their processor time. viser
takes its resolution from the address. The script hides the renderer's name from viser, whose notice about software
rendering covers the scene; the review page shows that notice beside it. With a graphics card, or an unknown renderer,
viser's settings stay."""

_LOADER: Final = re.compile(r'<script data-p="([^"]*)" data-ss="(\d+)" data-cs="(\d+)">(.*?)</script>', re.DOTALL)
ALPHABET: Final = "".join(chr(c) for c in range(0x21, 0x7F) if chr(c) not in "\"&<>'`")


@dataclass(frozen=True, slots=True)
class ViserPage:
    """viser's page.

    Attributes:
        content: HTML.
        packed: the HTML, gzipped.
        policy: its Content-Security-Policy.
        etag: identifies this version.
    """

    content: bytes
    packed: bytes
    policy: str
    etag: str


@lru_cache(maxsize=1)
def viser_page() -> ViserPage:
    """Prepare the page of the installed viser.

    Raises:
        StorageError: the package is missing, or its page has an unknown structure.
    """
    found = find_spec("viser")
    places = [] if found is None or not found.submodule_search_locations else list(found.submodule_search_locations)
    path = Path(places[0]) / "client" / "build" / "index.html" if places else None
    if path is None or not path.is_file():
        raise StorageError(
            "viser's page is not installed. Install viser again: pip uninstall viser, then pip install 'tsr[scene3d]'."
        )
    text = path.read_text(encoding="utf-8")
    ours = (HUSH, BAR, AWAKE, PLAIN)
    scripts = (*(one.encode() for one in ours), *page_scripts(text))
    content = text.replace(
        "<head>", "\n    ".join(["<head>", *(f"<script>{one}</script>" for one in ours)]), 1
    ).encode()
    return ViserPage(
        content, gzip.compress(content, 6), policy(scripts), f'"{hashlib.sha256(content).hexdigest()[:24]}"'
    )


def policy(scripts: tuple[bytes, ...]) -> str:
    """Content security policy of viser's page: only its own inline scripts and wasm, connections only to this server.

    The page is one file. Its loader unpacks the program with a wasm decoder and adds it as an inline script; the policy
    allows both by their hashes. Workers and pictures are blobs. Styles are inline, because viser's components set them.
    """
    hashes = " ".join(f"'sha256-{base64.b64encode(hashlib.sha256(text).digest()).decode()}'" for text in scripts)
    return (
        f"default-src 'none'; script-src {hashes} 'wasm-unsafe-eval'; worker-src blob:; "
        "connect-src 'self' data: blob:; img-src 'self' data: blob:; style-src 'unsafe-inline'; font-src data:; "
        "base-uri 'none'; form-action 'none'; object-src 'none'; frame-ancestors 'self'"
    )


def page_scripts(page: str) -> tuple[bytes, ...]:
    """Return the loader, and the program that it unpacks.

    Raises:
        StorageError: the page has an unknown structure.
    """
    import zstandard

    found = _LOADER.search(page)
    if found is None or page.count("<script") != 1:
        raise StorageError(
            "viser's page has an unknown structure. Install the version that tsr needs: pip install 'tsr[scene3d]'."
        )
    packed, styles, code, loader = found.groups()
    whole = zstandard.ZstdDecompressor().decompress(from_base88(packed), max_output_size=int(styles) + int(code))
    return loader.encode(), whole[int(styles) : int(styles) + int(code)]


def from_base88(text: str) -> bytes:
    """Decode base 88: five characters are four bytes; the last k characters are k - 1 bytes."""
    values = np.zeros(128, np.uint64)
    values[[ord(c) for c in ALPHABET]] = np.arange(88, dtype=np.uint64)
    digits = values[np.frombuffer(text.encode("ascii"), np.uint8)]
    whole = len(digits) // 5 * 5
    numbers = digits[:whole].reshape(-1, 5) @ (np.uint64(88) ** np.arange(4, -1, -1, dtype=np.uint64))
    rest = digits[whole:].tolist()
    tail = b""
    if rest:
        number = 0
        for digit in rest:
            number = number * 88 + digit
        tail = (number % 256 ** (len(rest) - 1)).to_bytes(len(rest) - 1, "big")
    return numbers.astype(">u4").tobytes() + tail
