"""Results as tables for a terminal; names may hold what rich would take for markup."""

from typing import Any

from rich.markup import escape
from rich.table import Table

from rotorpong.lab.control_settings import PAPERS_CONTROL
from rotorpong.lab.player_settings import USUAL

LEFT_OUT = {
    "never_at_plane": "never pass the blade, left out below",
    "never_in_picture": "never in the picture, left out of the last sight",
}


def percent(share: float | None, interval: tuple[float, float] | None = None) -> str:
    """Return a rate in words: `12.0 %`, with its interval `12.0 % (9.4-15.1)`."""
    if share is None:
        return "-"
    shown = f"{100 * share:.1f} %"
    if interval is None:
        return shown
    return f"{shown} ({100 * interval[0]:.1f}-{100 * interval[1]:.1f})"


def summary_table(result: dict[str, Any]) -> Table:
    """Show what `evaluate` found."""
    table = _two_columns(f"{result['player']} player, {result['eyes']} eyes")
    for what in ("vehicle", "camera", "serves", "seed", "balls"):
        table.add_row(what, escape(str(result[what])))
    if result["experience"] is not None:
        table.add_row("experience", escape(result["experience"]))
    for what, value in _unusual(result).items():
        table.add_row(_words(what), escape(value))
    table.add_row("hits", str(result["hits"]))
    table.add_row("hit rate (95 %)", percent(result["hit_rate"], result["hit_rate_interval"]))
    table.add_row("reachable", str(result["reachable"]))
    within = percent(result["hit_rate_of_reachable"], result["hit_rate_of_reachable_interval"])
    table.add_row("hit rate of reachable (95 %)", within)
    for outcome, count in sorted(_counts(result["trials"]).items()):
        table.add_row(outcome, str(count))
    median = result["miss_distance_median_m"]
    table.add_row("miss distance, median", "-" if median is None else f"{100 * median:.1f} cm")
    if result.get("skill") is not None:
        table.add_row("skill, from hover (0) to oracle (1)", f"{result['skill']:.2f}")
    for other in result.get("against", ()):
        split = f"{other['won']} won, {other['lost']} lost, p = {other['p_value']:.1g}"
        table.add_row(f"against {escape(other['file'])}", split)
    return table


def _unusual(result: dict[str, Any]) -> dict[str, str]:
    """Return what is not as usual."""
    found = {what: "yes" for what in ("blackout", "randomize") if result[what]}
    seen = {"ball": result["ball"], **result["eye_settings"], **result["player_settings"]}
    usual = {"ball": "orange", "colour": result["ball"], "circle_fit": "kasa", "diameter": "whole"}
    usual |= USUAL.as_json(result["player"]) | {"control": PAPERS_CONTROL}
    seen["control"] = result.get("control", PAPERS_CONTROL)
    return found | {what: _shown(value) for what, value in seen.items() if value != usual.get(what)}


def _words(key: str) -> str:
    """Return a key in words, its unit last: `plane distance, m`."""
    words = key.removesuffix("_m").replace("_", " ")
    return f"{words}, m" if key.endswith("_m") else words


def _shown(setting: Any) -> str:
    """Return a text, number or switch as a table shows it."""
    if isinstance(setting, bool):
        return "yes" if setting else "no"
    return setting if isinstance(setting, str) else f"{setting:g}"


def detection_table(result: dict[str, Any]) -> Table:
    """Show what `detect` found: the best ball of each picture, and its track if there are any."""
    linked = any("track" in ball for picture in result["pictures"] for ball in picture["balls"])
    table = Table(title="balls", title_justify="left")
    columns = ("picture", "frame", "balls", "x px", "y px", "diameter px", "score", "depth m")
    for column in (*columns, "track") if linked else columns:
        table.add_column(column, justify="left" if column == "picture" else "right")
    for picture in result["pictures"]:
        name = picture["path"].encode(errors="backslashreplace").decode()
        row = [escape(name), str(picture["frame"]), str(len(picture["balls"]))]
        table.add_row(*row, *_best(picture["balls"], linked=linked))
    return table


def conversion_table(result: dict[str, Any]) -> Table:
    """Show what `serves from-flight` made."""
    table = Table(title=escape(f"serves in {result['out']}"), title_justify="left")
    for column in ("flight", "points", "residual mm", "drag 1/m", "bounces", "left m", "up m"):
        table.add_column(column, justify="left" if column == "flight" else "right")
    for serve in result["serves"]:
        numbers = [f"{serve['residual_rms_mm']:.1f}", f"{serve['drag_per_m']:.3f}"]
        numbers += [str(serve["bounces"]), f"{serve['target_left_m']:.2f}"]
        numbers.append(f"{serve['target_up_m']:.2f}")
        table.add_row(escape(serve["flight"]), str(serve["points"]), *numbers)
    table.caption = (
        f"passed over: {result['files_passed_over']} files in another layout, "
        f"{result['flights_passed_over']} flights without a serve"
    )
    return table


