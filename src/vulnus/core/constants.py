"""Physical constants that more than one stage uses, each with its source."""

from __future__ import annotations

STANDARD_GRAVITY = 9.80665
"""Standard acceleration of free fall [m/s²] (CGPM 1901)."""

BLOOD_DENSITY = 1060.0
"""Density of whole blood at 37 °C [kg/m³] (Kenner 1989, Basic Res Cardiol 84:111)."""

BLOOD_VISCOSITY = 3.5e-3
"""High-shear dynamic viscosity of blood [Pa s] (3.5 cP, Cho & Kensey 1991, Biorheology 28:241)."""
