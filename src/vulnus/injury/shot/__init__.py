"""One shot through a limb, from its aim to the wound report. Start at `passage`."""
