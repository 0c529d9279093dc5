# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""Writes the detectors' curves and states into the layouts for Foxglove and PlotJuggler.

python -m tools.layouts config
"""

from __future__ import annotations

import itertools
import json
from collections.abc import Iterator
from pathlib import Path
from xml.etree import ElementTree as ET

import click

from hijack_detect.monitor.parts import DETECTORS
from tools.documents import write

FOXGLOVE, PLOTJUGGLER = "foxglove_layout.json", "plotjuggler_layout.xml"
COLOURS = (
    "#0072b2",
    "#d55e00",
    "#009e73",
    "#cc79a7",
    "#56b4e9",
    "#b8860b",
    "#7f7f7f",
    "#6a3d9a",
)
"""Of the detectors in turn, distinct for colour-blind eyes too."""
KEY = '/PART/verdict.status[0].values[:]{key=="NAME"}.value'
PLOTS = {
    "Plot!margins": ("/PART/margin.data", "receiveTime"),
    "Plot!recorded": (KEY.replace("NAME", "margin"), "headerStamp"),
}
"""Panels with a curve for each detector: where it comes from, and the time that it is drawn at."""
STATES = "StateTransitions!states"


def coloured() -> Iterator[tuple[str, str]]:
    """Each detector and its colour."""
    return zip(DETECTORS, itertools.cycle(COLOURS), strict=False)


def foxglove(text: str) -> str:
    """The layout for Foxglove with a curve and a state for each detector."""
    layout = json.loads(text)
    panels = layout["configById"]
    for name, (value, method) in PLOTS.items():
        panels[name]["paths"][1:] = [
            {
                "value": value.replace("PART", detector),
                "enabled": True,
                "timestampMethod": method,
                "label": detector,
                "color": colour,
                "showLine": True,
            }
            for detector, colour in coloured()
        ]
    panels[STATES]["paths"] = [
        {
            "value": KEY.replace("NAME", "state").replace("PART", part),
            "label": part,
            "timestampMethod": "headerStamp",
        }
        for part in ("fusion", *DETECTORS)
    ]
    return json.dumps(layout, indent=2, ensure_ascii=False) + "\n"


def plotjuggler(text: str) -> str:
    """The layout for PlotJuggler with a curve for each detector."""
    root = ET.fromstring(text)
    live, _, recorded, _ = root.iter("plot")
    for plot, topic in ((live, "/{0}/margin/data"), (recorded, "/{0}/verdict/{0}/margin")):
        for curve in plot.findall("curve"):
            plot.remove(curve)
        for detector, colour in coloured():
            ET.SubElement(plot, "curve", name=topic.format(detector), color=colour)
    streamed = root.find("Plugins/plugin/selected_topics")
    assert streamed is not None
    topics = [*(f"/{detector}/margin" for detector in DETECTORS), "/hijack_confidence"]
    streamed.set("value", ";".join(topics))
    ET.indent(root)
    return f"<?xml version='1.0' encoding='UTF-8'?>\n{ET.tostring(root, encoding='unicode')}\n"


@click.command()
@click.argument("folder", type=click.Path(exists=True, file_okay=False, path_type=Path))
def main(folder: Path) -> None:
    """Write the layouts in FOLDER."""
    for name, made in ((FOXGLOVE, foxglove), (PLOTJUGGLER, plotjuggler)):
        write(folder / name, made((folder / name).read_text(encoding="utf-8")))


if __name__ == "__main__":
    main()
