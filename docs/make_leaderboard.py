"""Make the leaderboard's page from the results beside it: `python docs/make_leaderboard.py`.

A result is what `rotorpong suite v1 ... --out FILE.json` wrote, in `docs/leaderboard/`. One that is
of other balls, is quick or does not add up ends this with what is wrong. `--play` first plays what
is missing of our own, minutes each; a run that was interrupted goes on.
"""

import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rotorpong.lab.spec import DECIDING_ONCE
from rotorpong.lab.suite.cells import V1, Cell
from rotorpong.lab.suite.entries import read_entry
from rotorpong.lab.suite.frozen import frozen, hits_in, suite_digest
from rotorpong.lab.suite.tables import of_scale

DOCS = Path(__file__).resolve().parent
CRKR = "--labels commanded --length-scale 3 --regularization 0.1"
PAPER = f"--player paper {CRKR} --control open"
WIDE = "--length-scale 12 --regularization 0.002 --control feed-forward"
TAUGHT = f"--player paper --labels commanded {WIDE} --experience paper_170_hits.sqlite"
CHASER = "--player examples/own_player.py:Chaser"
TRAINING = (
    f"train --player paper --eyes paper {WIDE} --hits 170 --seed 1000 --out paper_170_hits.sqlite"
)
OURS = {
    "hover": "--player hover --eyes truth",
    "oracle": "--player oracle --eyes truth",
    "paper_ff_170_truth": f"{TAUGHT} --eyes truth",
    "paper_ff_170": f"{TAUGHT} --eyes paper",
    "paper": f"{PAPER} --eyes paper",
    "paper_ff_170_tracker": f"{TAUGHT} --eyes tracker",
    "paper_truth": f"{PAPER} --eyes truth",
    "chaser_truth": f"{CHASER} --eyes truth",
    "chaser_tracker": f"{CHASER} --eyes tracker",
    "paper_ff": f"--player paper --labels commanded {WIDE} --eyes paper",
    "nearest": "--player nearest --control open --eyes paper",
    "single": f"--player single {CRKR} --control open --eyes paper",
    "bandit": "--player bandit --length-scale 3 --regularization 0.1 --control open --eyes paper",
}
HEAD = """# Leaderboard

`rotorpong suite v1` plays a frozen benchmark: {cells} [cells](#the-cells) of {balls} balls each,
with vehicles, cameras, serves and seeds that never change. The *skill* of a cell puts a hit rate
between those of a drone that only hovers, 0, and of the [oracle](players.md), 1, on the same balls;
the *score* is the mean skill of the cells, with its 95 % interval; beside it stands the hit rate of
each cell in per cent. This page is made by `python docs/make_leaderboard.py` from the results in
`docs/leaderboard/`.
"""
TAKE_PART = """\
## Take part

```sh
rotorpong suite v1 --player FILE.py:CLASS --eyes tracker --workers 2 --out NAME.json
python docs/make_leaderboard.py
```

with `NAME.json` in `docs/leaderboard/`. Propose both and, if the player is your own, its file. The
JSON carries the command, the version, all settings, what the player learnt from, a digest of your
player's file and one of the suite, and the outcome of every ball (`h` hit, `n` near hit, `m` miss,
`u` unseen, `d` on the drone's hull, `f` fault). It is refused if it is of other balls, quick, or
does not add up; whether it is true shows when somebody runs its command again: the same result, for
any number of workers.

What a player knows beforehand is its own affair. A learner of ours starts from ten demonstrations,
or from a file of `rotorpong train` by `--experience`; the suite itself teaches nothing, and the
result says how many hits and balls of which serves that file holds. Training throws other balls
than the suite, and a file of the suite's own seed is refused. A player of your own brings what it
knows in its file. Choose settings on other seeds than {seed}. With eyes `truth` a player is told
where the ball is, so it stands in a table apart.

`--quick` plays the first twenty balls of each cell, to see that everything works.
"""
FROZEN = """\
## What is frozen

Each result says by a digest which balls were really thrown (release position, velocity and spin to
a thousandth, air and table), and `suite` refuses to play if they are not the committed ones. The
outcomes of `hover` and `oracle` are committed as well. What should be otherwise becomes `v2`.

Skill is (rate - hover) / (oracle - hover). Its interval is that of a ratio of means of the same
balls, by the delta method: what the three have in common cancels, and a player that hits exactly
what the oracle hits has an interval of no width, so look at Wilson's of its hit rate then.
"""


def main() -> None:
    """Write the page."""
    if "--play" in sys.argv[1:]:
        play_ours()
    entries = read_entries(DOCS / "leaderboard")
    (DOCS / "leaderboard.md").write_text(page(entries))


