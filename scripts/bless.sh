#!/usr/bin/env bash
# Replaces the reference pictures in sample_out/ by newly rendered ones, and prints which ones changed.
#
# Only for a change that is meant to change pictures. Look at them, and give the reason in the commit and in
# CHANGELOG.md.
# Exits with 1 if a picture changed, so that no script accepts new pictures by accident.
set -euo pipefail

# shellcheck source=scripts/program.sh
source "$(dirname "$0")/program.sh"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
"$project/scripts/render_all.sh" "$work"
changed=0
mkdir -p "$project/sample_out"
# The batch, without the picture of anti-aliasing.
for picture in "$work"/a??.png "$work"/a??[nd].png; do
    reference=$project/sample_out/$(basename "$picture")
    # Pixels are compared, so a better compression of the same picture is no change.
    if [ ! -e "$reference" ] || ! "$A2" -compare "$picture" "$reference" -tolerance 0 0 >/dev/null; then
        echo "changed: $(basename "$picture")"
        cp "$picture" "$reference"
        changed=1
    fi
done
exit "$changed"
