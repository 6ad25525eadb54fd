"""Surface of the blood, ray-traced pictures, film and figures of a run."""