def play_ours() -> None:
    """Play what is missing of our own, and train what it learnt from."""
    if not (DOCS.parent / "paper_170_hits.sqlite").exists():
        rotorpong(TRAINING)
    for name, flags in OURS.items():
        out = f"docs/leaderboard/{name}.json"
        if not (DOCS.parent / out).exists():
            rotorpong(f"suite v1 {flags} --workers 2 --out {out} --resume")


def rotorpong(line: str) -> None:
    """Run a command of rotorpong in the checkout."""
    subprocess.run([sys.executable, "-m", "rotorpong", *line.split()], cwd=DOCS.parent, check=True)


def read_entries(folder: Path) -> dict[str, dict[str, Any]]:
    """Return all results by their file's name, the best first."""
    found = {path.stem: read_entry(path) for path in sorted(folder.glob("*.json"))}
    return dict(sorted(found.items(), key=lambda named: -named[1]["score"]))


def page(entries: dict[str, dict[str, Any]]) -> str:
    """Return the page."""
    seen = {name: one for name, one in entries.items() if one["eyes"] != "truth"}
    told = {name: one for name, one in entries.items() if name not in seen}
    parts = [
        HEAD.format(cells=len(V1.cells), balls=V1.cells[0].balls),
        "## From pictures\n\n" + board(seen),
        "## Told the truth\n\nBounds, not entries: eyes `truth`, or a player that needs none.\n\n"
        + board(told),
        "## The results\n\n" + "\n".join(described(*named) for named in entries.items()),
        TAKE_PART.format(seed=V1.cells[0].seed),
        "## The cells\n\n" + cells_table(),
        f"{FROZEN}\nSHA-256 of all that is committed of v1: `{suite_digest(V1)}`.\n",
    ]
    return "\n".join(parts)


def board(entries: dict[str, dict[str, Any]]) -> str:
    """Return results as a table: score, and the hit rate of each cell in per cent."""
    if not entries:
        return "Nobody yet.\n"
    names = [cell.name for cell in V1.cells]
    lines = [["score", "result", "player", "eyes", "knows", *names]]
    for name, one in entries.items():
        hits = [f"{100 * cell['hit_rate']:.1f}" for cell in one["cells"]]
        who = [of_scale(one["score"], one["score_interval"]), f"[{name}](#{name})"]
        lines.append([*who, f"`{one['player']}`", one["eyes"], knowledge(one), *hits])
    return table(lines)


def described(name: str, one: dict[str, Any]) -> str:
    """Return which command gave a result, and what its player had learnt from."""
    lines = [f"### {name}", "", f"Version {one['version']}:", "", f"    {one['command']}", ""]
    learnt = one["experience"]
    if learnt is not None:
        lines += [
            f"Experience: {learnt['hits']} hits of {learnt['balls']} balls, player "
            f"`{learnt['player']}`, eyes {learnt['eyes']}, {learnt['vehicle']}, "
            f"{learnt['camera']}, serves {learnt['serves']}, seed {learnt['seed']}, version "
            f"{learnt['version']}, SHA-256 `{learnt['digest'][:12]}`.",
            "",
        ]
    return "\n".join(lines)


def knowledge(one: dict[str, Any]) -> str:
    """Return in a few words what the player of a result had learnt from."""
    if one["experience"] is not None:
        return f"{one['experience']['hits']} hits"
    return "10 demonstrations" if one["player"] in DECIDING_ONCE else ""


def cells_table() -> str:
    """Return what the cells are, and what hover and the oracle hit there."""
    known = frozen(V1)
    lines = [["cell", "vehicle", "camera", "serves", "balls", "seed", "hover", "oracle"]]
    for cell in V1.cells:
        texts = (known[cell.name].hover, known[cell.name].oracle)
        rates = [f"{100 * hits_in(text).mean():.1f} %" for text in texts]
        serves = f"{cell.serves}, randomized" if cell.randomize else cell.serves
        where = [cell.vehicle, camera(cell), serves, str(cell.balls), str(cell.seed)]
        lines.append([cell.name, *where, *rates])
    return table(lines)


def camera(cell: Cell) -> str:
    """Return the camera of a cell in words."""
    pitch = cell.camera_pitch_deg
    return f"{cell.camera}, pitched {pitch:g} degrees up" if pitch else cell.camera


def table(lines: Sequence[Sequence[str]]) -> str:
    """Return a table in Markdown; the first line is its head."""
    head, *rows = (f"| {' | '.join(line)} |\n" for line in lines)
    return "".join([head, f"|{'---|' * len(lines[0])}\n", *rows])


if __name__ == "__main__":
    main()
