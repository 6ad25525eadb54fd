"""vulnus: what a penetrating injury does to a limb, from the CT scan to the blood on the floor."""

from __future__ import annotations

__version__ = "0.1.0"
