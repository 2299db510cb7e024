"""`python -m tsr_engine`: the engine's commands alone; the command `tsr` also has those of the review tool."""

from __future__ import annotations

from tsr_engine.cli.main import main

if __name__ == "__main__":
    main()
