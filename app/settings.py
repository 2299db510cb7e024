"""All settings of the server: each field is a ``TSR_*`` variable, and the common ones are options of ``tsr review``."""

from __future__ import annotations

import getpass
import os
import re
from ipaddress import ip_network
from pathlib import Path
from typing import Annotated

from pydantic import Field, TypeAdapter, ValidationError, field_validator
from pydantic_settings import BaseSettings, NoDecode, SettingsConfigDict
from sqlalchemy import URL

from tsr_engine.errors import UsageError
from tsr_engine.io.cores import usable_cores
from tsr_engine.io.video_limits import MAX_PIXELS, VideoLimits

DATABASE_FILE = "tsr.sqlite"
"""SQLite database in a data folder."""
MAKE_HOME = Path("out", "review")
"""Data folder of ``make review``, from the folder of its Makefile."""


_HOST_NAME = re.compile(r"[A-Za-z0-9._-]+|\[[0-9A-Fa-f:.]+\]")
_MAX_CORES = 16
"""Default limit of cores: each thread takes address space (``worker_memory_mb``), and tracking uses one core anyway."""


def _default_home() -> Path:
    base = os.environ.get("XDG_DATA_HOME") or "~/.local/share"
    return Path(base).expanduser() / "tsr"


def _default_author() -> str:
    try:
        return getpass.getuser()
    except (KeyError, OSError):  # no entry in the user database, as in a bare container
        return "someone"


