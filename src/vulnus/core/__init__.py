"""Types, units, errors and constants that every room may use; imports nothing of vulnus."""
