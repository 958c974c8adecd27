#!/usr/bin/env bash
# Renders the course's batch (data/batch.txt): seven scenes at 800 x 800, each as colour, normal and depth picture; and the
# picture of anti-aliasing, a01aa.png: scene 01 with -jitter -filter, 144 rays a pixel, so at a quarter of the size.
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

# Runs the program; $1 names what it renders.
render() {
    local what=$1
    shift
    "$A2" "$@" </dev/null || {
        echo "$what failed with exit code $?" >&2
        failed=1
    }
}

while read -r number scene near far flags; do
    case $number in "" | "#"*) continue ;; esac
    # shellcheck disable=SC2086 # flags are words
    render "$scene" -input "$data/$scene.txt" -size "$size" "$size" -output "$output/a$number.png" \
        -normals "$output/a${number}n.png" -depth "$near" "$far" "$output/a${number}d.png" $flags
done <"$project/data/batch.txt"
quarter=$((size < 4 ? 1 : size / 4))
render anti-aliasing -input "$data/scene01_plane.txt" -size "$quarter" "$quarter" -output "$output/a01aa.png" -jitter -filter
exit "$failed"
