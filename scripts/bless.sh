#!/usr/bin/env bash
# Replaces the reference pictures in sample_out/ by what the program renders now, and says which ones changed.
#
# Only for a change that is meant to alter pictures: look at them, and say why in the commit and in CHANGELOG.md.
# Exits with 1 whenever a picture changed, so that no script blesses by accident.
set -euo pipefail

# shellcheck source=scripts/program.sh
source "$(dirname "$0")/program.sh"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
"$project/scripts/render_all.sh" "$work"
changed=0
mkdir -p "$project/sample_out"
for picture in "$work"/*.png; do
    reference=$project/sample_out/$(basename "$picture")
    # Pixels count: a better compression of the same picture is no change.
    if [ ! -e "$reference" ] || ! "$A2" -compare "$picture" "$reference" -tolerance 0 0 >/dev/null; then
        echo "changed: $(basename "$picture")"
        cp "$picture" "$reference"
        changed=1
    fi
done
exit "$changed"
