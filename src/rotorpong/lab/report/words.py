"""Numbers, words and small pieces of HTML that the page is put together from."""

from collections.abc import Iterable, Sequence
from html import escape

KINDS = {
    "hit": "The ball touches the front of the blade, or its edge from the front.",
    "near_hit": "Closest approach under 5 cm, or the blade is there within 100 ms of the ball.",
    "hull": "The ball strikes the drone's body before the blade.",
    "unseen": "The eyes never found the ball, so the player never moved.",
    "fault": "The drone touched table, net or floor, or the player failed with an error.",
    "miss": "Anything else: the ball passes by.",
}


def spoken(kind: str) -> str:
    """Return the name of an outcome as one says it."""
    return kind.replace("_", " ")


def tag(name: str, content: str, **attributes: str) -> str:
    """Return an element; a trailing `_` of an attribute's name is dropped, `_` becomes `-`."""
    named = [(key.rstrip("_").replace("_", "-"), text) for key, text in attributes.items()]
    written = "".join(f' {key}="{escape(text)}"' for key, text in named)
    return f"<{name}{written}>{content}</{name}>"


def number(value: float | None, shown: str) -> str:
    """Return a number as text that also carries its exact value."""
    return "&ndash;" if value is None else tag("data", shown, value=repr(value))


def count(value: int) -> str:
    """Return a whole number."""
    return number(value, f"{value}")


def percentage(share: float | None) -> str:
    """Return a rate in percent, with its exact value."""
    return number(share, "" if share is None else f"{100 * share:.1f}&nbsp;%")


def interval(bounds: Sequence[float] | None) -> str:
    """Return a 95 % interval in percent."""
    if bounds is None:
        return "&ndash;"
    low, high = (number(bound, f"{100 * bound:.1f}") for bound in bounds)
    return f"{low}&ndash;{high}&nbsp;%"


def chance(p_value: float) -> str:
    """Return a probability in words."""
    shown = "less than 0.001" if p_value < 0.001 else f"{p_value:.3f}"
    return number(p_value, shown)


def table(heads: Sequence[str], rows: Iterable[Sequence[str]], caption: str) -> str:
    """Return a table; the first column names the row, all others hold numbers or words."""
    head = "".join(tag("th", cell, scope="col") for cell in heads)
    body = "".join(
        tag("tr", tag("th", first, scope="row") + "".join(tag("td", cell) for cell in rest))
        for first, *rest in rows
    )
    parts = tag("caption", caption) + tag("thead", tag("tr", head)) + tag("tbody", body)
    return tag("div", tag("table", parts), class_="scroll")


def figure(content: str, caption: str, name: str) -> str:
    """Return a figure with its caption."""
    inner = tag("div", content, class_="canvas") + tag("figcaption", caption)
    return tag("figure", inner, id=name)


def section(title: str, name: str, *parts: str) -> str:
    """Return a section with its heading."""
    return tag("section", tag("h2", title) + "".join(parts), id=name)


def paragraph(text: str, kind: str = "") -> str:
    """Return a paragraph."""
    return tag("p", text, class_=kind) if kind else tag("p", text)
