"""Make what README and docs show: `python docs/make.py`.

Renders `images/onboard.png`, then runs the commands below and writes them with what they print to
`commands.md`. Run it again when a command or its output changes.
"""

import os
import subprocess
import sys
import tempfile
from pathlib import Path

import cv2

from rotorpong.conventions import Picture
from rotorpong.drone import HOVER
from rotorpong.lab.spec import Spec
from rotorpong.lab.trial import new_drone, stage_of
from rotorpong.physics.camera import ARDRONE2_720P, Camera, ideal
from rotorpong.vision.films import film

DOCS = Path(__file__).resolve().parent
TRIAL, FRAME = 3, 16  # a serve with the ball well in view, and when
FILMED = range(10, 18)  # frames of it, for a film
WIDTH = "100"  # columns of the terminal

HEAD = """# Commands, and what they print

Every command takes `--seed` and `--json`: stdout then holds one JSON object on one line, and
nothing else. Bad input ends with exit status 2 and one line. This page is made by
`python docs/make.py`.
"""

TAIL = """\
Measure how well balls are found in your own pictures. `DIR` is a folder of pictures with YOLO
labels, or of such folders, each a set: `NAME.txt` beside `NAME.jpg` has a line `class x y width
height` per box, centre and size in shares of the picture, and is empty where no ball is. Where
labels are of one class, that is the ball; where they are of several, `--ball-class 1` says which.
Every set is looked through for orange balls, and for orange and white ones; `--colour` names other
colours, as for `detect`.

```sh
rotorpong bench eyes --images DIR --ball-class 1 --colour orange
```

Each set has rows for

- `recall at precision 0.95`: the share of the labelled balls found at the lowest score at which
  95 % of what is found is a ball; `precision there`; and `least score there`, what to give
  `detect --min-score` for pictures like these;
- `held-out recall` and `held-out precision`: the same, each fifth of the pictures with the score
  that the other four need: what to expect of other pictures;
- `average precision`: the area under precision over recall, all scores;
- of the balls found, medians of `overlap` (of the circle's square and the box, intersection over
  union: from 0.5 it counts as found), `centre error` in px and `diameter ratio` (the circle's
  diameter over the box's mean side).
"""

EXAMPLES = (
    ("Is this machine fit?", "rotorpong doctor"),
    (
        "Train the paper's player on its own hits; every trial is kept before the next begins, so "
        "a killed run goes on with `--resume`.",
        "rotorpong train --player paper --eyes truth --hits 5 --out own.sqlite",
    ),
    (
        "Measure it, on serves that it never saw.",
        "rotorpong evaluate --player paper --eyes truth --balls 50 --experience own.sqlite",
    ),
    (
        "The same for a drone that only hovers; as JSON, cut after the first trial here.",
        "rotorpong evaluate --player hover --balls 50 --json",
    ),
    (
        "Compare with others on the same balls: keep what they print, and name it. Of hover and "
        "oracle together it tells the skill as well.",
        "rotorpong evaluate --player hover --balls 50 --json > hover.json",
        "rotorpong evaluate --player oracle --eyes truth --balls 50 --json > oracle.json",
        "rotorpong evaluate --eyes truth --balls 50 --experience own.sqlite "
        "--against hover.json oracle.json",
    ),
    (
        "Find the ball in a picture and locate it with that camera's calibration.",
        "rotorpong detect onboard.png --camera ardrone2_720p --min-score 0.5",
    ),
    (
        "Follow the ball through a film. Eyes `tracker` measure it below the pixel, place it with "
        "its covariance, and link balls over the frames of a video, or of pictures of one size "
        "numbered one after the other (`frame_0041.png`, `frame_0042.png`: taken as 30 per second);"
        " `marked.mp4` shows them with their trails, as large and as fast as the film. A folder as "
        "`--out` takes a film of each video and a picture of each picture. The camera must have "
        "taken pictures of this very size; its `gamma` counts (2.2 of most cameras' files, which "
        "is also what is assumed without `--camera`).",
        "rotorpong detect serve.mp4 --eyes tracker --camera ardrone2_720p --out marked.mp4",
    ),
    (
        "Calibrate a camera from pictures of a chessboard; these were drawn by "
        "`examples/draw_calibration.py`.",
        "rotorpong calibrate camera calibration/boards --out own.json",
    ),
    (
        "Learn the colour of green balls from boxes around them, and find them.",
        "rotorpong calibrate colour calibration/balls/boxes.csv --out green.json",
        "rotorpong detect calibration/balls --colour green.json --camera own.json",
    ),
    ("Describe the serves as a camera sees them.", "rotorpong serves stats --balls 100"),
    (
        "Turn a measured flight (here a synthetic one: columns `time_s,x_m,y_m,z_m`) into a serve.",
        "rotorpong serves from-flight flight.csv --out serve.csv",
    ),
    ("Throw it.", "rotorpong evaluate --player hover --serves serve.csv --balls 5"),
    (
        "Try the tracker's flight filter on that flight: every 0.15 s of points predict the ball "
        "0.1 s after the last of them, beside the same without spin and without air. `--ahead-s` "
        "is 0.2 if not given; this flight is short. A folder of flights is pooled, with a row for "
        "each. The frame's origin is the table's centre, z up; bounces are predicted through, "
        "strokes cannot be, and no window reaches across one.",
        "rotorpong predict flight.csv --ahead-s 0.1",
    ),
    (
        "See one serve: onboard above, from beside the table below.",
        "rotorpong throw --player oracle --eyes truth --index 3 --out serve.png",
    ),
    (
        "What could be hit at all, by somebody who knows everything but sees no sooner.",
        "rotorpong evaluate --player oracle --eyes truth --balls 50 --vehicle ardrone2",
    ),
    (
        "Another drone, ball, camera and room for every ball. Serves of a file keep the ball that "
        "was measured with them.",
        "rotorpong evaluate --player hover --balls 50 --vehicle ardrone2 --camera ardrone2_720p "
        "--randomize",
    ),
    (
        "Another circle through the ball's outline than the paper's, and its diameter not rounded "
        "to whole pixels.",
        "rotorpong evaluate --balls 50 --circle-fit pratt --diameter float",
    ),
    (
        "Motions flown in closed loop, not open as in the paper.",
        "rotorpong evaluate --eyes truth --balls 50 --control closed-loop",
    ),
    (
        "Tables and figures of the paper, each number beside ours: here one of them. `all` takes "
        "23 minutes, `all --quick` one and a half, and gives the page [The paper, "
        "reproduced](paper/page.md); what was interrupted goes on where it was.",
        "rotorpong reproduce fig6 --quick --out reproduced",
    ),
    (
        "The frozen benchmark, here only the first twenty balls of each cell. Without `--quick`, "
        "and with `--out FILE.json`, it gives what the [leaderboard](leaderboard.md) takes; what "
        "was interrupted goes on with `--resume`.",
        "rotorpong suite v1 --player paper --eyes truth --quick",
    ),
    (
        "White balls, and eyes that look for them.",
        "rotorpong evaluate --eyes tracker --ball white --balls 50",
    ),
    (
        "Mistakes.",
        "rotorpong evaluate --player nobody",
        "rotorpong evaluate --eyes tracker --circle-fit pratt",
    ),
)


