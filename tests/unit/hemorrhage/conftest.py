"""Wounded limbs that several tests share."""

from __future__ import annotations

import pytest
from reference.sph_limb import wounded_limb


@pytest.fixture(scope="session")
def open_wound():
    """A limb with its tract open at both ends."""
    return wounded_limb()


@pytest.fixture(scope="session")
def closed_wound():
    """A limb with its skin closed over the tract's ends."""
    return wounded_limb(entry_open=False, exit_open=False)
