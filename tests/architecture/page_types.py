"""TypeScript types of the server's answers: ``python -m tests.architecture.page_types``.

openapi-typescript (see ``package.json``) translates the OpenAPI document. Only ``tsc`` reads the file, so the page
needs no build step.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import sysconfig
import tempfile
from pathlib import Path

from app.main import create_app
from app.settings import Settings

__all__ = ["FILE", "TOOL", "page_types", "shapes"]

ROOT = Path(__file__).resolve().parents[2]
FILE = Path("static", "js", "api", "schema.d.ts")
TOOL = ROOT / "node_modules" / "openapi-typescript" / "bin" / "cli.js"
HEAD = """// Written by `python -m tests.architecture.page_types` from the OpenAPI document of the server.
// Do not edit: change the model in app/, then run the command. static/js/types.js gives the types their short names.

"""


def shapes() -> dict[str, object]:
    """The OpenAPI document reduced to the bodies, without titles that repeat their names."""
    with tempfile.TemporaryDirectory() as home:
        settings = Settings(home=Path(home), roots=(Path(home),), sample=False, workers=0, token="of no server at all")
        document = create_app(settings).openapi()
    schemas = document["components"]["schemas"]
    for schema in schemas.values():
        for one in schema.get("properties", {}).values():
            one.pop("title", None)
        schema.pop("title", None)
    return {"openapi": document["openapi"], "info": document["info"], "paths": {}, "components": {"schemas": schemas}}


def page_types() -> str:
    """The file's text.

    Raises:
        subprocess.CalledProcessError: the translator failed; its output is on standard error.
    """
    node = Path(sysconfig.get_path("scripts"), "node")
    with tempfile.TemporaryDirectory() as folder:
        document, out = Path(folder, "openapi.json"), Path(folder, "schema.d.ts")
        document.write_text(json.dumps(shapes()), encoding="utf-8")
        subprocess.run(
            [str(node), str(TOOL), str(document), "--output", str(out), "--default-non-nullable=false"],
            check=True,
            stdout=sys.stderr,
        )
        text = out.read_text(encoding="utf-8")
    return HEAD + text[text.index("export") :]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=ROOT / FILE)
    parser.parse_args().out.write_text(page_types(), encoding="utf-8")


if __name__ == "__main__":
    main()
