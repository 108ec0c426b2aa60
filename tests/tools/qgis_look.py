"""Opens rasters in QGIS as a person does who drags them into the window: a line of JSON for each, a picture on request.

    python3 qgis_look.py RASTER ... [--pictures FOLDER]
"""

import json
import os
import sys

os.environ["QT_QPA_PLATFORM"] = "offscreen"

from qgis.core import (  # noqa: E402  (the variable must be set before)
    QgsApplication,
    QgsLayerTreeLayer,
    QgsMapRendererSequentialJob,
    QgsMapSettings,
    QgsRasterLayer,
)
from qgis.PyQt.QtCore import QSize  # noqa: E402

paths, _, folder = " ".join(sys.argv[1:]).partition(" --pictures ")
application = QgsApplication([], False)
application.initQgis()
for path in paths.split():
    layer = QgsRasterLayer(path, os.path.basename(path))
    assert layer.isValid(), path
    nodes = layer.legend().createLayerTreeModelLegendNodes(QgsLayerTreeLayer(layer))
    legend = [str(node.data(0)) for node in nodes]
    settings = QgsMapSettings()
    settings.setLayers([layer])
    settings.setExtent(layer.extent())
    settings.setOutputSize(QSize(400, 320))
    settings.setDestinationCrs(layer.crs())
    job = QgsMapRendererSequentialJob(settings)
    job.start()
    job.waitForFinished()
    image = job.renderedImage()
    if folder:
        image.save(os.path.join(folder, os.path.basename(path) + ".png"))
    seen = {image.pixelColor(x, y).name() for x in range(0, 400, 4) for y in range(0, 320, 4)}
    print(json.dumps({"renderer": layer.renderer().type(), "legend": legend, "colors": sorted(seen)}))
application.exitQgis()
