"""Writes elevations as PDF: vector drawings to scale, one page each, and one more over the ortho-image."""

import io
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from frontage.errors import MissingExtra
from frontage.io.drawings.elevation import (
    BORDER_MM,
    LAYERS,
    TITLE_MM,
    Dimension,
    Elevation,
    Line,
    place_on_sheet,
)
from frontage.io.files import whole_file

MM = 72.0 / 25.4
"""Points per millimetre."""

_COLOURS = {
    "OUTLINE": (0.0, 0.0, 0.0), "WALL_LINES": (0.5, 0.5, 0.5), "PROTRUSIONS": (0.0, 0.45, 0.2),
    "BARS": (0.45, 0.45, 0.45), "LEVELS": (0.4, 0.0, 0.4), "DIMENSIONS": (0.3, 0.3, 0.3),
    "LABELS": (0.2, 0.2, 0.2), "OPENING_WINDOW": (0.0, 0.2, 0.7), "OPENING_DOOR": (0.7, 0.1, 0.0),
}  # fmt: skip
_OPENING = (0.0, 0.35, 0.5)  # kinds without a colour of their own
_FONT, _BOLD, _TEXT_MM, _SMALL_MM = "Helvetica", "Helvetica-Bold", 2.4, 1.9


def write_pdf(path: Path, elevations: Sequence[Elevation], title: str) -> None:
    """Write the elevations of a building. Characters beyond Western European ones are shown as "?".

    Raises MissingExtra without ReportLab, FileError when the file cannot be written.
    """
    try:
        from reportlab.pdfgen.canvas import Canvas
    except ImportError as error:
        raise MissingExtra("writing PDF", "products") from error
    with whole_file(path) as temporary:
        canvas = Canvas(str(temporary), invariant=1)  # the same run gives the same bytes
        canvas.setTitle(title)
        canvas.setCreator("Frontage")
        for elevation in elevations:
            for underlay in (False, True) if elevation.underlay else (False,):
                _Page(canvas, elevation).draw(underlay)
        canvas.save()


