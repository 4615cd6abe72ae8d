"""The report as one HTML file that asks nothing of any network.

Every number comes from the results that are also in results.json and carries its exact value in a
`data` element. Light or dark as the reader's system is, narrow or wide, printable.
"""

from collections import Counter
from collections.abc import Sequence
from html import escape
from pathlib import Path
from typing import Any

from rotorpong.lab.footage import Take
from rotorpong.lab.report import figures
from rotorpong.lab.report.film import FilmFrame, poster
from rotorpong.lab.report.words import (
    KINDS,
    chance,
    count,
    figure,
    interval,
    number,
    paragraph,
    percentage,
    section,
    spoken,
    table,
    tag,
)
from rotorpong.lab.statistics import rate, wilson_interval

GENERATOR = '<meta name="generator" content="rotorpong">'
STYLESHEET = Path(__file__).with_name("page.css")
TITLE = "A quadrotor learns to hit table-tennis balls that it sees"
BLOCKS = 6  # rows of the table below the learning curve
STEP = 10  # balls to which a block is rounded
SURE, LIKELY = 0.01, 0.05


def report_page(
    found: dict[str, Any], shown: Take, frames: Sequence[FilmFrame], examples: Sequence[Take]
) -> str:
    """Return the whole page.

    Args:
        found: the content of results.json.
        shown: the serve of the film strip and of the figures in space.
        frames: the film strip.
        examples: a miss of each kind.
    """
    body = [
        _header(found, poster(shown)),
        _rates(found),
        _curve(found),
        _film(found, frames),
        _paths(found, shown),
        _misses(found, (shown, *examples)),
        _sources(found),
        _onward(found),
        _settings(found),
    ]
    head = f'<meta charset="utf-8">{GENERATOR}{VIEWPORT}{tag("title", TITLE)}'
    style = tag("style", STYLESHEET.read_text("utf-8"))
    main = tag("main", "\n".join(body))
    html = tag("head", head + style) + "\n" + tag("body", main)
    return "<!DOCTYPE html>\n" + tag("html", html, lang="en") + "\n"


VIEWPORT = '<meta name="viewport" content="width=device-width, initial-scale=1">'


def _header(found: dict[str, Any], frame: FilmFrame) -> str:
    _, before, after = found["players"]
    training, shown = found["training"], found["demonstrations"]
    story = (
        "A simulated quadrotor carries a cardboard racket and looks through one forward camera. "
        "Somebody throws table-tennis balls at it, over the net and with one bounce; it has less "
        "than a second for each. It knew "
        f"{count(shown['kept'])} hits that a scripted pilot had shown it, then played "
        f"{count(training['balls'])} balls by itself and learnt from the "
        f"{count(training['hits'])} that it hit. On the same {count(after['balls'])} test balls, "
        f"its hit rate was {percentage(before['hit_rate'])} before and "
        f"{percentage(after['hit_rate'])} after."
    )
    words = tag("h1", TITLE) + paragraph(story, "story") + paragraph(_verdict(found), "verdict")
    caption = "What the drone sees. The circle is the ball as its own eyes found it."
    picture = tag("figure", _image(frame, "A frame of the onboard camera, the ball circled"))
    picture = picture.replace("</figure>", tag("figcaption", caption) + "</figure>")
    return tag("header", tag("div", words) + picture)


def _verdict(found: dict[str, Any]) -> str:
    pair = found["comparison"]
    won, lost, p_value = pair["won"], pair["lost"], pair["p_value"]
    counts = (
        f"{count(won)} balls missed before were hit after training, {count(lost)} the other way "
        f"round (chance of so uneven a change without learning: {chance(p_value)})."
    )
    if p_value >= LIKELY:
        return "In this run, the difference may be chance: " + counts
    if won < lost:
        return "In this run, training made the player worse: " + counts
    return ("Learning helped: " if p_value < SURE else "Learning probably helped: ") + counts


def _rates(found: dict[str, Any]) -> str:
    players = found["players"]
    scale = max(0.1, 1.1 * max(player["hit_rate_interval"][1] for player in players))
    cards = "".join(_card(player, scale) for player in players)
    note = (
        f"Dot: hits over balls. Bar: Wilson's 95&nbsp;% interval, on one scale from 0 to "
        f"{100 * scale:.0f}&nbsp;%. Everyone met the same balls."
    )
    rows = [
        (
            escape(player["label"]),
            count(player["hits"]),
            count(player["balls"]),
            percentage(player["hit_rate"]),
            interval(player["hit_rate_interval"]),
            _centimetres(player["miss_distance_median_m"]),
        )
        for player in players
    ]
    heads = ("player", "hits", "balls", "hit rate", "95&nbsp;% interval", "median miss")
    numbers = table(heads, rows, "Hit rates; the median miss is over the balls that were not hit.")
    drawn = figure(tag("div", cards, class_="cards"), note, "rates")
    return section("Before and after", "result", drawn, numbers)


