#!/usr/bin/env bash
# Measures the tables of docs/numerics.md, renders its pictures, and updates the page: everything between the lines
# `<!-- name -->` and `<!-- /name -->` is replaced; the rest stays as it is.
#
#   scripts/numerics.sh           tables and pictures, a few minutes
#   scripts/numerics.sh --soak    and 100,000,000 rays against a closed mesh
set -euo pipefail
cd "$(dirname "$0")/.."
work=target/numerics
page=docs/numerics.md
rm -rf "$work"
mkdir -p "$work"

cargo build --release
cargo build --release --features f32 --target-dir target/f32
double=target/release/a2
single=target/f32/release/a2

# Replaces the part of the page between the lines of this name by standard input.
fill() {
    cat > "$work/part"
    awk -v name="$1" -v part="$work/part" '
        $0 == "<!-- /" name " -->" { inside = 0 }
        !inside { print }
        $0 == "<!-- " name " -->" { inside = 1; while ((getline line < part) > 0) print line }
    ' "$page" > "$work/page"
    cp "$work/page" "$page"
}

# --- cases ---
A2_NUMERICS_TABLE="$PWD/$work/f64.tsv" cargo test --release --test numerics -- --skip queries:: > "$work/f64.log"
A2_NUMERICS_TABLE="$PWD/$work/f32.tsv" A2_NUMERICS_KEEP_GOING=1 \
    cargo test --release --features f32 --target-dir target/f32 --test numerics --no-fail-fast > "$work/f32.log" 2>&1 || true

awk -F'\t' '
    function worst(seen, case, value) { if (!(case in seen) || value + 0 > seen[case] + 0 || value == "NaN") seen[case] = value }
    function short(x) { return x == int(x) && x < 1e6 ? sprintf("%d", x) : sprintf("%.2g", x) }
    function shown(case, value) {
        if (value == "NaN" || value == "inf") return "no answer"
        if (yes_or_no[case]) return value > 0 ? "no" : "yes"
        return short(value)
    }
    FNR == NR { if (!($1 in ours)) order[++count] = $1; bound[$1] = $2; worst(ours, $1, $3); next }
    { worst(theirs, $1, $3); if ($1 in bound) limit[$1] = $2 }
    END {
        print "| case | bound | f64 | f32 |"
        print "|---|---|---|---|"
        for (i = 1; i <= count; i++) {
            case = order[i]
            yes_or_no[case] = case !~ /(acne|leaks|hits|lost|points|rays|bytes|answers|decisions|origins|normals|missed|colours|pictures|differ)/ && bound[case] == 0 && (ours[case] == 0 || ours[case] == 1)
            f32 = (case in theirs) ? shown(case, theirs[case]) : "no answer"
            fails = !(case in theirs) || theirs[case] == "NaN" || theirs[case] == "inf" || theirs[case] + 0 > bound[case] + 0
            failed += fails
            printf "| %s | %s | %s | %s |\n", case, yes_or_no[case] ? "yes" : short(bound[case]), shown(case, ours[case]), fails ? "**" f32 "**" : f32 | "sort"
        }
        close("sort")
        printf "\n%d cases. Single precision fails %d of them (bold).\n", count, failed
        print failed > "'"$work"'/failed"
    }
' "$work/f64.tsv" "$work/f32.tsv" > "$work/cases.md"
fill cases < "$work/cases.md"

# --- single against double precision over the seven scenes ---
# The flags of a scene of the course's batch.
flags() {
    awk -v scene="$(basename "$1" .txt)" '
        $2 == scene { near = $3; far = $4; $1 = $2 = $3 = $4 = ""; print $0, "-depth", near, far }' data/batch.txt
}
render() { # binary scene name
    # The depth picture comes last, so that its name completes the flags.
    # shellcheck disable=SC2046
    "$1" -quiet -input "$2" -size 400 400 -output "$work/$3.png" -normals "$work/$3n.png" $(flags "$2") "$work/$3d.png"
}
over() { "$double" -compare "$1" "$2" | awk -v levels="$3" '$1 == "over" && $2 == levels { print $4 }'; }
{
    echo "| scene | colour: pixels changed, by over 8 levels | normals | depth |"
    echo "|---|---|---|---|"
    for scene in data/scene0*.txt; do
        name=$(basename "$scene" .txt)
        render "$double" "$scene" f64
        render "$single" "$scene" f32
        echo "| $name | $(over "$work/f64.png" "$work/f32.png" 0), $(over "$work/f64.png" "$work/f32.png" 8)" \
            "| $(over "$work/f64n.png" "$work/f32n.png" 0), $(over "$work/f64n.png" "$work/f32n.png" 8)" \
            "| $(over "$work/f64d.png" "$work/f32d.png" 0), $(over "$work/f64d.png" "$work/f32d.png" 8) |"
    done
    echo
    echo "400 x 400 pixels each. Of the cases above, f32 loses $(cat "$work/failed"), f64 none."
} > "$work/precision.md"
fill precision < "$work/precision.md"

# --- three failures ---
still_life() { # scale, centre of everything
    awk -v s="$1" -v c="$2" 'BEGIN {
        printf "PerspectiveCamera { center %.17g %.17g %.17g direction 0 -0.45 -1 up 0 1 0 angle 40 }\n", c, 3 * s, 6 * s
        printf "Lights { numLights 1 DirectionalLight { direction -0.6 -1 -0.35 color 0.9 0.9 0.85 } }\n"
        printf "Background { color 0.35 0.45 0.6 ambientLight 0.12 0.12 0.15 }\n"
        printf "Materials { numMaterials 4 Material { diffuseColor 0.8 0.25 0.2 } Material { diffuseColor 0.25 0.6 0.3 } Material { diffuseColor 0.85 0.8 0.7 } Material { diffuseColor 0.3 0.4 0.8 } }\n"
        printf "Group { numObjects 5 MaterialIndex 2 Plane { normal 0 1 0 offset 0 }\n"
        printf "MaterialIndex 0 Sphere { center %.17g %.17g %.17g radius %.17g }\n", c - 1.3 * s, 0.9 * s, -0.6 * s, 0.9 * s
        printf "MaterialIndex 1 Sphere { center %.17g %.17g %.17g radius %.17g }\n", c + 0.5 * s, 0.5 * s, 0.6 * s, 0.5 * s
        printf "MaterialIndex 3 Transform { Translate %.17g %.17g %.17g YRotate 30 Scale %.17g %.17g %.17g Sphere { center 0 0 0 radius 1 } }\n", c + 1.6 * s, 0.35 * s, -0.4 * s, 0.8 * s, 0.35 * s, 0.8 * s
        printf "Triangle { vertex0 %.17g 0 %.17g vertex1 %.17g 0 %.17g vertex2 %.17g %.17g %.17g } }\n", c - 0.4 * s, -1.6 * s, c + 1.2 * s, -1.9 * s, c + 0.4 * s, 1.8 * s, -1.8 * s
    }'
}
picture() { # binary scene name flags...
    "$1" -quiet -input "$work/$2.txt" -size 240 180 -shadows -output "docs/numerics-$3.png" "${@:4}"
}
still_life 1e6 0 > "$work/large.txt"
still_life 0.01 0 > "$work/small.txt"
still_life 1 1e6 > "$work/far.txt"
picture "$single" large 1-f32
picture "$double" large 1-ours -robust
picture "$double" small 2-default
picture "$double" small 2-ours -robust
picture "$single" far 3-f32
picture "$double" far 3-ours -robust

# --- the long run ---
if [ "${1:-}" = --soak ]; then
    cargo test --release --test numerics -- --ignored --nocapture soak | grep leaks | fill soak
fi
