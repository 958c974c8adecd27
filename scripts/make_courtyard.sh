#!/bin/sh
# Makes the courtyard's meshes (data/models/courtyard) and renders the six faces of
# its cube map (data/tex/courtyard) from data/courtyard.txt:
#
#     scripts/make_courtyard.sh target/release/a2 [SIZE, 1024 if not given]
#
# A face is a square view of 90 degrees from 0 2 0. Its direction and its up follow
# from the lookup. On the face `up`, for example, u grows with x and v with z; a camera
# that looks along y with z up has its horizontal, cross(y, z), along x. On `down` and
# `back`, u grows against that horizontal: the face must be a mirror image. For these
# two the scene is mirrored in x, lights and root group alike.
#
# In the lookup, texel x of n is at 2x/n - 1, and the far edge is clamped; -jitter
# spreads the samples of pixel x about (2x + 1)/(n - 1) - 1. So the map is shifted by
# half a texel to one and a half. Correcting this with tilted, narrower cameras was
# tried: the difference across the seams fell by only a fifth.

set -eu

if [ $# -lt 1 ] || [ ! -x "$1" ]; then
    echo "usage: $0 A2_BINARY [SIZE]" >&2
    exit 2
fi
a2=$1
size=${2:-1024}

root=$(cd "$(dirname "$0")/.." && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

python3 "$root/scripts/make_courtyard.py"
ln -s "$root/data/models" "$work/models"

without_camera() {
    sed '/^PerspectiveCamera/,/^}/d' "$root/data/courtyard.txt"
}

mirror_in_x() {
    sed -E '/^Lights/,/^}/ {
        s/(position|direction) -/\1 +/
        s/(position|direction) ([0-9.])/\1 -\2/
        s/(position|direction) \+/\1 /
    }
    s/^Group \{/Group { numObjects 1 Transform { Scale -1 1 1 Group {/'
    echo '} }'
}

face() {
    name=$1 direction=$2 up=$3 change=$4
    {
        echo "PerspectiveCamera { center 0 2 0 direction $direction up $up angle 90 }"
        without_camera | $change
    } > "$work/$name.txt"
    "$a2" -input "$work/$name.txt" -output "$work/$name.png" -size "$size" "$size" \
        -shadows -bounces 2 -jitter
}

face right '1 0 0' '0 1 0' cat
face left '-1 0 0' '0 1 0' cat
face up '0 1 0' '0 0 1' cat
face down '0 -1 0' '0 0 1' mirror_in_x
face front '0 0 1' '0 1 0' cat
face back '0 0 -1' '0 1 0' mirror_in_x

mkdir -p "$root/data/tex/courtyard"
mv "$work"/*.png "$root/data/tex/courtyard/"
