"""One file of measurements on the page: how it is read, what it holds, what is odd about it."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from dash import dcc, html
from dash.development.base_component import Component

from elastic_tendon.actuator.motion_kind import MotionKind
from elastic_tendon.app.document import Source
from elastic_tendon.app.figures import GESTURES, saveable
from elastic_tendon.app.mapping import BY_NAME, DECLARE, Row, in_app_words, rows_of, shifted, words
from elastic_tendon.app.numbers import with_minus
from elastic_tendon.app.offers import Offer, advised, guessed, missing_in_words
from elastic_tendon.app.preview import COLUMNS, Beginning
from elastic_tendon.app.results import split_up
from elastic_tendon.app.tables import scrolling
from elastic_tendon.app.workspace import Failure
from elastic_tendon.errors import MeasurementError
from elastic_tendon.measurement import Measurement
from elastic_tendon.measurement.recording import samples_text
from elastic_tendon.reports.interactive.preview import preview
from elastic_tendon.reports.interactive.theme import Theme
from elastic_tendon.reports.units import noise_in_words, number, shown
from elastic_tendon.reports.worded import worded_plotly

ROLES = {
    "fit": "fit",
    "validate": "validate (never fitted)",
    "split": "split at a time",
    "off": "left out",
}
INTERPOLATIONS = {
    "auto": "as their spectra show",
    "linear": "straight lines",
    "cubic": "smooth curves",
    "hold": "steps",
}
PLAIN: Any = GESTURES | {"displayModeBar": False}
HEIGHT = 260  # of the preview, pixels
MOST_NOTES = 12

Found = tuple[Measurement, ...] | Failure | None


@dataclass(frozen=True)
class Seen:
    """What is known of a source: its columns, its recordings as read, and as checked.

    `modelled` : whether the model that is looked at turns or slides.
    """

    source: Source
    labels: tuple[str, ...] | Failure | None
    read: Found
    checked: Found
    beginnings: tuple[Beginning, ...] = ()
    modelled: MotionKind = MotionKind.ROTARY

    @property
    def columns(self) -> tuple[str, ...]:
        """Columns of the file, as far as they are known."""
        return self.labels if isinstance(self.labels, tuple) else ()

    @property
    def recordings(self) -> tuple[Measurement, ...]:
        """The recordings, checked where they were."""
        for measurements in (self.checked, self.read):
            if isinstance(measurements, tuple):
                return measurements
        return ()

    @property
    def first(self) -> Measurement | None:
        """The first recording, None where the file could not be read."""
        return next(iter(self.recordings), None)

    @property
    def motion(self) -> MotionKind:
        """Whether what was recorded turns or slides; where no unit tells, as the model."""
        told = None if self.first is None else self.first.motion
        return self.modelled if told is None else told

    def rows(self) -> tuple[Row, ...]:
        """Which column is which signal."""
        return rows_of(self.source, self.columns, self.first, self.motion)

    def sentence(self) -> str:
        """Why the file cannot be used as it is read, "" where it can."""
        for result in (self.labels, self.read, self.checked):
            if isinstance(result, Failure):
                return result.sentence
        try:
            for recording in self.recordings:
                split_up(self.source, recording)
        except MeasurementError as error:
            return str(error)
        return ""

    def fault(self) -> str:
        """The same in words of the page; all signals that are missing at once."""
        sentence = self.sentence()
        if "there is no column" in sentence:
            sentence = missing_in_words(self.source, self.columns) or sentence
        return in_app_words(sentence)

    def offers(self) -> tuple[Offer, ...]:
        """What one button would put right."""
        sentence = self.sentence()
        if not sentence:
            return ()
        guess = guessed(self.source, self.columns)
        return guess or advised(sentence, self.columns)


@dataclass
class Form:
    """Fields of the page: what each shows, by its name in the browser, and what else they are.

    Where both are as on the page already, the fields there can stay: someone may be typing in one.
    """

    shown: dict[str, Any] = field(default_factory=dict)
    structure: list[Any] = field(default_factory=list)

    def place(self, key: str, name: str, value: Any, signal: str = "") -> dict[str, str]:
        """Id of a field of a source; what it shows is noted."""
        place = {"data-field": name, "key": key, "signal": signal}
        self.shown[dom_id(place)] = value
        self.structure.append(dom_id(place))
        return place

    def text(self, key: str, name: str, value: str, signal: str = "", **props: Any) -> dcc.Input:
        """A field for a number."""
        place = self.place(key, name, value, signal)
        return dcc.Input(
            id=place,
            value=value,
            type="text",
            autoComplete="off",
            debounce=True,
            **props,
        )

    def choice(
        self, key: str, name: str, value: str | None, options: Any, signal: str = "", **props: Any
    ) -> dcc.Dropdown:
        """A list to choose from."""
        place = self.place(key, name, value, signal)
        self.structure.append(options)
        return dcc.Dropdown(options, value, id=place, clearable=False, **props)

    @staticmethod
    def of_signal(signal: str, name: str, control: Any) -> html.Label:
        """A field of a table, told by name to readers of the screen, whom no heads help.

        `signal` : in words.
        """
        label = f"{name}, {signal}"
        place = f"{dom_id(control.id)}-value-count"  # by which Dash names a list
        return html.Label([html.Span(label, id=place, className="unseen"), control])


def dom_id(place: Mapping[str, str]) -> str:
    """How the browser calls a component whose id is a table."""
    return json.dumps(place, sort_keys=True, separators=(",", ":"))


def card(seen: Seen, form: Form) -> html.Article:
    """The fields of one file, and places for what is shown of it."""
    source = seen.source
    key = source.key
    form.structure.append((key, source.name))
    can_be_read = not isinstance(seen.labels, Failure)
    fields = html.Div([_mapping(seen, form), _advanced(seen, form)]) if can_be_read else html.Div()
    return html.Article(
        [
            html.Div(
                [
                    html.H3(source.name),
                    html.Span(id={"data-facts": key}, className="quiet"),
                    html.Button(
                        "Remove", id={"data-remove": key}, className="plain", title=source.name
                    ),
                ],
                className="row name",
            ),
            html.P(id={"data-wrong": key}, className="sentence", role="alert"),
            *_offered(seen, form),
            *_declared(seen, form),
            *([_use(seen, form)] if can_be_read else []),
            html.P(id={"data-refused": key}, className="sentence", role="alert"),
            html.Div([fields, html.Div(id={"data-found": key})], className="sides"),
        ],
        className="card source",
    )


def overview(seen: Seen, theme: Theme) -> list[Component]:
    """A look at what was read, and what is worth knowing of it; else at what stands in the file."""
    if seen.first is None and isinstance(seen.read, Failure):
        return _preview(seen.beginnings)
    return [*_figure(seen, theme), *_quality(seen)]


def _preview(beginnings: Sequence[Beginning]) -> list[Component]:
    if not any(beginning.values for beginning in beginnings):
        return []
    head = html.Thead(
        html.Tr(
            [
                html.Th("column of the file", scope="col"),
                html.Th(
                    "first values", scope="col", colSpan=max(len(b.values) for b in beginnings)
                ),
            ]
        )
    )
    rows = [
        html.Tr(
            [
                html.Th(beginning.label, scope="row"),
                *(html.Td(with_minus(value), className="figure") for value in beginning.values),
            ]
        )
        for beginning in beginnings
    ]
    more = [html.P(f"The first {COLUMNS} columns.", className="quiet")]
    return [
        scrolling(html.Table([head, html.Tbody(rows)]), "preview"),
        *(more if len(beginnings) >= COLUMNS else []),
    ]


def facts(seen: Seen) -> str:
    """How much was read."""
    read = seen.recordings
    if not read:
        return "" if seen.sentence() else "is being read…"
    samples = sum(len(recording.time) for recording in read)
    counted = samples_text(samples)
    pieces = "" if len(read) == 1 else f" in {len(read)} recordings"
    if read[0].static:
        return f"a static curve of {counted}"
    seconds = sum(float(recording.time[-1] - recording.time[0]) for recording in read)
    rate = 1.0 / float(np.median(np.diff(read[0].time)))
    return f"{counted}{pieces}, {number(seconds)} s at {number(rate)} Hz"


def _offered(seen: Seen, form: Form) -> list[Component]:
    """A button for each way to read the file right that is known."""
    key = seen.source.key
    offers = seen.offers()
    form.structure.append([(offer.button, offer.words) for offer in offers])
    return [
        html.Div(
            [
                html.Button(offer.button, id={"data-offer": key, "index": index}),
                html.Span(offer.words),
            ],
            className="row offer",
        )
        for index, offer in enumerate(offers)
    ]


def _declared(seen: Seen, form: Form) -> list[Component]:
    """A way to insist, where the data look read wrongly."""
    source = seen.source
    if not (source.options.as_declared or seen.sentence().endswith(DECLARE)):
        return []
    value = ["yes"] if source.options.as_declared else []
    place = form.place(source.key, "as_declared", value)
    label = "The file is right: take it as declared"
    return [dcc.Checklist([{"value": "yes", "label": label}], value, id=place)]


def _use(seen: Seen, form: Form) -> html.Div:
    """Whether the data are fitted or validate, and which part of them is read."""
    source = seen.source
    role = form.place(source.key, "role", source.role)
    static = seen.first is not None and seen.first.static
    roles = [
        {"value": name, "label": label}
        for name, label in ROLES.items()
        if name != "split" or not static  # without a time
    ]
    form.structure.append(roles)
    start, end = (("" if end is None else f"{end:.9g}") for end in source.window)
    parts: list[Component] = [
        dcc.RadioItems(
            roles,
            source.role,
            id=role,
            inline=True,
        )
    ]
    if source.role == "split":
        at = "" if source.split is None else f"{source.split:.9g}"
        parts.append(_labelled("fitted before", form.text(source.key, "split", at), "s"))
    if not static:
        parts += [
            _labelled("read from", form.text(source.key, "start", start), "s"),
            _labelled("to", form.text(source.key, "end", end), "s"),
        ]
    return html.Div(parts, className="row use")


def _labelled(before: str, control: Component, unit: str = "") -> html.Label:
    return html.Label([before, control, unit])


# ---- how it is read ------------------------------------------------------------------------


def _mapping(seen: Seen, form: Form) -> html.Div:
    heads = ("signal", "column of the file", "unit", "times", "plus")
    head = html.Thead(html.Tr([html.Th(title, scope="col") for title in heads]))
    rows = [_mapping_row(seen, row, form) for row in seen.rows()]
    return html.Div(html.Table([head, html.Tbody(rows)]), className="mapping")


def _mapping_row(seen: Seen, row: Row, form: Form) -> html.Tr:
    key, signal = seen.source.key, row.signal
    columns = list(seen.columns)
    if row.column is not None and row.column not in columns:
        columns.append(row.column)
    options = [{"value": name, "label": name} for name in columns]
    options.insert(0, {"value": BY_NAME, "label": "found by its name"})
    empty = "by its name" if seen.first is None else "not there"
    column = form.choice(key, "column", row.column, options, signal, placeholder=empty)
    name = row.motion.words(words(signal))
    cells: list[Any] = [form.of_signal(name, "column of the file", column), "", "", ""]
    if row.column is not None:
        unit = form.choice(key, "unit", row.unit, row.units(), signal, searchable=False)
        times = form.text(key, "times", with_minus(f"{row.times:.9g}"), signal)
        plus = form.text(key, "plus", with_minus(f"{row.plus:.6g}"), signal)
        cells[1:] = [
            form.of_signal(name, "unit", unit),
            form.of_signal(name, "times", times),
            html.Span([form.of_signal(name, "plus", plus), row.si], className="measure"),
        ]
    return html.Tr([html.Th(name, scope="row"), *(html.Td(cell) for cell in cells)])


def _advanced(seen: Seen, form: Form) -> html.Details:
    source = seen.source
    resample = "" if source.options.resample is None else f"{source.options.resample:.9g}"
    late = shifted(seen.first)
    zeroed = [name for name in late if name != "load_torque"]

    def told(signal: str) -> str:
        return seen.motion.words(words(signal))

    parts: list[Component] = [
        _labelled(
            "inputs between the samples:",
            form.choice(
                source.key,
                "interpolation",
                source.options.interpolation,
                [{"value": name, "label": label} for name, label in INTERPOLATIONS.items()],
                searchable=False,
            ),
        ),
        _labelled("resample, one every", form.text(source.key, "resample", resample), "s"),
    ]
    if zeroed:
        value = [name for name in zeroed if name in source.options.remove_offset]
        place = form.place(source.key, "remove_offset", value)
        options = [{"value": name, "label": told(name)} for name in zeroed]
        boxes = dcc.Checklist(options, value, id=place, inline=True)
        parts.append(html.Div(["begins at 0 by definition:", boxes], className="row"))
    for signal in late:
        shift = source.options.time_shift.get(signal, "")
        text = shift if isinstance(shift, str) else f"{shift:.9g}"
        control = form.text(source.key, "shift", text, signal, placeholder="0, or auto")
        parts.append(_labelled(f"{told(signal)} is late by", control, "s"))
    return html.Details([html.Summary("Advanced"), *parts])


# ---- what was found ------------------------------------------------------------------------


def _figure(seen: Seen, theme: Theme) -> list[Component]:
    first = seen.first
    if first is None:
        return []
    split = seen.source.split if seen.source.role == "split" else None
    margin = {"l": 56, "r": 8, "t": 46, "b": 40}
    drawn = preview(first, split=split, theme=theme, height=HEIGHT, margin=margin)
    figure = worded_plotly(drawn, seen.motion)
    several = [html.P(f"Shown: {first.name}", className="quiet")] if seen.recordings[1:] else []
    return [
        saveable(Path(first.name).stem, PLAIN, figure=figure, style={"height": HEIGHT}),
        *several,
    ]


def _quality(seen: Seen) -> list[Component]:
    items = [html.Li(sentence) for sentence in findings(seen)]
    return [html.Ul(items, className="findings")] if items else []


def findings(seen: Seen) -> list[str]:
    """What is worth knowing of the data, a sentence each."""
    first = seen.first
    if first is None:
        return []
    texts = [
        f"Noise of the {shown(name, static=first.static).words}: "
        f"{noise_in_words(noise, shown(name, static=first.static))}"
        for name, noise in (first.noise.items() if isinstance(seen.checked, tuple) else ())
    ]
    if first.load_torque is None and not first.static:
        texts.append("There is no load torque: none is taken to act.")
    if len(first.signals) == 1 and not first.static:
        texts.append("There is no measured torque: only the joint position tests the model.")
    if seen.checked is None and seen.source.role != "off" and not seen.sentence():
        texts.append("Checking units, signs and columns against the model…")
    return [*map(seen.motion.words, texts), *noted(seen.recordings)]


def noted(recordings: Sequence[Measurement]) -> list[str]:
    """Notes of all recordings, each once."""
    every = list(
        dict.fromkeys(in_app_words(note) for recording in recordings for note in recording.notes)
    )
    more = len(every) - MOST_NOTES
    return every[:MOST_NOTES] + ([f"and {more} more notes"] if more > 0 else [])
