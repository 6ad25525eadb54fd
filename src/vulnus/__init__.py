"""vulnus: what a penetrating injury does to a limb, from the CT scan to the blood on the floor."""

from __future__ import annotations

import os

__version__ = "0.1.0"

# Waiting threads sleep instead of spinning: on a shared machine a spinning thread takes the time
# of the one it waits for (11.6 against 7 million particle-steps/s of the injury solver with both
# cores busy). OpenMP reads this once, when the first native module is loaded.
os.environ.setdefault("OMP_WAIT_POLICY", "passive")
