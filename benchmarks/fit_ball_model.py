"""Fit the model of a ball to labelled pictures: `python benchmarks/fit_ball_model.py DIR`.

DIR is a folder of pictures and labels, or of such folders, as for `rotorpong bench eyes --images`.
Prints both models of `rotorpong.vision.ball_model` as Python; nothing of the pictures is kept.

Weighted logistic regression with a ridge. A candidate's target grows from 0 to 1 while its circle's
overlap with a labelled box goes from 0.4 to 0.7, so that of several outlines of a ball the one that
fits best is believed most. Every ball weighs the same however many outlines it has, and every set
of pictures the same however many balls. All sets teach both models, whatever the colour of their
balls: they show what is none. So do drawn shapes of the ball's colour and drawn faces
(`drawn_shapes`).
"""

import sys
from pathlib import Path

import numpy as np
from drawn_shapes import draw, draw_head
from jaxtyping import Float
from numpy import ndarray

from rotorpong.conventions import Picture
from rotorpong.lab.bench.image_rows import overlaps
from rotorpong.lab.picture_sets import read_picture_sets
from rotorpong.vision.ball_model import BallModel
from rotorpong.vision.candidates import FEATURES, find_candidates
from rotorpong.vision.colour import ORANGE, WHITE, Colour
from rotorpong.vision.detect import Detection, outline_circle

OVERLAPS = (0.4, 0.7)  # from no to full target
BALL_WEIGHT = 6.0  # over the root of its outlines
SET_WEIGHT = 300.0  # of the targets of a set
FEWEST_TARGETS = 10.0  # below which a set only shows what is no ball
OTHERS_WEIGHT = 0.15
RIDGE = 3.0
DRAWN, DRAWN_WEIGHT = 40, 75.0  # pictures, and the weight of all they show
STEPS, CONVERGED = 50, 1e-8

Sample = tuple[Float[ndarray, "n k"], Float[ndarray, "n"], Float[ndarray, "n"]]


def main(arguments: list[str]) -> None:
    """Print both models."""
    folder, ball_class = Path(arguments[0]), int(arguments[1]) if len(arguments) > 1 else None
    sets = read_picture_sets(folder, ball_class)
    for name, colour in (("HUED", ORANGE), ("PALE", WHITE)):
        samples = [weighed([sample(*one.read(), colour) for one in s.pictures]) for s in sets]
        samples.append(drawn_samples(colour))
        print(f"{name} = {fit(*map(np.concatenate, zip(*samples, strict=True)))}")


def drawn_samples(colour: Colour) -> Sample:
    """Return the candidates of drawn pictures, which show no ball."""
    rng, none = np.random.default_rng(0), np.empty((0, 4))
    drawn = [draw(rng, colour) for _ in range(DRAWN)] + [draw_head(rng) for _ in range(DRAWN)]
    pictures = [sample(picture, none, colour) for picture in drawn]
    features, targets, _ = map(np.concatenate, zip(*pictures, strict=True))
    return features, targets, np.full(len(targets), DRAWN_WEIGHT / len(targets))


def sample(picture: Picture, boxes: Float[ndarray, "n 4"], colour: Colour) -> Sample:
    """Return features, targets and weights of the candidates of a picture."""
    found = find_candidates(picture, colour)
    if not found.contours:
        return found.features, np.empty(0), np.empty(0)
    overlap = np.zeros((len(found.contours), len(boxes)))
    for i, contour in enumerate(found.contours):
        circle = outline_circle(contour, picture.shape[:2])
        place = (circle.x_px, circle.y_px, circle.diameter_px)
        overlap[i] = overlaps(Detection(*place, 0.0, colour.name), boxes)
    low, high = OVERLAPS
    most = overlap.max(axis=1, initial=0.0)
    weights = np.ones(len(overlap))
    for of_ball in (overlap > low).T:
        if of_ball.any():
            weights[of_ball] = BALL_WEIGHT / np.sqrt(of_ball.sum())
    return found.features, np.clip((most - low) / (high - low), 0.0, 1.0), weights


def weighed(pictures: list[Sample]) -> Sample:
    """Return the candidates of a set with the weight that is its due."""
    features, targets, weights = map(np.concatenate, zip(*pictures, strict=True))
    total = float(weights @ targets)
    return (
        features,
        targets,
        weights * (SET_WEIGHT / total if total > FEWEST_TARGETS else OTHERS_WEIGHT),
    )


def fit(
    features: Float[ndarray, "n k"], targets: Float[ndarray, "n"], weights: Float[ndarray, "n"]
) -> BallModel:
    """Return the model of greatest penalised likelihood, by Newton's steps."""
    mean = np.average(features, axis=0, weights=weights)
    spread = np.sqrt(np.average((features - mean) ** 2, axis=0, weights=weights)) + 1e-9
    design = np.column_stack([(features - mean) / spread, np.ones(len(features))])
    ridge = np.diag([RIDGE] * len(mean) + [1e-6])
    solution = np.zeros(design.shape[1])
    for _ in range(STEPS):
        chance = 1.0 / (1.0 + np.exp(-design @ solution))
        slope = design.T @ (weights * (targets - chance)) - ridge @ solution
        curvature = (design.T * (weights * chance * (1.0 - chance))) @ design + ridge
        step = np.linalg.solve(curvature, slope)
        solution += step
        if np.abs(step).max() < CONVERGED:
            break
    scaled = solution[:-1] / spread
    pairs = {name: round(float(w), 3) for name, w in zip(FEATURES, scaled, strict=True)}
    return BallModel(round(float(solution[-1] - scaled @ mean), 3), pairs)


if __name__ == "__main__":
    main(sys.argv[1:])
