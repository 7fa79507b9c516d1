"""The pictures on the polygons of a CityGML file: one ParameterizedTexture per picture."""

from collections.abc import Sequence

from frontage.geometry.arrays import Float
from frontage.io.citymodels.citygml.dialect import Dialect, Node
from frontage.model.citymodel import Texture

_THEME = "facades"
_MIME = {"jpg": "image/jpeg", "jpeg": "image/jpeg", "png": "image/png"}

_Painted = tuple[str, list[tuple[str, Float]]]
"""The id of a polygon, and of its rings with the positions (k, 2) of their corners in the picture."""


class Appearance:
    """Collects what polygons show, and writes it as the last member of the model."""

    def __init__(self) -> None:
        self._painted: dict[str, list[_Painted]] = {}

    def add(self, texture: Texture, polygon: str, rings: Sequence[str]) -> None:
        """Note the texture of a polygon, with the ids of the polygon and of its rings in the file."""
        pairs = list(zip(rings, texture.rings, strict=True))
        self._painted.setdefault(texture.image, []).append((polygon, pairs))

    def write(self, dialect: Dialect, root: Node) -> None:
        """Append the appearance to the model, if there is any picture."""
        if not self._painted:
            return
        holder = "app:appearanceMember" if dialect.version == "2.0" else "core:appearanceMember"
        appearance = dialect.add(dialect.add(root, holder), "app:Appearance")
        dialect.add(appearance, "app:theme", _THEME)
        inside = "app:surfaceDataMember" if dialect.version == "2.0" else "app:surfaceData"
        for image, polygons in self._painted.items():
            texture = dialect.add(dialect.add(appearance, inside), "app:ParameterizedTexture")
            dialect.add(texture, "app:imageURI", image)
            dialect.add(texture, "app:mimeType", _MIME[image.rpartition(".")[2].lower()])
            dialect.add(texture, "app:textureType", "specific")
            dialect.add(texture, "app:wrapMode", "clamp")
            for polygon, rings in polygons:
                _target(dialect, texture, polygon, rings)


def _target(dialect: Dialect, texture: Node, polygon: str, rings: Sequence[tuple[str, Float]]) -> None:
    """Append the positions of a polygon's corners; the rings of the file repeat their first corner."""
    places = [(name, _numbers(places)) for name, places in rings]
    if dialect.version == "2.0":
        target = dialect.add(texture, "app:target", uri=f"#{polygon}")
        listed = dialect.add(target, "app:TexCoordList")
        for name, numbers in places:
            dialect.add(listed, "app:textureCoordinates", numbers, ring=f"#{name}")
        return
    link = dialect.add(dialect.add(texture, "app:textureParameterization"), "app:TextureAssociation")
    link.set(dialect.tag("gml:id"), f"texture_of_{polygon}")
    dialect.add(link, "app:target", f"#{polygon}")
    listed = dialect.add(dialect.add(link, "app:textureParameterization"), "app:TexCoordList")
    for _, numbers in places:
        dialect.add(listed, "app:textureCoordinates", numbers)
    for name, _ in places:
        dialect.add(listed, "app:ring", f"#{name}")


def _numbers(places: Float) -> str:
    return " ".join(f"{v:.6f}" for v in (*places.ravel(), *places[0]))
