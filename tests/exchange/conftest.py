"""Makes the small data sets importable."""

from __future__ import annotations

import pytest

pytest.register_assert_rewrite("tests.exchange.losses")  # it says what differs, as a test does
