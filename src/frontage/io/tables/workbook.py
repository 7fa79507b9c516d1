"""A workbook (Office Open XML, .xlsx): sheets of rows with units in their heads, with pictures in some."""

import datetime
import io
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from frontage.errors import MissingExtra
from frontage.io.files import whole_file
from frontage.io.tables.table import Column, Value

_LONG_AGO = datetime.datetime(1970, 1, 1)  # the same run gives the same bytes
_ROW_PT = 66.0  # height of a row with a picture, points
_PICTURE_PX = 84  # height that a picture gets in it, of the 88 px that the row has
_PICTURE_COLUMN = 14  # width in characters
_NUMBERS = {"m": "0.000", "m2": "0.00", "degree": "0.0", "": "0.00"}


@dataclass(frozen=True, eq=False)
class Sheet:
    """A sheet: title, columns, rows, and for every row a JPEG (b"" = none), or no pictures at all."""

    title: str
    columns: tuple[Column, ...]
    rows: tuple[tuple[Value, ...], ...]
    pictures: tuple[bytes, ...] = ()


def write_workbook(path: Path, title: str, sheets: Sequence[Sheet], about: Sequence[str]) -> None:
    """Write sheets of rows and a last sheet of text, which also explains every column.

    Numbers keep all their digits and are shown in mm, cm2 or tenths of a degree. Pictures stand in the first
    column. Raises MissingExtra without XlsxWriter, FileError when the file cannot be written.
    """
    try:
        import xlsxwriter
    except ImportError as error:
        raise MissingExtra("writing a workbook", "products") from error
    options = {"in_memory": True, "strings_to_formulas": False, "strings_to_urls": False}
    with whole_file(path) as temporary, xlsxwriter.Workbook(str(temporary), options) as book:
        book.set_properties({"title": title, "author": "Frontage", "created": _LONG_AGO})
        styles = _Styles(book)
        for sheet in sheets:
            _write_sheet(book.add_worksheet(sheet.title), sheet, styles)
        _write_about(book.add_worksheet("About"), sheets, about, styles)


class _Styles:
    """The formats of cells in a workbook."""

    def __init__(self, book: Any) -> None:
        self.head = book.add_format({"bold": True, "text_wrap": True, "bottom": 1, "valign": "top"})
        self.text = book.add_format({"valign": "vcenter"})
        self.whole = book.add_format({"valign": "vcenter", "num_format": "0"})
        self.wrapped = book.add_format({"text_wrap": True, "valign": "top"})
        self.real = {
            unit: book.add_format({"valign": "vcenter", "num_format": shown})
            for unit, shown in _NUMBERS.items()
        }

    def of(self, column: Column) -> Any:
        """Return the format of a column's values."""
        if column.kind == "real":
            return self.real.get(column.unit, self.real[""])
        return self.whole if column.kind == "whole" else self.text


def _write_sheet(sheet: Any, contents: Sheet, styles: _Styles) -> None:
    left = 1 if contents.pictures else 0
    if left:
        sheet.write_string(0, 0, "picture", styles.head)
        sheet.set_column(0, 0, _PICTURE_COLUMN)
    for k, column in enumerate(contents.columns, left):
        unit = f" [{column.unit}]" if column.unit else ""
        sheet.write_string(0, k, column.name.replace("_", " ") + unit, styles.head)
        sheet.set_column(k, k, 16 if column.kind == "text" else 10)
    for r, row in enumerate(contents.rows, 1):
        for k, (column, value) in enumerate(zip(contents.columns, row, strict=True), left):
            if value is not None:
                write = sheet.write_string if column.kind == "text" else sheet.write_number
                write(r, k, value, styles.of(column))
    for r, jpeg in enumerate(contents.pictures, 1):
        sheet.set_row(r, _ROW_PT)
        if jpeg:
            _insert(sheet, r, jpeg, f"row {r}")
    sheet.freeze_panes(1, left + 1)
    sheet.autofilter(0, left, max(len(contents.rows), 1), left + len(contents.columns) - 1)
    sheet.set_landscape()
    sheet.repeat_rows(0)


def _insert(sheet: Any, row: int, jpeg: bytes, name: str) -> None:
    """Insert a picture, scaled into its row and column."""
    from PIL import Image

    image = Image.open(io.BytesIO(jpeg))
    width, height = image.size
    scale = min(_PICTURE_PX / height, 7 * _PICTURE_COLUMN / width)
    dpi = [float(v) or 96.0 for v in image.info.get("dpi", (96.0, 96.0))]
    data = {"image_data": io.BytesIO(jpeg), "x_offset": 2, "y_offset": 2, "object_position": 2,
            "x_scale": scale * dpi[0] / 96.0, "y_scale": scale * dpi[1] / 96.0}  # fmt: skip
    sheet.insert_image(row, 0, f"{name}.jpg", data)


def _write_about(sheet: Any, sheets: Sequence[Sheet], about: Sequence[str], styles: _Styles) -> None:
    sheet.set_column(0, 0, 24)
    sheet.set_column(1, 1, 90)
    for row, text in enumerate(about):
        sheet.write_string(row, 1, text, styles.wrapped)
    row = len(about) + 1
    for contents in sheets:
        for column in contents.columns:
            sheet.write_string(row, 0, f"{contents.title}: {column.name.replace('_', ' ')}", styles.wrapped)
            sheet.write_string(row, 1, column.description, styles.wrapped)
            row += 1
