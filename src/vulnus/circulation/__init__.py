"""The systemic arterial tree and the branch where it bleeds (paper section 2.3)."""
