"""What a projectile left: cavity, tract, holes of the skin, torn arteries, fragments of bone."""
