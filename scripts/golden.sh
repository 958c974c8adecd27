#!/usr/bin/env bash
# Renders the course's batch and compares it, picture by picture; prints a Markdown table. scripts/grade.py does the work.
#
# Usage: scripts/golden.sh [STARTER_FOLDER]
#   without a folder: data/ against sample_out/, which must be equal;
#   with the course's starter: its data/ against its sample_out/, within the limits for two correct programs.
# Environment: A2 (the program under test; default: built here), A2_JUDGE (the a2 that compares; default: built here).
set -euo pipefail

limits=(--exact)
if [ $# -gt 0 ]; then
    limits=(--starter "$1")
fi
exec python3 "$(dirname "$0")/grade.py" --pictures --scenes 01,02,03,04,05,06,07 "${limits[@]}"
