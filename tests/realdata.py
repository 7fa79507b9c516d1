"""The folder of the real data beside the checkout; tests that need it are skipped where it is missing."""

from collections.abc import Iterable
from pathlib import Path

import pytest
from lxml import etree

ROOT = Path(__file__).resolve().parents[1]
DATA = ROOT.parent / "shared" / "data"


def data_path(relative: str) -> Path:
    """Returns the path of a file or folder of the real data, or skips the test and says what is missing."""
    path = DATA / relative
    if not path.exists():
        pytest.skip(f"real data is absent: {relative}")
    return path


def citygml_schema(folder: Path, version: str, modules: Iterable[str]) -> etree.XMLSchema:
    """The official schema of some modules of CityGML; a file in `folder` imports them together."""
    published = data_path(f"schemas/citygml/citygml/{version}/building.xsd").parent
    imports = "".join(
        f'<xs:import namespace="http://www.opengis.net/citygml/{m}/{version}" '
        f'schemaLocation="{(published / f"{m}.xsd").resolve().as_uri()}"/>'
        for m in modules
    )
    text = f'<xs:schema xmlns:xs="http://www.w3.org/2001/XMLSchema">{imports}</xs:schema>'
    (folder / "all.xsd").write_text(text)
    return etree.XMLSchema(etree.parse(str(folder / "all.xsd")))
