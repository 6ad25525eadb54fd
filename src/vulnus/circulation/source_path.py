"""What the heart's side of the tree looks like from a place further out.

At every place the part of the tree towards the heart allows exactly the pressures and flows with
a P + b Q = c, per harmonic: (1, 0, P_aorta) at a root with given pressure, (0, 1, Q_aorta) at one
with given flow. A line and a junction turn one such equation into the next; neither needs a
division, so an ideal source is no special case. Thevenin: P_open = c/a, Z = b/a.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vulnus.core.errors import CirculationError

from .arrays import ComplexArray


@dataclass(frozen=True, slots=True, eq=False)
class SourceEquation:
    """a P + b Q = c for the harmonics 0..H, (H + 1,) each; Q flows away from the heart."""

    a: ComplexArray
    b: ComplexArray
    c: ComplexArray

    def thevenin(self, place: str) -> tuple[ComplexArray, ComplexArray]:
        """Open pressure P_open [Pa] and impedance Z [Pa s/m³] of P = P_open - Z Q."""
        if np.any(self.a == 0.0):
            raise CirculationError(
                f"injury of {place}",
                "cuts off the whole tree from a source of given flow",
                'Use source = "pressure" or a place further from the heart',
            )
        return self.c / self.a, self.b / self.a


def through_line(
    equation: SourceEquation,
    *,
    propagation: ComplexArray,
    impedance: ComplexArray,
    resistance: float,
    length: float,
) -> SourceEquation:
    """The equation behind `length` [m] of a line; γ, Zc for harmonics 1..H, resistance for 0.

    P1 = A P2 + B Q2 and Q1 = C P2 + D Q2 with all of A..D divided by e^(γL).
    """
    once = np.exp(-propagation * length)
    twice = once * once
    cosine, sine = 0.5 * (1.0 + twice), 0.5 * (1.0 - twice)
    one = np.ones(1)
    A = np.concatenate((one, cosine))
    B = np.concatenate((one * resistance, impedance * sine))
    C = np.concatenate((0.0 * one, sine / impedance))
    return SourceEquation(
        a=equation.a * A + equation.b * C,
        b=equation.a * B + equation.b * A,
        c=equation.c * np.concatenate((one, once)),
    )


def through_junction(
    equation: SourceEquation, admittance: ComplexArray, source: float
) -> SourceEquation:
    """The equation behind a branch that takes Y P + J, with J [m³/s] of the mean only."""
    c = equation.c.copy()
    c[0] -= equation.b[0] * source
    return SourceEquation(a=equation.a + equation.b * admittance, b=equation.b, c=c)
