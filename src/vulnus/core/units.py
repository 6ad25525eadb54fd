"""Factors from the units of the borders (files, scenario keys, plots) to SI.

`value_si = value_mm * MILLIMETRE`; `value_mm = value_si / MILLIMETRE`.
"""

from __future__ import annotations

MILLIMETRE = 1e-3
SQUARE_MILLIMETRE = 1e-6
MILLILITRE = 1e-6
MILLILITRE_PER_MINUTE = 1e-6 / 60.0
MILLISECOND = 1e-3
MICROSECOND = 1e-6
GRAM = 1e-3
DEGREE = 0.017453292519943295
KILOPASCAL = 1e3
MEGAPASCAL = 1e6
GIGAPASCAL = 1e9
MILLIMETRE_OF_MERCURY = 133.322387415
"""1 mmHg [Pa], the conventional millimetre of mercury (NIST SP 811)."""
