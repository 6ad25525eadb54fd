"""`python -m vulnus` is the command `vulnus`."""

from __future__ import annotations

import sys

from vulnus.cli import main

sys.exit(main())