def main() -> None:
    """Make the picture and the page."""
    draw_onboard(DOCS / "images" / "onboard.png")
    with tempfile.TemporaryDirectory() as folder:
        for name, source in (("onboard.png", "images"), ("flight.csv", "../examples")):
            (Path(folder) / name).symlink_to((DOCS / source / name).resolve())
        film_onboard(Path(folder) / "serve.mp4")
        draw = DOCS.parent / "examples" / "draw_calibration.py"
        subprocess.run([sys.executable, str(draw), "calibration"], cwd=folder, check=True)
        parts = [f"{why}\n\n{shown(commands, folder)}\n" for why, *commands in EXAMPLES]
    (DOCS / "commands.md").write_text("\n".join([HEAD, *parts, TAIL]))


def shown(commands: list[str], folder: str) -> str:
    """Return commands with what they print, as a block of text."""
    return "\n".join(["```console", *(line for c in commands for line in run(c, folder)), "```"])


def run(command: str, folder: str) -> list[str]:
    """Return the lines of a command and of what it prints, unless that goes into a file."""
    words, _, kept = command.partition(" > ")
    program, *arguments = words.split()
    done = subprocess.run(
        [str(Path(sys.executable).with_name(program)), *arguments],
        cwd=folder,
        env={**os.environ, "COLUMNS": WIDTH},
        capture_output=True,
        text=True,
        check=False,
    )
    lines = [line.rstrip() for line in (done.stdout + done.stderr).splitlines()]
    if kept:
        (Path(folder) / kept).write_text(done.stdout)
        lines = done.stderr.splitlines()
    elif "--json" in arguments:
        cut = lines[0].index("}", lines[0].index('"trials"'))
        lines = [lines[0][: cut + 1] + ", ...], ...}"]
    return [f"$ {command}", *(line.replace(str(Path.home()), "~") for line in lines)]


def draw_onboard(path: Path) -> None:
    """Render what the drone sees of one serve through the lens of the AR.Drone 2.0.

    Without the sensor's noise, which makes a picture file four times as large.
    """
    *_, last = frames_onboard(ideal(ARDRONE2_720P), FRAME)
    cv2.imwrite(str(path), last, [cv2.IMWRITE_PNG_COMPRESSION, 9])


def film_onboard(path: Path) -> None:
    """Film a part of the same serve as the sensor has it."""
    with film(path, 30.0) as made:
        for picture in frames_onboard(ARDRONE2_720P, FILMED.stop)[FILMED.start :]:
            made.write(picture)


def frames_onboard(camera: Camera, count: int) -> list[Picture]:
    """Return the first frames of the serve."""
    drone = new_drone(stage_of(Spec(camera=camera, seed=1)), TRIAL)
    frames = []
    while len(frames) < count:
        observation = drone.observe()
        if observation is None:
            raise SystemExit("the serve was over too early: choose another trial or frame")
        frames.append(observation.frame.picture)
        drone.command(HOVER)
    return frames


if __name__ == "__main__":
    main()
