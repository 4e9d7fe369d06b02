"""Texts of the repository, changed for a test."""

from collections.abc import Mapping


def replaced(text: str, changes: Mapping[str, str]) -> str:
    """Returns a text with parts replaced; it must have each of them."""
    for old, new in changes.items():
        assert old in text, f"the text has no `{old}`"
        text = text.replace(old, new)
    return text
