"""What a kind of serves is like: how long it flies, and how long a camera sees it.

Flights pass the home blade plane; those that never do are counted and left out of the rest. "In the
picture" means the ball's centre, seen from a drone that hovers level at home.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray

from rotorpong import __version__
from rotorpong.lab.evaluate import evaluate
from rotorpong.lab.seeds import trial_generators
from rotorpong.lab.serving import serve_source
from rotorpong.lab.spec import Spec
from rotorpong.lab.statistics import rate, wilson_interval
from rotorpong.physics.camera import Camera, camera_from_body, in_picture
from rotorpong.play.paper import PaperSettings
from rotorpong.world.contact import TICK, Solids, fly_over_court, state_of
from rotorpong.world.racket import HOME_BODY
from rotorpong.world.serves import Serve, crossing

QUANTILES = (0.05, 0.5, 0.95)


def serve_stats(
    spec: Spec, balls: int, progress: Callable[[int, int], None] | None = None
) -> dict[str, Any]:
    """Throw `balls` serves at a hovering drone; return what `serves stats --json` prints."""
    source, camera = serve_source(spec.serves, spec.seed), spec.camera_profile()
    serves = [source(i, trial_generators(spec.seed, "evaluate", i).serve) for i in range(balls)]
    views = [_view(serve, camera) for serve in serves]
    results = evaluate(spec, balls, progress=progress)
    hits = sum(result.outcome == "hit" for result in results)
    reachable = sum(result.reachable for result in results)
    return {
        "serves": spec.serves_name,
        "vehicle": spec.vehicle_name,
        "camera": spec.camera_name,
        "contents": spec.contents(),
        "version": __version__,
        "seed": spec.seed,
        "balls": balls,
        "never_at_plane": sum(bool(np.isnan(view["flight"])) for view in views),
        "never_in_picture": sum(view["seen"] == 0.0 for view in views),
        "flight_time_s": _quantiles([view["flight"] for view in views]),
        "time_after_plane_s": _quantiles([view["after_plane"] for view in views]),
        "share_in_picture": _mean([view["seen"] for view in views]),
        "share_in_picture_at_plane": _mean([view["seen_at_plane"] for view in views]),
        "last_sight_before_contact_s": _quantiles([view["blind"] for view in views]),
        "hover_hit_rate": rate(hits, balls),
        "hover_hit_rate_interval": wilson_interval(hits, balls),
        "share_reachable": rate(reachable, balls),
        "share_reachable_interval": wilson_interval(reachable, balls),
    }


def _view(serve: Serve, camera: Camera) -> dict[str, float]:
    duration = crossing(serve)[0]
    if duration is None:
        return dict.fromkeys(("flight", "after_plane", "seen", "seen_at_plane", "blind"), np.nan)
    solids = Solids(air=serve.air, table=serve.table)
    path = fly_over_court(state_of(serve.ball), round(duration / TICK), solids)
    seen, depth = _seen(path[:, :3], camera)
    crossed = depth < PaperSettings().plane_distance
    at_plane = int(np.argmax(crossed)) if crossed.any() else len(path) - 1
    last = TICK * (np.flatnonzero(seen)[-1] + 1) if seen.any() else np.nan
    return {
        "flight": duration,
        "after_plane": duration - (at_plane + 1) * TICK,
        "seen": float(seen.mean()),
        "seen_at_plane": float(seen[at_plane]),
        "blind": float(duration - last),
    }


def _seen(
    positions: Float[ndarray, "n 3"], camera: Camera
) -> tuple[Bool[ndarray, "n"], Float[ndarray, "n"]]:
    eye = np.array(HOME_BODY) + np.array(camera.position_m)
    points = (positions - eye) @ camera_from_body(camera).T
    return in_picture(camera, points), points[:, 2]


def _quantiles(values: list[float]) -> dict[str, float | None]:
    finite = [value for value in values if np.isfinite(value)]
    names = (f"p{round(100 * q):02d}" for q in QUANTILES)
    found = np.quantile(finite, QUANTILES).tolist() if finite else [None] * len(QUANTILES)
    return dict(zip(names, found, strict=True))


def _mean(values: list[float]) -> float | None:
    finite = [value for value in values if np.isfinite(value)]
    return float(np.mean(finite)) if finite else None
