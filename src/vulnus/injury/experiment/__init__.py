"""The public case: bodies, projectiles, walls and sensors, no leg. Start at `experiment`."""
