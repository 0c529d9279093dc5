# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The tables of docs/detection-limits.md, from the records of `limits_runs`.

An attack counts for a method that had not alarmed on the flight before its onset; the others are
dropped, and counted in `dropped`. It is found if the method alarms while it is followed: for up to
60 s, to the attack's end or the flight's, and earlier than it does without the attack.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence

from experiments.limits_records import (
    AttackRecord,
    FlightRecord,
    MethodRecord,
)
from experiments.limits_runs import by_half
from hijack_detect.evaluation.scores.evaluation_tables import NONE, TextTable, proportion, rate
from hijack_detect.evaluation.scores.metrics import Proportion, Rate, Spread, roc_area
from hijack_detect.evaluation.trials.families import CLEAN

MINUTE_BLOCKS = 6
"""Pieces of clean time in a minute."""
FUSED = "fusion"

Records = Sequence[FlightRecord]


def methods(records: Records) -> list[str]:
    """Every method with a verdict, the fusion last."""
    names = {name for record in records for name in record.blocks}
    return [*sorted(names - {FUSED}), FUSED]


def attacks(records: Records, families: Iterable[str] = ()) -> list[AttackRecord]:
    """All attacks, or those of some families."""
    wanted = set(families)
    found = [attack for record in records for attack in record.attacks]
    return [one for one in found if (one.family in wanted if wanted else one.family != CLEAN)]


def counted(found: Iterable[AttackRecord], method: str) -> list[MethodRecord]:
    """Records of a method of the attacks that count for it."""
    records = [one.methods[method] for one in found if method in one.methods]
    return [one for one in records if one.before_s is None]


def detected(found: Iterable[AttackRecord], method: str) -> Proportion:
    """Attacks that a method found."""
    records = counted(found, method)
    return Proportion.of(sum(one.alarm_s is not None for one in records), len(records))


def clean_minutes(records: Records, method: str) -> list[float]:
    """The largest margin of a method in each minute of clean time."""
    minutes = []
    for record in records:
        blocks = record.blocks.get(method, [])
        for begin in range(0, len(blocks), MINUTE_BLOCKS):
            piece = blocks[begin : begin + MINUTE_BLOCKS]
            if len(piece) >= MINUTE_BLOCKS // 2:
                minutes.append(max(piece))
    return minutes


def sizes(records: Records, *families: str) -> TextTable:
    """Detection, time to detect and deviation of families, a row for each size and half."""
    names = methods(records)
    rows = []
    for half, own in _halves(records).items():
        groups: dict[tuple[str, str], list[AttackRecord]] = {}
        for one in attacks(own, families):
            groups.setdefault((one.family, one.size), []).append(one)
        rows += [
            (family, size, half, *(_cell(group, name) for name in names))
            for (family, size), group in sorted(groups.items(), key=lambda item: item[0][0])
        ]
    return TextTable("Detection", ("attack", "size", "half", *names), tuple(rows))


def grid(records: Records, method: str = FUSED, family: str = "drift") -> TextTable:
    """Detection over onset acceleration (rows) and final speed (columns), for one method."""
    found = [one for one in attacks(records, [family]) if one.figures.get("speed")]
    speeds = sorted({one.figures["speed"] for one in found})
    gains = sorted({one.figures["acceleration"] for one in found})
    columns = [(speed, half) for speed in speeds for half in _halves(records)]
    cells = {
        (half, one.figures["speed"], one.figures["acceleration"]): [
            other for other in attacks(own, [family]) if other.figures == one.figures
        ]
        for half, own in _halves(records).items()
        for one in found
    }
    rows = [
        (
            f"{gain:g} m/s²",
            *(_cell(cells.get((half, speed, gain), []), method) for speed, half in columns),
        )
        for gain in gains
    ]
    head = (f"{speed:g} m/s {half}".strip() for speed, half in columns)
    return TextTable("Detection", ("acceleration", *head), tuple(rows))


def each(records: Records) -> TextTable:
    """When each method alarmed on each attacked flight, and the largest margin."""
    names = methods(records)
    rows = [
        (record.name, half, one.family, one.size, *(_outcome(one.methods[name]) for name in names))
        for half, own in _halves(records).items()
        for record in own
        for one in record.attacks
    ]
    return TextTable("Attacks", ("flight", "half", "attack", "size", *names), tuple(rows))


def clean(records: Records) -> TextTable:
    """False alarms and the largest margin of each method, by flight, or by class of many."""
    names = methods(records)
    if len(records) > 40:
        groups: dict[tuple[str, str], list[FlightRecord]] = {}
        for record in records:
            groups.setdefault((record.kind, ""), []).append(record)
    else:
        groups = {(one.name, half): [one] for half, own in _halves(records).items() for one in own}
    rows = [
        (*key, f"{sum(one.clean_s for one in own) / 3600.0:.2f}", *_false(own, names))
        for key, own in groups.items()
    ]
    for half, own in _halves(records).items():
        hours = sum(one.clean_s for one in own) / 3600.0
        text = (
            rate(Rate.of(sum(len(one.alarms.get(name, ())) for one in own), hours))
            for name in names
        )
        rows.append((f"all: alarms/h {half}".strip(), half, f"{hours:.2f}", *text))
    return TextTable("Clean time", ("flight", "half", "hours", *names), tuple(rows))


