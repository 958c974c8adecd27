#!/usr/bin/env bash
# Renders a picture with GNU parallel: on this machine, or on those of an ssh login file.
#
#   scripts/cluster/parallel.sh OUT.png PARTS -input SCENE.txt -size W H [further flags of a2]
#
# Part I is OUT.png.parts/I.png. If a part fails, the others go on, the exit code is that of parallel (the number of failed
# parts), and nothing is merged. The same command, given again, renders only the parts that failed or are missing.
#
# A2 is the program [default: a2 in the PATH]; JOBS is how many parts are rendered at once [default: 1, because a2 uses
# all processors itself]; PARALLEL_FLAGS are further flags, as in PARALLEL_FLAGS="--sshloginfile nodes --workdir $PWD".
set -euo pipefail
[ $# -ge 4 ] || { sed -n '2,/^set /{s/^# \{0,1\}//;/^set /d;p}' "$0"; exit 2; }
out=$1 parts=$2
shift 2
a2=${A2:-a2}
mkdir -p "$out.parts"
log=$out.parts/jobs.log
# Only a log of the same commands says what failed; a2 -skip-done sees to the rest.
command=$(printf '%q ' "$a2" "$@" -quiet -skip-done)"-tile {}/$parts -output $(printf %q "$out.parts")/{}.png"
resume=()
[ "$(cat "$out.parts/command" 2>/dev/null)" = "$command" ] && [ -s "$log" ] && resume=(--resume-failed)
echo "$command" >"$out.parts/command"
[ ${#resume[@]} -gt 0 ] || rm -f "$log"
# shellcheck disable=SC2086 # PARALLEL_FLAGS are words.
seq "$parts" | parallel --jobs "${JOBS:-1}" --joblog "$log" "${resume[@]}" ${PARALLEL_FLAGS:-} "$command"
files=()
for ((part = 1; part <= parts; part++)); do files+=("$out.parts/$part.png"); done
"$a2" -merge "$out" "${files[@]}"
