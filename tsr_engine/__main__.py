"""`python -m tsr_engine` is the command `tsr`."""

from __future__ import annotations

from tsr_engine.cli.main import main

if __name__ == "__main__":
    main()
