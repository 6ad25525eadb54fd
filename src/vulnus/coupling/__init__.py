"""The exchange of flow and pressure between the arterial tree and the blood particles."""