def _card(player: dict[str, Any], scale: float) -> str:
    low, high = player["hit_rate_interval"]
    bar = f"left:{100 * low / scale:.2f}%;width:{100 * (high - low) / scale:.2f}%"
    dot = f"left:{100 * player['hit_rate'] / scale:.2f}%"
    inside = tag("i", "", class_="bar", style=bar) + tag("i", "", class_="dot", style=dot)
    says = (
        f"{player['label']}: {100 * player['hit_rate']:.1f} percent, "
        f"interval {100 * low:.1f} to {100 * high:.1f} percent"
    )
    parts = [
        tag("h3", escape(player["label"])),
        paragraph(escape(player["knows"])),
        paragraph(percentage(player["hit_rate"]), "big"),
        tag("div", inside, class_="track", role="img", aria_label=says),
        paragraph(
            f"{count(player['hits'])} of {count(player['balls'])} balls, "
            f"{interval(player['hit_rate_interval'])}"
        ),
    ]
    return tag("div", "".join(parts), class_=f"card {player['name']}")


def _curve(found: dict[str, Any]) -> str:
    caption = (
        "Hit rate of the last balls while it trains (line, with its 95&nbsp;% interval; short "
        "strokes are hits), and evaluated without exploration before (square) and after (circle). "
        "In training it varies its hitting points on purpose, which costs hits: the line may lie "
        "below the circle. Grey: a drone that only hovers."
    )
    heads = ("balls", "hits", "hit rate", "95&nbsp;% interval")
    numbers = table(heads, _blocks(found["training"]["outcomes"]), "The training in blocks.")
    drawn = figure(figures.learning_curve(found), caption, "learning-curve")
    return section("Learning", "learning", tag("div", drawn + numbers, class_="beside"))


