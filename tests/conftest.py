"""What all tests share: in continuous integration, properties are tried on the same examples every time."""

from __future__ import annotations

import os

from hypothesis import settings

settings.register_profile("integration", derandomize=True, deadline=None)
if os.environ.get("CI"):
    settings.load_profile("integration")
