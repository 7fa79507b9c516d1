"""The table of error codes and the source agree."""

import re
from pathlib import Path

import pytest

import frontage
from frontage.errors import CODES, FrontageError

SOURCE = Path(frontage.__file__).parent
CODE = re.compile(r'"([A-Z]\d{3})"')


def codes_in_use() -> set[str]:
    """Every code that stands as a literal in the source, outside the table itself."""
    files = (p for p in SOURCE.rglob("*.py") if p != SOURCE / "errors" / "codes.py")
    return {code for path in files for code in CODE.findall(path.read_text("utf-8"))}


def test_every_code_of_the_source_is_explained() -> None:
    assert codes_in_use() - set(CODES) == set()


def test_every_explained_code_is_used() -> None:
    assert set(CODES) - codes_in_use() == set()


@pytest.mark.parametrize("code", CODES)
def test_explanations_are_whole_sentences(code: str) -> None:
    for text in CODES[code]:
        assert text[0].isupper() and text.endswith(".")


def test_exceptions_carry_codes_of_the_table() -> None:
    def tree(error: type[FrontageError]) -> list[type[FrontageError]]:
        return [error, *(e for sub in error.__subclasses__() for e in tree(sub))]

    assert {e.code for e in tree(FrontageError)} <= set(CODES)
