"""Run by the Python of QGIS: opens a project, tells what is in it as JSON, and draws its layouts as PNG."""

import json
import sys
from pathlib import Path

from qgis.core import (  # type: ignore[import-not-found]
    QgsApplication,
    QgsLayoutExporter,
    QgsLayoutItemMap,
    QgsLayoutItemScaleBar,
    QgsProject,
    QgsUnitTypes,
    QgsVectorLayer,
)


def about_layer(layer):
    features = list(layer.getFeatures()) if isinstance(layer, QgsVectorLayer) else None
    return {
        "valid": layer.isValid(),
        "crs": layer.crs().authid() or layer.crs().description(),
        "units": QgsUnitTypes.toString(layer.crs().mapUnits()),
        "features": None if features is None else len(features),
        "renderer": type(layer.renderer()).__name__,
        "labels": features is not None and layer.labelsEnabled(),
    }


def about_layout(layout, folder):
    chart = next(item for item in layout.items() if isinstance(item, QgsLayoutItemMap))
    bar = next(item for item in layout.items() if isinstance(item, QgsLayoutItemScaleBar))
    page, settings = layout.pageCollection().page(0).pageSize(), QgsLayoutExporter.ImageExportSettings()
    settings.dpi = 50
    name = layout.name().replace("/", "_") + ".png"
    return {
        "scale": chart.scale(),
        "page": [page.width(), page.height()],
        "layers": [layer.id() for layer in chart.layers()],
        "bar": [bar.linkedMap() is chart, bar.unitLabel(), bar.unitsPerSegment()],
        "exported": QgsLayoutExporter(layout).exportToImage(str(folder / name), settings) == 0,
    }


application = QgsApplication([], False)
application.initQgis()
project = QgsProject.instance()
opened, view = project.read(sys.argv[1]), project.viewSettings().defaultViewExtent()
print(json.dumps({
    "opened": opened,
    "crs": project.crs().authid() or project.crs().description(),
    "view": [view.xMinimum(), view.yMinimum(), view.xMaximum(), view.yMaximum()],
    "visible": [node.layerId() for node in project.layerTreeRoot().findLayers() if node.isVisible()],
    "layers": {key: about_layer(layer) for key, layer in project.mapLayers().items()},
    "layouts": {layout.name(): about_layout(layout, Path(sys.argv[2]))
                for layout in project.layoutManager().layouts()},
}))  # fmt: skip
application.exitQgis()
