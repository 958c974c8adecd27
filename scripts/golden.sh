#!/usr/bin/env bash
# Renders the course's batch and compares it, picture by picture; prints a Markdown table.
#
# Usage: scripts/golden.sh [STARTER_FOLDER]
#   without a folder: data/ against sample_out/, which must be equal;
#   with the course's starter: its data/ against its sample_out/, within the limits for two correct programs.
# Environment: A2 (the program; default: built here).
set -euo pipefail

# shellcheck source=scripts/program.sh
source "$(dirname "$0")/program.sh"
starter=${1:-}
if [ -n "$starter" ]; then
    root=$starter tolerance="1 0.01" any=1.0 far=12
else
    root=$project tolerance="0 0" any=0 far=0
fi
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
DATA=$root/data "$project/scripts/render_all.sh" "$work" >"$work/log"

echo "| picture | pixels that differ | by more than 1 level | by more than 8 | worst | RMSE |"
echo "|---|---|---|---|---|---|"
failed=0
for number in $(awk '$1 ~ /^[0-9]/ { print $1 }' "$project/data/batch.txt"); do
    for kind in "" n d; do
        name=a$number$kind.png
        # shellcheck disable=SC2086 # two words
        "$A2" -compare "$work/$name" "$root/sample_out/$name" -tolerance $tolerance >"$work/result" || failed=1
        # Lines read "over 1 levels  31 pixels, 0.0048%".
        awk -v name="$name" -v any="$any" -v far="$far" '
            /^worst/ { worst = $3 } /^RMSE/ { rmse = $2 }
            /^over/ { pixels[$2] = $4; percent[$2] = $6 + 0 }
            END {
                printf "| %s | %.4f%% | %d | %d | %d | %s |\n", name, percent[0], pixels[1], pixels[8], worst, rmse
                exit percent[0] > any || pixels[8] > far
            }' "$work/result" || failed=1
    done
done
if [ "$failed" -ne 0 ]; then
    echo "some pictures are off their limits" >&2
fi
exit "$failed"
