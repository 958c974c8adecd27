#!/usr/bin/env bash
# Renders frames and joins them to an animated PNG; frames.py says how.
set -euo pipefail
# shellcheck source=scripts/program.sh
source "$(dirname "$0")/program.sh"
exec python3 "$project/scripts/frames.py" "$@"
