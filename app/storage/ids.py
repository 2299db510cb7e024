"""The form of the tables' ids."""

from __future__ import annotations

import re

RUN_ID = re.compile("[0-9a-f]{32}")
"""A run's id, which is also its name in the data folder."""
