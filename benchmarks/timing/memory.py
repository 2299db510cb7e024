"""Measures the memory of this process alone; the peak of ``getrusage`` would include that of its parent."""

from __future__ import annotations

from pathlib import Path

__all__ = ["memory"]


def memory() -> dict[str, float]:
    """Resident memory of this process now and at its peak, MB (10^6 bytes)."""
    lines = Path("/proc/self/status").read_text(encoding="ascii").splitlines()
    values = {line.split(":")[0]: line.split()[1] for line in lines if line.startswith(("VmRSS", "VmHWM"))}
    return {"rss_mb": int(values["VmRSS"]) * 1024 / 1e6, "peak_mb": int(values["VmHWM"]) * 1024 / 1e6}
