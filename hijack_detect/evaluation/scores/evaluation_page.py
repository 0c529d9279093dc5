# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""An evaluation as one self-contained page."""

from __future__ import annotations

from collections.abc import Iterable
from html import escape

import plotly.graph_objects as go

from hijack_detect.evaluation.scores.basan_tables import basan_tables
from hijack_detect.evaluation.scores.evaluate import Evaluation
from hijack_detect.evaluation.scores.evaluation_tables import (
    DEFINITIONS,
    EXPLAINED,
    TextTable,
    class_table,
    correct_table,
    detection_table,
    error_table,
    flight_table,
)
from hijack_detect.evaluation.scores.methods import Judgement
from hijack_detect.evaluation.scores.metrics import roc_curve
from hijack_detect.evaluation.scores.watch_tables import EXPLAINED as WATCHED
from hijack_detect.evaluation.scores.watch_tables import watch_tables

STYLE = """
body { font: 15px/1.45 system-ui, sans-serif; margin: 2rem auto; max-width: 75rem; padding: 0 1rem;
  color: #1c2430; }
table { border-collapse: collapse; margin: .6rem 0 1.6rem; }
th, td { padding: .25rem .7rem; border-bottom: 1px solid #d8dee8; text-align: right;
  white-space: nowrap; }
th:first-child, td:first-child { text-align: left; }
td.text { text-align: left; white-space: normal; min-width: 20rem; }
thead th { border-bottom: 2px solid #8592a6; position: sticky; top: 0; background: #fff; }
.wrong { background: #fde3df; color: #8c1c0c; }
dt { font-weight: 600; } dd { margin: 0 0 .4rem 1.2rem; }
.wide { overflow-x: auto; }
"""
LONG = 60
"""Characters from which a cell is a sentence."""
WRONG = tuple(judgement.value for judgement in Judgement if not judgement.correct)


def evaluation_page(evaluation: Evaluation) -> str:
    """The page: tables, ROC curves, what the figures mean, and every flight."""
    title = f"{evaluation.source}, policy {evaluation.policy}"
    hijacked = sum(flight.onset_s is not None for flight in evaluation.flights)
    facts = (
        f"{len(evaluation.flights)} flights, {hijacked} of them hijacked; "
        f"{len(evaluation.failed)} could not be read. hijack_detect {evaluation.version}."
    )
    tables = (correct_table, error_table, detection_table)
    by_class = None if evaluation.forging else class_table(evaluation)
    return "\n".join(
        [
            '<!DOCTYPE html><html lang="en"><head><meta charset="utf-8">',
            '<meta name="viewport" content="width=device-width, initial-scale=1">',
            f"<title>{escape(title)}</title><style>{STYLE}</style></head><body>",
            f"<h1>Evaluation: {escape(title)}</h1><p>{escape(facts)}</p>",
            *map(_section, watch_tables(evaluation)),
            *(_section(table(evaluation)) for table in tables),
            *([] if by_class is None else [_section(by_class)]),
            *(map(_section, basan_tables(evaluation)) if evaluation.forging else ()),
            _roc(evaluation),
            _list(
                "Methods", {name: EXPLAINED.get(name, "detector") for name in evaluation.methods}
            ),
            _list("What the figures mean", {**WATCHED, **DEFINITIONS}),
            _failed(evaluation),
            _section(flight_table(evaluation)),
            "</body></html>\n",
        ]
    )


def _section(table: TextTable) -> str:
    head = "".join(f"<th>{escape(name)}</th>" for name in table.columns)
    body = "".join(f"<tr>{''.join(_cells(row))}</tr>" for row in table.rows)
    return (
        f'<h2>{escape(table.title)}</h2><div class="wide"><table><thead><tr>{head}</tr></thead>'
        f"<tbody>{body}</tbody></table></div>"
    )


def _cells(row: Iterable[str]) -> Iterable[str]:
    for column, text in enumerate(row):
        wrong = ' class="wrong"' if column and text.startswith(WRONG) else ""
        long = ' class="text"' if len(text) > LONG and not wrong else wrong
        yield f"<td{long}>{escape(text).replace(chr(10), '<br>')}</td>"


def _list(title: str, entries: dict[str, str]) -> str:
    terms = "".join(f"<dt>{escape(k)}</dt><dd>{escape(v)}</dd>" for k, v in entries.items())
    return f"<h2>{escape(title)}</h2><dl>{terms}</dl>"


def _failed(evaluation: Evaluation) -> str:
    failed = {flight.name: flight.reason for flight in evaluation.failed}
    return _list("Flights that could not be read", failed) if failed else ""


def _roc(evaluation: Evaluation) -> str:
    """ROC curves of all methods, with the data of the figure and its library inside."""
    figure = go.Figure()
    for name, summary in evaluation.methods.items():
        if summary.roc_area is None:
            return "<h2>ROC</h2><p>It needs clean and hijacked flights.</p>"
        scores = [(f.onset_s is None, f.methods[name].score) for f in evaluation.flights]
        clean, hijacked = ([s for is_clean, s in scores if is_clean is c] for c in (True, False))
        false, true = roc_curve(clean, hijacked)
        figure.add_scatter(
            x=false.tolist(),
            y=true.tolist(),
            mode="lines",
            name=f"{name} ({summary.roc_area:.4f})",
        )
    figure.update_layout(
        template="plotly_white",
        height=480,
        margin={"t": 20},
        legend_title="method (area)",
        xaxis={"title": "clean flights at or above the threshold", "range": [-0.02, 1.02]},
        yaxis={"title": "hijacked flights at or above the threshold", "range": [-0.02, 1.02]},
    )
    drawn = figure.to_html(full_html=False, include_plotlyjs=True, div_id="roc")
    return f"<h2>ROC</h2>{drawn}"
