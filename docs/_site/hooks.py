"""What `mkdocs build` does besides Markdown: fills in generated references and turns equations into MathML.

A line `{{ generated: NAME }}` on a page is replaced by the Markdown that `generate.SECTIONS[NAME]` returns.
"""

import importlib.util
import re
from html import unescape
from pathlib import Path
from typing import Any

from latex2mathml.converter import convert

MARK = re.compile(r"^\{\{ generated: (\S+) \}\}$", re.M)
INLINE = re.compile(r'<span class="arithmatex">\\\((.*?)\\\)</span>', re.S)
DISPLAY = re.compile(r'<div class="arithmatex">\\\[(.*?)\\\]</div>', re.S)


def _generate() -> Any:
    spec = importlib.util.spec_from_file_location("generate", Path(__file__).with_name("generate.py"))
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def on_page_markdown(markdown: str, **_: Any) -> str:
    """Fill in the generated sections of a page."""
    if not MARK.search(markdown):
        return markdown
    sections = _generate().SECTIONS
    return MARK.sub(lambda mark: sections[mark[1]](), markdown)


def on_page_content(html: str, **_: Any) -> str:
    """Replace every equation by MathML, which browsers draw without a script."""
    html = INLINE.sub(lambda found: convert(unescape(found[1]).strip()), html)
    return DISPLAY.sub(lambda found: convert(unescape(found[1]).strip(), display="block"), html)
