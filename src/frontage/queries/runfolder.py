"""A finished run as an object: what a user or a notebook asks it."""

import base64
import html
from pathlib import Path
from typing import TYPE_CHECKING, overload

from frontage.errors import InputError
from frontage.exports.tables import survey_tables
from frontage.io.tables.frame import geo_frame
from frontage.model import Elements, Facade, OrthoImage
from frontage.pipeline.store.store import Store
from frontage.pipeline.survey import gather_survey
from frontage.queries.answer import Located
from frontage.queries.locate import locate
from frontage.queries.pixels import FacadePixels

if TYPE_CHECKING:
    import geopandas

_PICTURES = 12  # that a notebook shows


class RunFolder:
    """A run folder. `open_run(out).facade("B07/F1").pixel_to_world(column, row)` measures in it."""

    def __init__(self, out: Path | str) -> None:
        """Open an existing run folder. Raises WorkspaceError if it is none."""
        self.store = Store(out)

    @property
    def out(self) -> Path:
        """The path of the folder."""
        return self.store.out

    @property
    def buildings(self) -> tuple[str, ...]:
        """Ids of the buildings, along the street."""
        return tuple(record.id for record in self.store.building_records())

    @property
    def facades(self) -> tuple[str, ...]:
        """Ids of the facades ("B07/F1"), in the order of the buildings."""
        return tuple(self.store.facade_ids())

    def plane(self, facade: str) -> Facade:
        """Return the plane, frame and outline of a facade. Raises InputError for an unknown id."""
        return self.store.facade(facade)

    def facade(self, facade: str) -> FacadePixels:
        """Return the ortho-image of a facade as a measuring device: pixel to world and back.

        Raises InputError for an unknown id ("B07/F1" or "B07_F1"), FileError if it has no ortho-image.
        """
        return FacadePixels(self.store.facade_folder(self.store.known_facade(facade)))

    def ortho(self, facade: str) -> OrthoImage | None:
        """Return the ortho-image of a facade with all its bands; None if it has none."""
        return self.store.ortho(self.store.known_facade(facade))

    @overload
    def openings(self) -> "geopandas.GeoDataFrame": ...

    @overload
    def openings(self, facade: str) -> Elements | None: ...

    def openings(self, facade: str | None = None) -> "geopandas.GeoDataFrame | Elements | None":
        """Return the openings and protrusions of a facade, None if it was not judged; or a table of all.

        Without a facade, the openings of the run as a GeoDataFrame: the columns of `products/openings.csv`,
        the geometry is the outline in the world. That raises MissingExtra without GeoPandas.
        """
        if facade is not None:
            return self.store.elements(self.store.known_facade(facade))
        return self.table("opening_outlines")

    def table(self, layer: str) -> "geopandas.GeoDataFrame":
        """Return a layer of `products/frontage.gpkg` as a GeoDataFrame, such as "facades" or "buildings".

        Raises InputError for an unknown layer, MissingExtra without GeoPandas.
        """
        survey = gather_survey(self.store)
        tables = {table.name: table for table in survey_tables(survey)}
        if layer not in tables:
            raise InputError(f"no layer {layer!r}; there are {', '.join(tables)}")
        return geo_frame(tables[layer], survey.world.crs)

    def locate(
        self,
        address: str,
        *,
        floor: int | None = None,
        window: int | None = None,
        door: int | None = None,
        facade: str | None = None,
    ) -> Located:
        """Locate an opening: `locate("13 rue Soufflot", floor=3, window=2)`, or by its id alone.

        See `frontage.queries.locate.locate`. Raises InputError with one sentence if there is none.
        """
        return locate(self.store, address, floor=floor, window=window, door=door, facade=facade)

    def __repr__(self) -> str:
        """Say what the folder holds."""
        items = {name: stage.items for name, stage in self.store.manifest().stages.items()}
        counts = ", ".join(
            f"{items[name]:,} {name}" for name in ("buildings", "facades", "openings") if name in items
        )
        return f"<frontage run {self.out}: {counts or 'nothing yet'}>"

    def _repr_html_(self) -> str:
        """Show the drawn facades in a notebook."""
        found = ((name, self.store.facade_folder(name)) for name in self.facades)
        pictures = [
            (name, p) for name, f in found for p in (f / "openings.png", f / "ortho.jpg") if p.is_file()
        ]
        first = dict(reversed(pictures))
        figures = "".join(
            _figure(name, first[name]) for name in list(dict.fromkeys(n for n, _ in pictures))[:_PICTURES]
        )
        return f"<p>{html.escape(repr(self))}</p>{figures}"


def open_run(out: Path | str) -> RunFolder:
    """Open an existing run folder. Raises WorkspaceError if it is none."""
    return RunFolder(out)


def _figure(name: str, path: Path) -> str:
    kind = "png" if path.suffix == ".png" else "jpeg"
    data = base64.b64encode(path.read_bytes()).decode()
    style = "display:inline-block;margin:4px;vertical-align:bottom"
    image = f'<img alt="{html.escape(name)}" height="260" src="data:image/{kind};base64,{data}">'
    return f'<figure style="{style}">{image}<figcaption>{html.escape(name)}</figcaption></figure>'
