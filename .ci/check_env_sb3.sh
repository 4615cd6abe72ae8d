#!/bin/bash
# Optional: Stable-Baselines3's own check of the environments, in a virtual environment of its own
# (several GB with torch, as the index serves it). Any warning is an error.
set -euo pipefail
cd "$(dirname "$0")/.."
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet --disable-pip-version-check -c constraints.txt . stable-baselines3
"$work/venv/bin/python" -W error::UserWarning .ci/check_env_sb3.py
