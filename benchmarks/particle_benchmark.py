"""The face that the particle solvers' benchmarks share: options, table, scaling, peer and JSON."""

from __future__ import annotations

import argparse
import json
import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

BUSY = 1.5
"""Load average from which a measurement is not trusted; chosen: more than one other program."""


@dataclass(frozen=True, kw_only=True)
class ParticleBenchmark:
    """One solver's benchmark.

    `measure(count, threads, repeats)` gives `particles`, `rate_per_s`, `step_s`,
    `bytes_per_particle` and what `detail` shows; `peers` maps a name to the particle-steps a second
    of the same equations in other code, of `(count, threads)`; `roofline(case, threads)` gives
    lines on how far from the machine's limits a measured case is.
    """

    description: str
    particles: tuple[float, ...]
    measure: Callable[[int, int, int], dict[str, Any]]
    detail: Callable[[Mapping[str, Any]], str]
    peers: Mapping[str, Callable[[int, int], float]]
    about_peers: str
    roofline: Callable[[Mapping[str, Any], int], list[str]] | None = None

    def arguments(self) -> argparse.Namespace:
        """The command line's options, checked."""
        parser = argparse.ArgumentParser(
            description=self.description, formatter_class=argparse.RawDescriptionHelpFormatter
        )
        add = parser.add_argument
        add("--particles", type=float, nargs="+", default=[*self.particles], metavar="N")
        add("--threads", type=int, default=0, help="0: all processors (default)")
        add("--repeats", type=int, default=5, help="the fastest of so many counts")
        add("--json", action="store_true", help="end with one JSON object")
        known = ", ".join(self.peers)
        about = f"compare with a peer in the same run: {known} ({self.about_peers})"
        add("--peer", metavar="NAME", help=about)
        if self.roofline is not None:
            add("--roofline", action="store_true", help="how far from this machine's limits")
        parsed = parser.parse_args()
        if parsed.peer is not None and parsed.peer not in self.peers:
            parser.error(f"unknown peer {parsed.peer!r}; known peers: {known}")
        if min(parsed.particles) < 1000:
            parser.error("--particles must be at least 1000")
        return parsed

    def run(self) -> None:
        """Measure each size, print a line for it, and the JSON object where it is asked for."""
        args = self.arguments()
        if os.getloadavg()[0] > BUSY:
            print(
                f"busy machine (load {os.getloadavg()[0]:.1f}): rates come out too low, ratios odd"
            )
        cases = []
        for count in args.particles:
            case = self.measure(int(count), args.threads, args.repeats)
            cases.append(case)
            print(
                f"{case['particles']:>9,} particles"
                f" {case['rate_per_s'] / 1e6:6.2f} M particle-steps/s"
                f" {1e3 * case['step_s']:8.2f} ms/step"
                f" {case['bytes_per_particle']:.0f} bytes/particle {self.detail(case)}"
            )
        for small, large in pairwise(cases):
            more, longer = (large[key] / small[key] for key in ("particles", "step_s"))
            print(f"{more:.1f} x the particles: {longer:.2f} x the time")
        rates = [case["rate_per_s"] for case in cases]
        if len(rates) > 1:
            print(f"largest over smallest rate: {max(rates) / min(rates):.2f}")
        if self.roofline is not None and args.roofline:
            print(*self.roofline(cases[-1], args.threads), sep="\n")
        result: dict[str, object] = {**cases[-1], "cases": cases}
        if args.peer is not None:
            peer_rate = self.peers[args.peer](int(args.particles[-1]), args.threads)
            ratio = cases[-1]["rate_per_s"] / peer_rate
            result |= {"peer": args.peer, "peer_rate_per_s": peer_rate, "ratio": ratio}
            print(f"peer {args.peer}: {peer_rate:.3g} particle-steps/s, ratio {ratio:.1f}")
        if args.json:
            print(json.dumps(result))
