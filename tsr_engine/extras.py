"""The extras of an installation: the extra of a missing package, and how to install it.

An installation without extras has what ``tsr track`` needs. Other packages are imported only when they are used.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from importlib.util import find_spec
from types import MappingProxyType
from typing import Final

from tsr_engine.errors import UsageError

EXTRAS: Final[Mapping[str, tuple[str, ...]]] = MappingProxyType(
    {
        "review": ("alembic", "fastapi", "pydantic_settings", "sqlalchemy", "starlette", "uvicorn"),
        "recordings": ("rerun", "rerun_bindings"),
        "scene3d": ("viser", "websockets", "zstandard"),
        "train": ("matplotlib", "sklearn"),
        "network": ("torch",),
        "postgres": ("psycopg",),
        "cluster": ("ray",),
        "s3": ("fsspec", "s3fs"),
    }
)
"""Import names of the packages that each extra installs."""
_PURPOSES: Final[Mapping[str, str]] = MappingProxyType(
    {
        "review": "The review tool needs",
        "recordings": "Recordings for Rerun need",
        "scene3d": "The 3-D views need",
        "train": "Training and plots need",
        "network": "The network's training needs",
        "postgres": "PostgreSQL needs",
        "cluster": "Work on a cluster needs",
        "s3": "Shared files need",
    }
)


class MissingExtra(UsageError):
    """A package of an extra is needed and not installed."""


def missing_extra(error: ImportError) -> MissingExtra | None:
    """The error that explains a missing package of an extra; None if the import failed for another reason."""
    name = (error.name or "").split(".")[0]
    if not isinstance(error, ModuleNotFoundError):
        return None
    for extra, packages in EXTRAS.items():
        if name in packages:
            return MissingExtra(f"{_PURPOSES[extra]} {name}, which is not installed: pip install 'tsr[{extra}]'.")
    return None


def require_extra(package: str) -> None:
    """Check that a package of an extra is installed, without importing it.

    Raises:
        MissingExtra: it is not installed.
    """
    if find_spec(package) is None:
        with explained():
            raise ModuleNotFoundError(name=package)


@contextmanager
def explained() -> Iterator[None]:
    """Explain a missing package of an extra in one sentence.

    Raises:
        MissingExtra: replaces the ``ModuleNotFoundError``.
    """
    try:
        yield
    except ModuleNotFoundError as error:
        known = missing_extra(error)
        if known is None:
            raise
        raise known from error
