"""What the viewer asks of a run folder again and again, read once."""

from functools import cached_property
from pathlib import Path

from frontage.catalog.addressbook import known_addresses
from frontage.errors import WorkspaceError
from frontage.model import Facade, Photo
from frontage.pipeline.groundplans import ground_plans
from frontage.pipeline.store.results import EvidencePicture
from frontage.pipeline.store.store import Store
from frontage.queries.answer import Witnesses


class Run:
    """A run folder with the names that its parts have in the site."""

    def __init__(self, store: Store) -> None:
        """Raises WorkspaceError if the run has no facade."""
        self.store = store
        self.facades = tuple(store.facade_ids())
        if not self.facades:
            raise WorkspaceError(
                f"{store.out} has no facade that could be shown; `frontage run` finds them, and its warnings "
                "say why there is none"
            )

    @cached_property
    def title(self) -> str:
        """What the run is called: the name in its project, else that of its folder."""
        return self.store.project().project.name or self.store.out.resolve().name

    @cached_property
    def witnesses(self) -> Witnesses:
        """The photos, and what may hide an opening from them."""
        return Witnesses(self.store)

    @cached_property
    def photos(self) -> tuple[Photo, ...]:
        """The oriented photos."""
        found = self.witnesses.photos
        return tuple(p for p in found.photos if p.local_from_camera is not None) if found else ()

    @cached_property
    def photo_numbers(self) -> dict[str, int]:
        """The number of every oriented photo in the site."""
        return {photo.id: number for number, photo in enumerate(self.photos)}

    @cached_property
    def addresses(self) -> tuple[dict[str, list[str]], dict[str, str]]:
        """The addresses of every building, and why an address of the project file is nobody's."""
        book = self.store.project().addresses
        plans = ground_plans(self.store) if any(entry.at for entry in book) else {}
        return known_addresses({r.id: r.address for r in self.store.building_records()}, plans, book)

    @cached_property
    def tile_files(self) -> tuple[Path, ...]:
        """The files of the 3D Tiles, the tileset first; empty if the run has none."""
        folder = self.store.products_folder / "tiles"
        if not (folder / "tileset.json").is_file():
            return ()
        return (folder / "tileset.json", *sorted(p for p in folder.glob("*.glb") if p.is_file()))

    def evidence(self, facade: str) -> tuple[EvidencePicture, ...]:
        """The pictures of what openings were found from."""
        item = self.store.openings_item(facade.rsplit("/", 1)[0])
        folder = self.store.facade_folder(facade)
        return tuple(p for p in item.pictures.get(facade, ()) if (folder / f"{p.name}.png").is_file())

    def plane(self, facade: str) -> Facade:
        """The plane, frame and outline of a facade."""
        return self.store.facade(facade)

    def facade_path(self, facade: str) -> str:
        """The folder of a facade in the site."""
        return f"facades/{facade.replace('/', '_')}"

    def photo_path(self, number: int) -> str:
        """The path of a photo in the site."""
        return f"photos/{number:04d}.jpg"
