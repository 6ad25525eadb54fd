"""Which is slowed more over the first 20 mm of gelatin, a steel ball or a bullet of its diameter?

Sets up both shots with the public API alone: on a coarse grid, and the first part of the way.
"""

from __future__ import annotations

from vulnus.injury import Block, Experiment, RigidBodyRecord


def shoot(projectile: str, *, speed: float, until: float) -> RigidBodyRecord:
    """The ball's way through a small block of 10 % gelatin up to the time `until` [s]."""
    experiment = Experiment(grid_spacing=1.8e-3)
    block = Block(size=(0.045, 0.032, 0.032), centre=(0.0225, 0.0, 0.0))
    experiment.add_body(block, material="gelatin_10", name="gel")
    experiment.add_projectile(
        projectile, speed=speed, direction="x", target=(0.0, 0.0, 0.0), name="ball"
    )
    return experiment.run(until=until, sample_interval=until / 10).rigid_body("ball")


def main() -> dict[str, float]:
    """Speed lost over the first 20 mm [m/s], by projectile."""
    lost = {}
    for name in ("sphere_9mm_steel", "9x19_fmj"):
        ball = shoot(name, speed=150.0, until=1.8e-4)
        beyond = next(k for k, depth in enumerate(ball.depth) if depth > 0.02)
        lost[name] = float(ball.speed[0] - ball.speed[beyond])
    return lost


if __name__ == "__main__":
    losses = main()
    for name, loss in losses.items():
        print(f"{name}: {loss:.0f} m/s lost over the first 20 mm")
    assert losses["9x19_fmj"] < losses["sphere_9mm_steel"], "2.7 times the mass, pointed ahead"