class _Page:
    """One page: metres of the facade become points of the page."""

    def __init__(self, canvas: Any, e: Elevation) -> None:
        self.canvas, self.e, self.at = canvas, e, place_on_sheet(e)

    def point(self, x: float, h: float) -> tuple[float, float]:
        """Return the place on the page (points) of (x, h) m."""
        per_metre = 1000 / self.e.sheet.scale * MM
        x0, h0, _, _ = self.e.bounds
        return self.at[0] * MM + (x - x0) * per_metre, self.at[1] * MM + (h - h0) * per_metre

    def draw(self, underlay: bool) -> None:
        """Draw the page, over the ortho-image or without it."""
        (w, h), canvas = self.e.sheet.size, self.canvas
        canvas.setPageSize((w * MM, h * MM))
        if underlay:
            self._underlay()
        for line in self.e.lines:
            self._line(line)
        if not underlay:
            for label in self.e.labels:
                x, y = self.point(*label.at)
                self._text(label.text, x, y - _SMALL_MM * MM / 3, _SMALL_MM, "LABELS", centred=True)
        for dimension in self.e.dimensions:
            self._dimension(dimension)
        self._levels()
        self._frame(", over the ortho-image" if underlay else "")
        canvas.showPage()

    def _underlay(self) -> None:
        from reportlab.lib.utils import ImageReader

        under = self.e.underlay
        assert under is not None
        (x, top), (w, h) = under.corner, under.size
        (left, low), (right, high) = self.point(x, top - h), self.point(x + w, top)
        image = ImageReader(io.BytesIO(under.jpeg))
        self.canvas.drawImage(image, left, low, right - left, high - low)

    def _line(self, line: Line) -> None:
        self._pen(line.layer, LAYERS[line.layer][1] / 100)
        if line.dashed:
            self.canvas.setDash([2.5 * MM, 1.5 * MM])
        path = self.canvas.beginPath()
        first, *others = (self.point(float(x), float(h)) for x, h in line.points)
        path.moveTo(*first)
        for corner in others:
            path.lineTo(*corner)
        path.close()
        self.canvas.drawPath(path, stroke=1, fill=0)
        self.canvas.setDash()

    def _dimension(self, d: Dimension) -> None:
        """Draw a dimension: the line, a slash at both ends, the length in m above it."""
        self._pen("DIMENSIONS", 0.13)
        level = d.axis == "x"
        ends = [self.point(p[0], d.at) if level else self.point(d.at, p[1]) for p in (d.start, d.end)]
        (ax, ay), (bx, by) = ends
        self.canvas.line(ax, ay, bx, by)
        for x, y in ends:
            self.canvas.line(x - MM, y - MM, x + MM, y + MM)
            across = (0.0, 1.5 * MM) if level else (1.5 * MM, 0.0)
            self.canvas.line(x - across[0], y - across[1], x + across[0], y + across[1])
        self.canvas.saveState()
        self.canvas.translate((ax + bx) / 2, (ay + by) / 2)
        self.canvas.rotate(0 if level else 90)
        text, room = f"{d.length:.3f}", max(abs(bx - ax), abs(by - ay))
        size = min(_SMALL_MM, 0.9 * room / self.canvas.stringWidth(text, _FONT, 1.0) / MM)
        self._text(text, 0.0, 0.7 * MM, size, "DIMENSIONS", centred=True)
        self.canvas.restoreState()

    def _levels(self) -> None:
        """Draw the levels on the right; texts that would overlap move up, with a leader."""
        right, last = self.point(self.e.bounds[2], 0.0)[0] + 2 * MM, -1e9
        for level in self.e.levels:
            y = self.point(0.0, level.height)[1]
            text_y = max(y, last + (_SMALL_MM + 1.4) * MM)
            self._pen("LEVELS", 0.13)
            self.canvas.line(right, y, right + 5 * MM, y)
            self.canvas.line(right + 5 * MM, y, right + 9 * MM, text_y)
            self.canvas.line(right + 9 * MM, text_y, right + 22 * MM, text_y)
            text = f"{level.height:+.3f}  {level.name}"
            self._text(text, right + 9.5 * MM, text_y + 0.5 * MM, _SMALL_MM, "LEVELS")
            last = text_y

    def _frame(self, what: str) -> None:
        """Draw the border, the title block and the scale bar."""
        (w, h), e = self.e.sheet.size, self.e
        self._pen("OUTLINE", 0.25)
        left, wide = BORDER_MM * MM, (w - 2 * BORDER_MM) * MM
        self.canvas.rect(left, left, wide, (h - 2 * BORDER_MM) * MM)
        self.canvas.rect(left, left, wide, TITLE_MM * MM)
        top = (BORDER_MM + TITLE_MM) * MM
        words = (e.title[0] + what, f"{e.sheet.words}, to scale when printed at 100 %", *e.title[1:])
        for k, text in enumerate(words):
            self._text(text, left + 4 * MM, top - (6 + 4.6 * k) * MM, _TEXT_MM, "OUTLINE", bold=not k)
        self._scale_bar(left + wide - 12 * MM, top - 12 * MM)

    def _scale_bar(self, right: float, y: float) -> None:
        """Draw a bar of 5 m, or of a longer round length at small scales, in five parts."""
        part = self.e.sheet.scale / 50
        step = part * 1000 / self.e.sheet.scale * MM
        left = right - 5 * step
        self._pen("OUTLINE", 0.18)
        self.canvas.setFillColorRGB(0, 0, 0)
        for k in range(5):
            self.canvas.rect(left + k * step, y, step, 1.5 * MM, fill=int(k % 2 == 0))
        for k in range(6):
            self._text(f"{k * part:g}", left + k * step, y + 2.5 * MM, _SMALL_MM, "OUTLINE", centred=True)
        self._text("m", right + 3 * MM, y + 2.5 * MM, _SMALL_MM, "OUTLINE")

    def _pen(self, layer: str, millimetres: float) -> None:
        self.canvas.setStrokeColorRGB(*_COLOURS.get(layer, _OPENING))
        self.canvas.setLineWidth(millimetres * MM)

    def _text(
        self,
        text: str,
        x: float,
        y: float,
        size: float,
        layer: str,
        *,
        centred: bool = False,
        bold: bool = False,
    ) -> None:
        self.canvas.setFillColorRGB(*_COLOURS[layer])
        self.canvas.setFont(_BOLD if bold else _FONT, size * MM * 1.3)
        shown = text.encode("cp1252", "replace").decode("cp1252")
        (self.canvas.drawCentredString if centred else self.canvas.drawString)(x, y, shown)