def prediction_table(result: dict[str, Any]) -> Table:
    """Show how far off `predict` was: pooled, by what happened, and by flight."""
    window, ahead = result["window_s"], result["ahead_s"]
    title = f"{escape(result['path'])}: {ahead:g} s after {window:g} s of points"
    table = Table(title=title, title_justify="left")
    for column in ("error", "median cm", "90 % cm", "predictions"):
        table.add_column(column, justify="left" if column == "error" else "right")
    table.add_row("gravity only", *_errors(result["gravity_only"]))
    table.add_row("and drag", *_errors(result["drag_only"]))
    table.add_row("and spin: the flight filter", *_errors(result))
    for kind in ("free", "after_bounce", "over_bounce"):
        table.add_row(f"  {kind.replace('_', ' ')}", *_errors(result[kind]))
    if len(result["flights"]) > 1:
        for one in result["flights"]:
            table.add_row(escape(one["flight"]), *_errors(one))
    table.caption = (
        f"passed over: {result['files_passed_over']} files in another layout, "
        f"{result['flights_passed_over']} flights too short"
    )
    return table


def stats_table(result: dict[str, Any]) -> Table:
    """Show what `serves stats` found."""
    table = _two_columns(f"{result['balls']} serves {result['serves']}, camera {result['camera']}")
    for key, words in LEFT_OUT.items():
        if result[key]:
            table.add_row(words, str(result[key]))
    for key in ("flight_time_s", "time_after_plane_s", "last_sight_before_contact_s"):
        found = result[key]
        shown = " / ".join("-" if value is None else f"{value:.2f}" for value in found.values())
        table.add_row(f"{key[:-2].replace('_', ' ')}, s (5 / 50 / 95 %)", shown)
    table.add_row("share of the flight in the picture", percent(result["share_in_picture"]))
    table.add_row("in the picture at the plane", percent(result["share_in_picture_at_plane"]))
    interval = result["hover_hit_rate_interval"]
    table.add_row("hits of a hovering blade (95 %)", percent(result["hover_hit_rate"], interval))
    share = percent(result["share_reachable"], result["share_reachable_interval"])
    table.add_row(f"reachable for {escape(result['vehicle'])} (95 %)", share)
    return table


def camera_table(result: dict[str, Any]) -> Table:
    """Show what `calibrate camera` found."""
    table = _two_columns(f"camera {result['name']} in {result['out']}")
    table.add_row("picture, px", f"{result['width_px']} x {result['height_px']}")
    for what in ("used", "without_board", "unreadable"):
        table.add_row(f"pictures {what.replace('_', ' ')}", str(len(result[f"pictures_{what}"])))
    table.add_row("reprojection error, px (rms)", f"{result['reprojection_rms_px']:.3f}")
    for key in ("focal_length", "center"):
        pairs = zip(result[f"{key}_px"], result[f"{key}_sd_px"], strict=True)
        shown = ", ".join(f"{value:.2f} ± {sd:.2f}" for value, sd in pairs)
        table.add_row(f"{key.replace('_', ' ')} x, y, px", shown)
    distortion = zip(result["distortion"], result["distortion_sd"], strict=True)
    for name, (value, sd) in zip(("k1", "k2", "p1", "p2", "k3"), distortion, strict=True):
        shown = f"{value:.5f} ± {sd:.5f}" if sd else "0: not told by these boards"
        table.add_row(f"distortion {name}", shown)
    across, down = result["field_of_view_deg"]
    table.add_row("field of view", f"{across:.1f} x {down:.1f} degrees")
    return table


def colour_table(result: dict[str, Any]) -> Table:
    """Show what `calibrate colour` learnt."""
    table = _two_columns(f"colour {result['name']} in {result['out']}")
    for key in ("lower", "upper", "core", "typical"):
        table.add_row(f"{key}: hue, saturation, value", ", ".join(map(str, result[key])))
    if result["hue_cut"]:
        table.add_row("hues", "would wrap around 0, and end there")
    table.add_row("balls in pictures", f"{result['balls']} in {result['pictures']}")
    table.add_row("balls found with it", f"{result['balls_found']} of {result['balls']}")
    table.add_row("recall of the balls' pixels", percent(result["recall"]))
    taken, of = result["background_pixels_taken"], result["background_pixels"]
    table.add_row("background pixels taken", f"{taken} of {of} ({percent(taken / of)})")
    return table


def findings_table(result: dict[str, Any]) -> Table:
    """Show what `doctor` found."""
    table = _two_columns("rotorpong doctor")
    for check in result["checks"]:
        mark = "ok" if check["ok"] else "[red]problem[/red]"
        table.add_row(check["name"], f"{mark}  {escape(check['found'])}")
    return table


def _errors(summary: dict[str, Any]) -> list[str]:
    lengths = (summary["median_m"], summary["p90_m"])
    shown = ["-" if length is None else f"{100 * length:.1f}" for length in lengths]
    return [*shown, str(summary["n"])]


def _two_columns(title: str) -> Table:
    table = Table(title=escape(title), title_justify="left", show_header=False)
    table.add_column("what")
    table.add_column("value", justify="right")
    return table


def _counts(trials: list[dict[str, Any]]) -> dict[str, int]:
    outcomes = [trial["outcome"] for trial in trials]
    return {outcome: outcomes.count(outcome) for outcome in set(outcomes)}


def _best(balls: list[dict[str, Any]], *, linked: bool) -> list[str]:
    if not balls:
        return ["-"] * (6 if linked else 5)
    ball = balls[0]
    numbers = [f"{ball[key]:.{2 if linked else 1}f}" for key in ("x_px", "y_px", "diameter_px")]
    depth = "-" if ball["position_m"] is None else f"{ball['position_m'][2]:.2f}"
    found = [*numbers, f"{ball['score']:.2f}", depth]
    return [*found, str(ball["track"] or "-")] if linked else found
