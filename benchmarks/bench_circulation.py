"""Time of the arterial tree: the whole tree anew, the port of an injury, one bleeding heartbeat.

What `solve_ms` includes: everything that depends on a parameter of the tree, from the segments to
the pressures and admittances of all of them at all harmonics. Read once in the process and not
included: the tables' files and the table of the Womersley function.

The peer "scipy-matrix" solves the same network as one sparse linear system of its nodes for each
harmonic, with Bessel functions from SciPy, and must agree.
"""

from __future__ import annotations

import argparse
import dataclasses
import json
import statistics
import sys
import time
from collections.abc import Callable

import numpy as np

from vulnus.circulation import ArterialTree, CirculationParameters, build_tree
from vulnus.circulation.aortic_signal import spectrum_of
from vulnus.circulation.terminals import terminal_admittance
from vulnus.circulation.womersley import inertia_factor, wave_speed, womersley_number

PEERS = ("scipy-matrix",)
AGREEMENT = 1e-7  # of node pressures; both solve the same equations, the peer in one system


def matrix_pressures(tree: ArterialTree) -> np.ndarray:
    """Pressure at the outlet of every segment, (n, H + 1), by one linear system per harmonic.

    Unknowns are the outlets; a segment adds its admittances coth(γL)/Zc to both of its ends and
    -1/(Zc sinh γL) between them; the mean uses 1/R. A reference twin: no recursion, no levels.
    """
    from scipy.sparse import csc_matrix
    from scipy.sparse.linalg import splu

    table, parameters = tree.table, tree.parameters
    n, omega = len(table.ids), tree.angular_frequency
    speed = wave_speed(table, density=parameters.density, poisson_ratio=parameters.poisson_ratio)
    terminal = terminal_admittance(table, omega, parameters)
    root = spectrum_of(tree.signal.pressure, parameters.harmonics)
    parents = table.parent_row
    inner = np.flatnonzero(parents >= 0)
    rows = np.concatenate((np.arange(n), parents[inner], parents[inner], inner))
    columns = np.concatenate((np.arange(n), parents[inner], inner, parents[inner]))
    pressure = np.empty((n, len(omega) + 1), dtype=complex)
    for k in range(len(omega) + 1):
        if k == 0:
            own = between = 1.0 / tree.lines.resistance + 0j
            behind = 1.0 / table.terminal_resistance + 0j
            drawn = behind * parameters.venous_pressure
        else:
            own, between = _line_admittances(tree, speed, float(omega[k - 1]))
            behind, drawn = terminal[:, k - 1], np.zeros(n)
        values = np.concatenate((own + behind, own[inner], -between[inner], -between[inner]))
        right = drawn.astype(complex)
        right[0] += between[0] * root[k]
        pressure[:, k] = splu(csc_matrix((values, (rows, columns)), shape=(n, n))).solve(right)
    return pressure


def _line_admittances(
    tree: ArterialTree, speed: np.ndarray, omega: float
) -> tuple[np.ndarray, np.ndarray]:
    """coth(γL)/Zc and 1/(Zc sinh γL) of every segment at one frequency, from Bessel functions."""
    table, parameters = tree.table, tree.parameters
    alpha = womersley_number(
        table.radius,
        np.array(omega),
        density=parameters.density,
        viscosity=parameters.viscosity,
    )
    root = np.sqrt(inertia_factor(alpha))
    lag = np.exp(0.5j * parameters.wall_phase * (1.0 - np.exp(-2.0 * omega)))
    gamma = 1j * omega / (lag * speed * root)
    impedance = parameters.density * speed * lag / (np.pi * table.radius**2 * root)
    wave = gamma * table.length
    return 1.0 / (impedance * np.tanh(wave)), 1.0 / (impedance * np.sinh(wave))


def seconds_of(action: Callable[[], object], repeats: int) -> list[float]:
    """Wall time [s] of each of `repeats` calls after one that warms up."""
    action()
    taken = []
    for _ in range(repeats):
        begun = time.perf_counter()
        action()
        taken.append(time.perf_counter() - begun)
    return taken


def measure(harmonics: int, repeats: int) -> dict[str, float]:
    """Times of the tree with `harmonics`; best of the repeats, the median beside it."""
    parameters = CirculationParameters(harmonics=harmonics)

    def solve() -> ArterialTree:
        changed = dataclasses.replace(parameters, viscosity=parameters.viscosity * 1.0001)
        tree = build_tree(changed)
        tree.solve()
        return tree

    tree = solve()
    segment, position = tree.locate("anterior_tibial", 0.5)
    port = tree.injury_port(segment, position)
    solving = seconds_of(solve, repeats)
    opening = seconds_of(lambda: tree.injury_port(segment, position), repeats)
    bleeding = seconds_of(lambda: port.bleed(2000.0), repeats)
    cells = len(tree.table.ids) * harmonics
    return {
        "segments": len(tree.table.ids),
        "harmonics": harmonics,
        "particles": cells,
        "rate_per_s": cells / min(solving),
        "bytes_per_particle": _bytes_kept(tree) / cells,
        "solve_ms": 1e3 * min(solving),
        "solve_median_ms": 1e3 * statistics.median(solving),
        "port_us": 1e6 * min(opening),
        "beat_us": 1e6 * min(bleeding),
    }


def _bytes_kept(tree: ArterialTree) -> int:
    """Bytes of the arrays that a solved tree keeps."""
    state, lines = tree.solve(), tree.lines
    kept = [getattr(state, field.name) for field in dataclasses.fields(state)]
    kept += [getattr(lines, field.name) for field in dataclasses.fields(lines)]
    kept += [getattr(state.steady, field.name) for field in dataclasses.fields(state.steady)]
    return sum(array.nbytes for array in kept if isinstance(array, np.ndarray))


def compare(name: str, result: dict[str, float], harmonics: int) -> dict[str, float]:
    """Rate of a peer on the same tree, and how many times as fast this solver is."""
    if name not in PEERS:
        raise SystemExit(f'peer "{name}" is unknown; known: {", ".join(PEERS)}')
    tree = build_tree(CirculationParameters(harmonics=harmonics))
    difference = np.abs(matrix_pressures(tree)[:, 1:] - tree.solve().pressure_out)
    if np.max(difference) > AGREEMENT * np.max(np.abs(tree.solve().pressure_out)):
        raise SystemExit(f"peer {name} disagrees by {np.max(difference):.3g} Pa")
    peer = result["particles"] / min(seconds_of(lambda: matrix_pressures(tree), 5))
    return {"peer_rate_per_s": peer, "ratio": result["rate_per_s"] / peer}


def main(arguments: list[str]) -> None:
    """Measure, print a table and, where asked, a last line of JSON."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--json", action="store_true", help="end with one JSON object")
    parser.add_argument("--peer", metavar="NAME", help=f"compare with {', '.join(PEERS)}")
    parser.add_argument("--harmonics", type=int, default=128)
    parser.add_argument("--repeats", type=int, default=50)
    options = parser.parse_args(arguments)
    if options.peer is not None and options.peer not in PEERS:
        parser.error(f'peer "{options.peer}" is unknown; known: {", ".join(PEERS)}')
    result = measure(options.harmonics, options.repeats)
    if options.peer is not None:
        result |= compare(options.peer, result, options.harmonics)
    for name, value in result.items():
        print(f"{name:>20}  {value:,.4g}")
    if options.json:
        print(json.dumps(result))


if __name__ == "__main__":
    main(sys.argv[1:])
