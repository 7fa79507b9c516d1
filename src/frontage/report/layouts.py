"""The layout of a window's bars in words."""

from frontage.model import Glazing


def layout_words(glazing: Glazing) -> str:
    """ "2 mullions, 1 transom"; "one pane"; "not resolved"."""
    if not glazing.resolved:
        return "not resolved"
    upright, level = glazing.counts
    parts = [counted(upright, "mullion"), counted(level, "transom")]
    return ", ".join(part for part in parts if part) or "one pane"


def counted(number: int, word: str) -> str:
    """ "2 mullions", "1 mullion"; empty for none."""
    return f"{number} {word}{'' if number == 1 else 's'}" if number else ""
