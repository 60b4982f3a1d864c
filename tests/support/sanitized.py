"""Whether the program under test has the address sanitizer, which takes memory and time of its own."""

import os
from pathlib import Path

import pytest


def is_sanitized():
    path = os.environ.get("GENTBEAM", "")
    return os.path.isfile(path) and b"__asan_init" in Path(path).read_bytes()


not_sanitized = pytest.mark.skipif(is_sanitized(), reason="would meet the sanitizer instead")
