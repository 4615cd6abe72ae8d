#!/bin/bash
# Optional: Stable-Baselines3's own check of the environments, in a virtual environment of its own.
# Any warning is an error. What pip calls torch comes with several GB of CUDA; a build for the CPU
# will do where there is one: TORCH=torch==2.13.0+cpu .ci/check_env_sb3.sh
set -euo pipefail
cd "$(dirname "$0")/.."
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet --disable-pip-version-check -c constraints.txt \
    "${TORCH:-torch}" . stable-baselines3
"$work/venv/bin/python" -W error .ci/check_env_sb3.py
