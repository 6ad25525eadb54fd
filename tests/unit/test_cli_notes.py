"""What a stage logs or warns of reaches the user as a sentence, and only then."""

from __future__ import annotations

import logging
import warnings

from vulnus.terminal import notes_said


def test_log_records_and_warnings_become_sentences() -> None:
    said: list[str] = []
    with notes_said(said.append):
        logging.getLogger("vulnus.anatomy").warning("skin has %d ml", 3)
        warnings.warn("outside the volume: fibular", stacklevel=1)
    logging.getLogger("vulnus.anatomy").debug("unheard")
    assert said == ["note: skin has 3 ml", "note: outside the volume: fibular"]