class Settings(BaseSettings):
    """Settings of the server. Values come from the caller, else from ``TSR_<NAME>``, else the default."""

    model_config = SettingsConfigDict(env_prefix="TSR_", extra="ignore", frozen=True)

    home: Path = Field(default_factory=_default_home, description="data folder: database, evidence, uploads")
    database_url: str | None = Field(None, description="SQLAlchemy address of a database; unset: SQLite in home")
    files: str | None = Field(
        None,
        pattern=r"^(s3://[^/]+|file:///|/).*$",
        description="files that several servers of one database share: s3://BUCKET/PREFIX or a folder",
    )
    files_cache_mb: int = Field(200_000, ge=0, description="shared files that also lie in home, MiB")
    host: str = Field("127.0.0.1", description="address to listen on; other than loopback needs a token")
    port: int = Field(8765, ge=0, le=65535, description="port to listen on; 0: any free one")
    token: str | None = Field(None, min_length=16, description="secret for programs; unset: made once and kept in home")
    allowed_hosts: Annotated[tuple[str, ...], NoDecode] = Field(
        (), description="further names that the Host header may carry, separated by commas"
    )
    trusted_proxies: Annotated[tuple[str, ...], NoDecode] = Field(
        (), description="addresses and networks of proxies that may say who is asking, separated by commas"
    )
    proxy_header: str = Field(
        "X-Forwarded-User",
        pattern=r"^[A-Za-z0-9-]{1,64}$",
        description="header in which a trusted proxy names the person",
    )
    roots: Annotated[tuple[Path, ...], NoDecode] = Field(
        default_factory=lambda: (Path.cwd(),),
        description="folders that videos may be added from, separated by colons; or a JSON array",
    )
    models: Path | None = Field(None, description="folder of model files; unset: those that ship with the engine")
    workers: int = Field(
        1, ge=0, le=64, description="engine processes at once, and two each for imports and short work; 0: none here"
    )
    cores: int | None = Field(
        None, ge=1, le=64, description="cores that one run uses; unset: up to 16, shared among the engine processes"
    )
    executor: str = Field(
        "local",
        pattern=r"^(local|ray|ray://[A-Za-z0-9.-]{1,255}:[0-9]{1,5})$",
        description="where runs are computed: local, ray (the cluster of this machine) or ray://HOST:PORT",
    )
    worker_memory_mb: int = Field(6144, ge=512, description="address space of one engine process, MiB")
    frame_cache_mb: int = Field(64, ge=1, description="memory for encoded pictures, MiB")
    upload_max_mb: int = Field(16384, ge=1, description="largest upload, MiB")
    import_max_tracks: int = Field(20_000, ge=1, description="most tracks of one import of annotations")
    import_max_boxes: int = Field(1_000_000, ge=1, description="most boxes of one import of annotations")
    import_memory_mb: int = Field(3072, ge=256, description="memory of a process that imports annotations, MiB")
    import_seconds: int = Field(300, ge=5, description="computing of a process that imports annotations, seconds")
    body_max_kb: int = Field(4096, ge=16, description="largest request body besides uploads, KiB")
    max_pixels: int = Field(MAX_PIXELS, ge=10_000, description="largest picture of a video, px")
    author: str = Field(default_factory=_default_author, max_length=80, description="name that edits carry")
    sample: bool = Field(True, description="put the bundled sample drives into the library")

    @field_validator("home", mode="after")
    @classmethod
    def _absolute(cls, value: Path) -> Path:
        return value.expanduser().absolute()

    @field_validator("roots", mode="before")
    @classmethod
    def _split_roots(cls, value: object) -> object:
        return _parts(value, os.pathsep) if isinstance(value, str) else value

    @field_validator("roots", mode="after")
    @classmethod
    def _real_roots(cls, value: tuple[Path, ...]) -> tuple[Path, ...]:
        return tuple(dict.fromkeys(Path(os.path.realpath(path.expanduser())) for path in value))

    @field_validator("allowed_hosts", "trusted_proxies", mode="before")
    @classmethod
    def _split_commas(cls, value: object) -> object:
        if not isinstance(value, str):
            return value
        return tuple(part.strip() for part in _parts(value, ",") if part.strip())

    @field_validator("allowed_hosts", mode="after")
    @classmethod
    def _host_names(cls, value: tuple[str, ...]) -> tuple[str, ...]:
        for text in value:
            if not _HOST_NAME.fullmatch(text):
                raise ValueError(f"{text!r} is not a name of a host such as tsr.example, without https:// and port")
        return value

    @field_validator("trusted_proxies", mode="after")
    @classmethod
    def _networks(cls, value: tuple[str, ...]) -> tuple[str, ...]:
        for text in value:
            try:
                ip_network(text)
            except ValueError:
                raise ValueError(f"{text!r} is not an address or network such as 10.0.0.7 or 10.0.0.0/24") from None
        return value

    @property
    def run_cores(self) -> int:
        """Cores that one run uses."""
        return self.cores or max(1, min(_MAX_CORES, usable_cores()) // max(1, self.workers))

    @property
    def loopback(self) -> bool:
        """Whether only this machine can reach the address."""
        return self.host in ("127.0.0.1", "localhost", "::1")

    @property
    def everywhere(self) -> bool:
        """Whether the server listens on all addresses of this machine."""
        return self.host in ("0.0.0.0", "::")  # noqa: S104 - compared, not bound

    @property
    def hosts(self) -> tuple[str, ...]:
        """Allowed names of the Host header besides loopback's, as a client sends them."""
        host = f"[{self.host}]" if ":" in self.host else self.host
        return self.allowed_hosts if self.everywhere else (*self.allowed_hosts, host)

    @property
    def video_limits(self) -> VideoLimits:
        """Limits of every video of the data folder."""
        return VideoLimits(max_pixels=self.max_pixels)

    @property
    def database(self) -> str | URL:
        """SQLAlchemy address of the database; an object for SQLite, because a folder's name may hold ``?`` or ``%``."""
        return self.database_url or URL.create("sqlite", database=str(self.home / DATABASE_FILE))


def _parts(text: str, separator: str) -> tuple[str, ...]:
    """Split a variable that holds several values: a JSON array, or text with separators."""
    if text == "[]" or text.startswith('["'):
        return tuple(TypeAdapter(list[str]).validate_json(text))
    return tuple(part for part in text.split(separator) if part)


def load_settings(**values: object) -> Settings:
    """Read the settings from arguments, environment and defaults; arguments that are None count as unset.

    Raises:
        UsageError: a value is not allowed; the sentence names its setting.
    """
    try:
        settings = Settings(**{name: value for name, value in values.items() if value is not None})  # type: ignore[arg-type]
    except ValidationError as error:
        first = error.errors()[0]
        name = "_".join(str(part) for part in first["loc"])
        wrong = "is wrong" if name == "token" else f"cannot be {first['input']!r}"  # a log must not hold the secret
        reason = first["msg"].removeprefix("Value error, ")
        raise UsageError(f"The setting {name} (TSR_{name.upper()}) {wrong}: {reason}.") from None
    if settings.files is not None and not (settings.database_url or "").startswith("postgresql"):
        raise UsageError(
            "Shared files (TSR_FILES) are for servers that share a PostgreSQL. Set TSR_DATABASE_URL too, or leave "
            "TSR_FILES out."
        )
    if not settings.loopback and settings.token is None:
        raise UsageError(
            f"The server would listen on {settings.host}, where others can reach it. Set TSR_TOKEN to a secret of at "
            "least 16 characters first, or use 127.0.0.1."
        )
    return settings


def no_home(home: Path) -> str:
    """Say that there is no data folder; names that of ``make review`` if one lies in the current directory.

    In that case the sentence does not suggest ``tsr review``, which would make a second, empty library.
    """
    text = f"There is no data folder at {home}."
    if (MAKE_HOME / DATABASE_FILE).is_file():
        return f"{text} There is one of 'make review' here: name it with --home {MAKE_HOME}."
    return f"{text} Name one with --home ('make review' keeps its own in {MAKE_HOME}), or start 'tsr review' once."