def type_1(records: Records) -> TextTable:
    """Clean flights with an alarm, by class, and their false alarms per hour."""
    quiet = [one for one in records if not one.attacks]
    kinds = dict.fromkeys(one.kind for one in quiet)
    groups = {kind: [one for one in quiet if one.kind == kind] for kind in kinds} | {"all": quiet}
    names = methods(quiet)
    rows = []
    for kind, own in groups.items():
        hours = sum(one.clean_s for one in own) / 3600.0
        cells = []
        for name in names:
            wrong = [len(one.alarms.get(name, ())) for one in own]
            part = proportion(Proportion.of(sum(map(bool, wrong)), len(own)))
            cells.append(f"{part}\n{rate(Rate.of(sum(wrong), hours))}/h")
        rows.append((kind, *cells))
    return TextTable("Type I", ("class", *names), tuple(rows))


def roc(records: Records) -> TextTable:
    """How separable attacks and clean minutes are, and what the largest clean margin would find."""
    rows = []
    for half, own in _halves(records).items():
        for name in methods(records):
            minutes = clean_minutes(own, name)
            scores = [one.margins[-1] for one in counted(attacks(own), name)]
            area = roc_area(minutes, scores)
            largest = max(minutes, default=0.0)
            above = Proportion.of(sum(score > largest for score in scores), len(scores))
            rows.append(
                (
                    name,
                    half,
                    str(len(minutes)),
                    NONE if area is None else f"{area:.3f}",
                    f"{largest:.2f}",
                    proportion(above),
                )
            )
    columns = (
        "method",
        "half",
        "clean minutes",
        "area",
        "largest clean margin",
        "attacks above it",
    )
    return TextTable("ROC", columns, tuple(rows))


def misses(records: Records) -> TextTable:
    """Attacks that the fusion did not find, by size, and the margin that came closest."""
    groups: dict[tuple[str, str], list[tuple[str, AttackRecord]]] = {}
    for record in records:
        for one in record.attacks:
            if one.family != CLEAN and one.methods[FUSED].before_s is None:
                groups.setdefault((one.family, one.size), []).append((record.name, one))
    rows = []
    for (family, size), group in groups.items():
        missed = [(name, one) for name, one in group if one.methods[FUSED].alarm_s is None]
        if not missed:
            continue
        flights: dict[str, int] = {}
        for name, _ in missed:
            flights[name] = flights.get(name, 0) + 1
        many = f"{len(flights)} flights"
        counts = ", ".join(f"{name} {count}" for name, count in flights.items())
        best = [_closest(one) for _, one in missed]
        low, high = min(best), max(best)
        rows.append(
            (
                family,
                size,
                f"{len(missed)}/{len(group)}",
                counts if len(flights) <= 8 else many,
                f"{low[0]:.2f} ({low[1]}) to {high[0]:.2f} ({high[1]})",
            )
        )
    columns = ("attack", "size", "missed", "where", "largest margin of any detector")
    return TextTable("Misses", columns, tuple(rows))


def dropped(records: Records) -> TextTable:
    """Attacks that do not count, because the method had alarmed before, by flight."""
    names = methods(records)
    rows = []
    for half, own in _halves(records).items():
        for record in own:
            total = attacks([record])
            if total:
                cells = (str(len(total) - len(counted(total, name))) for name in names)
                rows.append((record.name, half, str(len(total)), *cells))
    return TextTable("Dropped", ("flight", "half", "attacks", *names), tuple(rows))


KINDS: Mapping[str, Callable[..., TextTable]] = {
    "sizes": sizes,
    "grid": grid,
    "each": each,
    "clean": clean,
    "type_1": type_1,
    "roc": roc,
    "misses": misses,
    "dropped": dropped,
}
"""Makers of the tables by the second word of a mark; further words are their arguments."""


def _halves(records: Records) -> dict[str, list[FlightRecord]]:
    """Real flights in halves; simulated ones together, as no threshold was chosen on them."""
    return {"": list(records)} if len(records) > 40 else by_half(records)


def _cell(found: Sequence[AttackRecord], method: str) -> str:
    """Found of how many with the interval; median seconds and metres."""
    records = counted(found, method)
    if not records:
        return NONE
    times = Spread.of([one.alarm_s for one in records if one.alarm_s is not None])
    metres = Spread.of([one.separation_m for one in records if one.separation_m is not None])
    text = proportion(detected(found, method))
    if times is not None:
        text += f"\n{times.median:.1f} s"
    return text if metres is None else f"{text}, {metres.median:.0f} m"


def _outcome(one: MethodRecord) -> str:
    margin = f"({one.margins[-1]:.2f})"
    if one.before_s is not None:
        return f"early {margin}"
    if one.alarm_s is None:
        return f"missed {margin}"
    metres = "" if one.separation_m is None else f", {one.separation_m:.0f} m"
    return f"{one.alarm_s:.1f} s{metres} {margin}"


def _false(records: Records, names: Sequence[str]) -> list[str]:
    """Episodes of alarms, and the largest margin in brackets."""
    return [
        f"{sum(len(one.alarms.get(name, ())) for one in records)} "
        f"({max((max(one.blocks.get(name) or [0.0]) for one in records), default=0.0):.2f})"
        for name in names
    ]


def _closest(one: AttackRecord) -> tuple[float, str]:
    """The largest margin of any detector, and whose it was."""
    records = [(method.margins[-1], name) for name, method in one.methods.items() if name != FUSED]
    return max(records, default=(0.0, NONE))
