"""The import graph of packages and page: ``python -m tests.architecture.import_graph --out docs/import-graph.md``.

A node is a folder or module directly below a package, or a folder of ``static/js``. Imports inside
functions and for type checkers count.
"""

from __future__ import annotations

import argparse
import re
from collections.abc import Mapping, Set
from functools import cache
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import grimp

__all__ = [
    "PAGE_SOURCES",
    "circle",
    "imported_by_page",
    "modules",
    "package_graph",
    "page",
    "page_modules",
    "transitive_reduction",
]

PACKAGES = ("tsr_engine", "app")
PAGE_SOURCES = Path(__file__).resolve().parents[2] / "static" / "js"
JS_IMPORT = re.compile(r"""(?:\bfrom|\bimport)\s*\(?\s*["'](\.[^"']+)["']""")
JS_TYPE = re.compile(r"""\bimport\(\s*["'][^"']+["']\s*\)\s*\.""")
PAGE = """# Import graph

`python -m tests.architecture.import_graph --out docs/import-graph.md` writes this page. A test holds that it is up to
date, and that neither folders nor modules import each other in a circle. An arrow leads from a folder or module to
one that it imports. Arrows that follow from others are left out: A imports C is not drawn if A imports B and B imports
C. `main.js` of the page imports every folder.

"""

Graph = Mapping[str, Set[str]]
"""Name -> names that it imports."""


@cache
def modules() -> Graph:
    """Every module of the packages, with the modules that it imports."""
    graph = grimp.build_graph(*PACKAGES, "sample_videos", cache_dir=None)
    return {module: graph.find_modules_directly_imported_by(module) for module in sorted(graph.modules)}


def package_graph() -> Graph:
    """Every node with the nodes that it imports; ``sample_videos`` is one node."""
    found: dict[str, set[str]] = {}
    for module, imported in modules().items():
        room = _node_of(module)
        found.setdefault(room, set()).update({_node_of(one) for one in imported} - {room, *PACKAGES})
    return {room: imported for room, imported in found.items() if room not in PACKAGES}


def imported_by_page(path: Path, text: str) -> Set[Path]:
    """Files that a JavaScript module imports, for types too."""
    return {(path.parent / one).resolve() for one in JS_IMPORT.findall(text)}


@cache
def page_modules() -> Graph:
    """Every module of ``static/js`` with its imports, as paths below that folder."""
    found = {}
    for path in sorted(PAGE_SOURCES.rglob("*.js")):
        code = JS_TYPE.sub("", path.read_text(encoding="utf-8"))
        found[path] = {one.relative_to(PAGE_SOURCES).as_posix() for one in imported_by_page(path, code)}
    return {path.relative_to(PAGE_SOURCES).as_posix(): imported for path, imported in found.items()}


def _page_rooms() -> Graph:
    found: dict[str, set[str]] = {}
    for module, imported in page_modules().items():
        room, *inner = module.split("/")
        if inner:
            found.setdefault(room, set()).update({one.split("/")[0] for one in imported} - {room})
    return found


def circle(graph: Graph) -> list[str]:
    """Names on an import cycle; empty if there is none."""
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        found: list[str] = error.args[1]
        return found[::-1]
    return []


def transitive_reduction(graph: Graph) -> Graph:
    """The transitive reduction of a graph without cycles."""
    order = [*TopologicalSorter(graph).static_order()]  # what is imported comes first
    reached: dict[str, set[str]] = {}
    for name in order:
        reached[name] = set(graph.get(name, ())).union(*(reached[one] for one in graph.get(name, ())))
    return {name: {one for one in graph[name] if not any(one in reached[two] for two in graph[name])} for name in graph}


def page() -> str:
    """The page in Markdown, with a Mermaid diagram for each package and one for the review page."""
    parts = [PAGE]
    for package in PACKAGES:
        inner = {
            room: {one for one in imported if one.startswith(f"{package}.")}
            for room, imported in package_graph().items()
            if room.startswith(f"{package}.")
        }
        parts.append(_picture(package, inner))
    return "".join([*parts, _picture("static/js", _page_rooms())]).rstrip() + "\n"


def _picture(title: str, graph: Graph) -> str:
    arrows = sorted((room, one) for room, imported in transitive_reduction(graph).items() for one in imported)
    lines = [f"    {_node(room)} --> {_node(one)}" for room, one in arrows]
    alone = sorted(graph.keys() - {name for arrow in arrows for name in arrow})
    lines += [f"    {_node(room)}" for room in alone]
    return f"## `{title}`\n\n```mermaid\nflowchart TD\n" + "\n".join(lines) + "\n```\n\n"


def _node_of(module: str) -> str:
    package, *inner = module.split(".")
    return ".".join([package, *inner[:1]]) if package in PACKAGES else package


def _node(room: str) -> str:
    name = room.split(".")[-1]
    return f"{name}_[{name}]"  # a prefix, since `end` and others are keywords of Mermaid


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m tests.architecture.import_graph", description=__doc__)
    parser.add_argument("--out", type=Path, required=True, help="the Markdown file")
    chosen = parser.parse_args()
    chosen.out.write_text(page(), encoding="utf-8")


if __name__ == "__main__":
    main()
