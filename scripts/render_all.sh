#!/usr/bin/env bash
# Renders the course's batch (data/batch.txt): seven scenes at 800 x 800, each as colour, normal and depth picture.
#
# Usage: scripts/render_all.sh [OUTPUT_FOLDER]
# A scene that fails does not stop the others; then the exit code is 1.
# Environment: A2 (the program; default: built here), DATA (folder of the scenes; default: data), SIZE (default: 800).
set -euo pipefail

# shellcheck source=scripts/program.sh
source "$(dirname "$0")/program.sh"
output=${1:-out}
data=${DATA:-$project/data}
size=${SIZE:-800}
mkdir -p "$output"
failed=0

while read -r number scene near far flags; do
    case $number in "" | "#"*) continue ;; esac
    # shellcheck disable=SC2086 # flags are words
    "$A2" -input "$data/$scene.txt" -size "$size" "$size" -output "$output/a$number.png" \
        -normals "$output/a${number}n.png" -depth "$near" "$far" "$output/a${number}d.png" $flags </dev/null || {
        echo "$scene failed with exit code $?" >&2
        failed=1
    }
done <"$project/data/batch.txt"
exit "$failed"
