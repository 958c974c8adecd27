#!/usr/bin/env bash
# Renders the course's batch: seven scenes at 800 x 800, each as colour, normal and depth picture, 21 files in all.
#
# Usage: scripts/render_all.sh [OUTPUT_FOLDER]
# Environment: A2 (the program; default: built here), DATA (folder of the scenes; default: data), SIZE (default: 800).
set -euo pipefail

# shellcheck source=scripts/program.sh
source "$(dirname "$0")/program.sh"
output=${1:-out}
data=${DATA:-$project/data}
size=${SIZE:-800}
mkdir -p "$output"

# render NUMBER SCENE DEPTH_MIN DEPTH_MAX [FLAG...]
render() {
    local number=$1 scene=$2 near=$3 far=$4
    shift 4
    "$A2" -input "$data/$scene.txt" -size "$size" "$size" -output "$output/a$number.png" \
        -normals "$output/a${number}n.png" -depth "$near" "$far" "$output/a${number}d.png" "$@"
}

render 01 scene01_plane 8 18
render 02 scene02_cube 8 18
render 03 scene03_sphere 8 18
render 04 scene04_axes 8 18
render 05 scene05_bunny_200 0.8 1.0
render 06 scene06_bunny_1k 8 18 -bounces 4
render 07 scene07_arch 8 18 -bounces 4 -shadows
