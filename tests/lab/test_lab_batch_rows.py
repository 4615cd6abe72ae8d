"""The rows of the batch benchmark are what `rotorpong bench world` can print; no time is tested."""

import math

from rotorpong.lab.bench import batch_rows


def test_every_row_is_finite_and_the_two_targets_are_those_of_the_design(monkeypatch):
    monkeypatch.setattr(batch_rows, "SIZES", (1, 4))
    monkeypatch.setattr(batch_rows, "TRIALS", 4)
    monkeypatch.setattr(batch_rows, "REPEATS", 1)
    rows = batch_rows.rows()
    names = [row.name for row in rows]
    assert len(set(names)) == len(names)
    assert all(math.isfinite(row.value) and row.value > 0.0 for row in rows)
    targets = {row.name: row.target for row in rows if row.target is not None}
    assert targets == {"state-only trials": 5000.0, "control steps, one environment": 10_000.0}
    assert all({"name", "value", "unit"} <= row.as_json().keys() for row in rows)
