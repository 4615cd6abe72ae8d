"""`rotorpong throw`, met by a hostile user and by one who reads its JSON."""

import json

import pytest
from test_cli import ask, complaint, is_one_line_of_json

BAD = {
    "throw": "Missing from rotorpong throw: --out",
    "throw --out film.avi": "film.avi: expected a name that ends with .mp4, .gif, .png",
    "throw --out film": "film: expected a name that ends with .mp4, .gif, .png",
    "throw --out gone/film.gif": "gone/film.gif: the folder gone does not exist",
    "throw --out text/film.gif": "text/film.gif: the folder text does not exist",
    "throw --out folder.mp4": "folder.mp4: is a folder; expected a file",
    "throw --out film.png --index -1": "index -1: expected a whole number from 0 to 10000000",
    "throw --out film.png --index one": "--index: invalid literal for int()",
    "throw --out film.png --slow 0": "slow 0: expected a number from 1 to 100",
    "throw --out film.png --slow nan": "slow nan: expected a number from 1 to 100",
    "throw --out film.png --seed -1": "seed -1: expected a whole number",
    "throw --out film.png --player nobody": "unknown player 'nobody'",
    "throw --out film.png --camera nikon": "camera 'nikon': expected one of gazebo",
    "throw --out film.png --serves smash": "serves 'smash': expected one of human",
    "throw --out film.png --experience gone.sqlite": "gone.sqlite: does not exist",
}


@pytest.mark.parametrize("line", BAD)
def test_bad_input_is_status_2_and_one_line_and_leaves_no_file(tmp_path, monkeypatch, capfd, line):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "text").write_text("hello")
    (tmp_path / "folder.mp4").mkdir()
    assert BAD[line] in complaint(capfd, line, tmp_path)


@pytest.mark.parametrize("more", [(), ("--randomize",)])
def test_json_tells_the_outcome_and_where_the_pictures_are(tmp_path, capfd, more):
    out = tmp_path / "serve.png"
    line = ["throw", "--out", str(out), "--player", "hover", "--index", "1", "--json", *more]
    status, said, err = ask(capfd, *line)
    assert (status, err) == (0, "")
    assert is_one_line_of_json(said)
    told = json.loads(said)
    assert set(told) == {"outcome", "miss_distance_m", "frames", "out"}
    assert told["out"] == str(out)
    assert out.read_bytes().startswith(b"\x89PNG")