def _blocks(outcomes: Sequence[str]) -> list[tuple[str, ...]]:
    size = max(STEP * -(-len(outcomes) // (STEP * BLOCKS)), 1)
    rows = []
    for start in range(0, len(outcomes), size):
        part = outcomes[start : start + size]
        hits = list(part).count("hit")
        share = percentage(rate(hits, len(part))), interval(wilson_interval(hits, len(part)))
        rows.append((f"{start + 1}&ndash;{start + len(part)}", count(hits), *share))
    return rows


def _film(found: dict[str, Any], frames: Sequence[FilmFrame]) -> str:
    shown = found["shown"]
    is_hit = shown["outcome"] == "hit"
    title = "A hit, through the drone's eyes" if is_hit else "The nearest miss, through its eyes"
    strip = tag("ol", "".join(_film_frame(frame) for frame in frames), class_="strip")
    time = shown["contact_time_s"]
    hit = f"The blade meets it {number(time, _seconds(time))} after the release."
    miss = f"It is missed by {_centimetres(shown['miss_distance_m'])}."
    caption = (
        f"Ball {count(shown['index'])} of the evaluation after training. Magenta: the ball as the "
        "eyes find it, enlarged in the corner, and how far away they take it to be; in brackets "
        "the truth, which the player never gets. (These eyes see far balls too small, so too far "
        "away, as the paper's do.) It looks until they have the ball within the 2.5 m plane "
        "(yellow), then flies its motion without looking; the later circles are what its eyes "
        "would find. " + (hit if is_hit else miss)
    )
    return section(title, "film", figure(strip, caption, "film-strip"))


def _film_frame(frame: FilmFrame) -> str:
    distance = frame.estimated_distance
    if distance is None:
        seen, alt = "not located", "the ball is not located"
    else:
        seen = number(distance, f"{distance:.2f} m")
        alt = f"the ball located {distance:.2f} m away"
    truth = f"({number(frame.true_distance, f'{frame.true_distance:.2f}')})"
    time = tag("b", number(frame.time, _seconds(frame.time)))
    words = f"{time} {seen} {truth}" + (" trigger" if frame.is_trigger else "")
    image = _image(frame, f"Onboard frame at {frame.time:.2f} s, {alt}")
    kind = "trigger" if frame.is_trigger else "frame"
    return tag("li", image + tag("span", words), class_=kind)


def _paths(found: dict[str, Any], shown: Take) -> str:
    end = "meet it at the star" if shown.played.outcome == "hit" else "meet it, in vain"
    space = figure(
        figures.paths_in_space(shown),
        "The same serve in the court: the ball (orange, a dot each 0.1 s) comes over the net and "
        f"bounces; the drone leaves its place (pale) for the blade (blue) to {end}.",
        "paths-in-space",
    )
    side = figure(figures.paths_from_the_side(shown), _side_caption(found), "paths-from-the-side")
    return section("Where ball and blade went", "paths", space, side)


def _side_caption(found: dict[str, Any]) -> str:
    time, depth = found["shown"]["trigger_time_s"], found["shown"]["trigger_depth_m"]
    words = "From the side and from above. Dashed: the plane 2.5 m before the camera. "
    if time is None:
        return words + "The eyes never had the ball within it."
    return words + (
        "Ring: where the ball really was when it set the player going, "
        f"{number(time, _seconds(time))} after the release; the eyes took it to be "
        f"{number(depth, f'{depth:.2f} m')} before the camera."
    )


def _misses(found: dict[str, Any], takes: Sequence[Take]) -> str:
    players = found["players"]
    counts = [Counter(player["outcomes"]) for player in players]
    bars = "".join(_stack(p, some) for p, some in zip(players, counts, strict=True))
    stacked = figure(
        tag("div", bars, class_="stacks"),
        "What became of every ball. Each bar is all balls of an evaluation, cut by kind; learning "
        "shows as a wider first part.",
        "outcomes",
    )
    rows = [
        (
            f'<i class="key {kind}"></i>{spoken(kind)}',
            *(count(some[kind]) for some in counts),
            words,
        )
        for kind, words in KINDS.items()
    ]
    heads = ("kind", *(escape(player["label"]) for player in players), "what it means")
    numbers = table(heads, rows, "Balls by what became of them.")
    panels = figure(
        figures.passes(takes),
        "One of each kind after training, as seen from behind the drone: the way of the ball "
        "(orange) relative to the blade (blue) and the hull (grey), both drawn level; the disc is "
        "the ball in the blade's plane, a star where it strikes the hull.",
        "passes",
    )
    return section("Hits and misses by kind", "misses", stacked, numbers, panels)


def _stack(player: dict[str, Any], counts: Counter[str]) -> str:
    parts = [
        tag(
            "span",
            f"{counts[kind]}" if counts[kind] >= 0.04 * player["balls"] else "",
            class_=kind,
            style=f"width:{100 * counts[kind] / player['balls']:.2f}%",
        )
        for kind in KINDS
        if counts[kind]
    ]
    says = ", ".join(f"{counts[kind]} {spoken(kind)}" for kind in KINDS if counts[kind])
    label = tag("b", escape(player["label"]))
    return label + tag("div", "".join(parts), class_="stack", role="img", aria_label=says)


def _sources(found: dict[str, Any]) -> str:
    shown, training = found["demonstrations"], found["training"]
    return section(
        "What it learnt from",
        "sources",
        paragraph(
            f"{count(shown['kept'])} demonstrations by a <b>{escape(shown['pilot'])} pilot</b>: a "
            "program with a person's handicaps. It sees the onboard picture and the instruments "
            "0.2 s late, moves its sticks at most every 0.1 s, and is off by a tenth. It needed "
            f"{count(shown['balls'])} balls for these hits. No person flew, and nobody handed the "
            "learner the truth: it learns from its camera, its navigation data, its own commands, "
            "and a touch sensor in the blade."
        ),
        paragraph(
            f"Then {count(training['hits'])} own hits out of {count(training['balls'])} balls, "
            "each kept with what was tried. A hit in the middle of the blade counts for more. From "
            "these it estimates where, how fast and when to meet a ball (cost-regularised kernel "
            "regression) and how to mix the demonstrated motions (a mixture of motor primitives, "
            "weighed by Bayesian linear regression), as in the paper by Silva, Melo and Veloso "
            "(IROS 2015)."
        ),
    )


def _onward(found: dict[str, Any]) -> str:
    seed, after = found["seed"], found["players"][2]
    commands = [
        (
            f"rotorpong evaluate --experience experience.sqlite --balls {after['balls']} "
            f"--seed {seed}",
            "play the evaluation after training again, with the file beside this page",
        ),
        ("rotorpong evaluate --blackout --balls 200", "blind it, and it only hovers"),
        ("rotorpong evaluate --eyes truth --balls 200", "how much better eyes would be worth"),
        ("rotorpong train --hits 170 --out longer.sqlite", "train as long as the paper did"),
        ("rotorpong evaluate --player my_player.py:Mine", "let a player of your own try"),
        ("rotorpong serves stats", "what these balls are like for the camera"),
    ]
    items = "".join(tag("dt", tag("code", line)) + tag("dd", words) for line, words in commands)
    hint = "In a checkout, the command is <code>.venv/bin/rotorpong</code>."
    return section("Go on from here", "onward", tag("dl", items), paragraph(hint, "quiet"))


def _settings(found: dict[str, Any]) -> str:
    rows = [(key, escape(str(value))) for key, value in found["setting"].items()]
    rows += [("seed", count(found["seed"])), ("rotorpong", escape(found["rotorpong"]))]
    numbers = table(("setting", "value"), rows, "Everything that decides these numbers.")
    again = paragraph(
        f"Made by <code>{escape(found['command'])}</code>; the same command gives the same "
        "numbers. They are also in <code>results.json</code>."
    )
    return section("Settings", "settings", again, numbers)


def _image(frame: FilmFrame, alt: str) -> str:
    size = f'width="{frame.width}" height="{frame.height}"'
    return f'<img src="{frame.jpeg}" {size} alt="{escape(alt)}">'


def _seconds(time: float | None) -> str:
    return "" if time is None else f"{time:.2f} s"


def _centimetres(metres: float | None) -> str:
    return number(metres, "" if metres is None else f"{100 * metres:.1f} cm")
