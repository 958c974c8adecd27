#!/usr/bin/env bash
# Renders a picture on a Slurm cluster: a job array renders parts, and a second job merges them once all are there.
#
#   scripts/cluster/slurm.sh OUT.png PARTS TASKS -input SCENE.txt -size W H [further flags of a2]
#
# PARTS parts of the picture are spread over TASKS tasks of the array, because clusters ask for few job starts: choose
# PARTS so that a part takes seconds, and TASKS so that a task takes minutes. Part I is OUT.png.parts/I.png. A task that is
# started again (the node failed, or the job was requeued) leaves the parts alone that are done. If a task fails, nothing
# is merged; the same command, given again, renders only what is missing.
#
# A2 is the program on all nodes [default: a2 in the PATH]; SBATCH_FLAGS are further flags for the array, as in
# SBATCH_FLAGS="--partition=short --cpus-per-task=8". WAIT=1 waits until the picture is there.
set -euo pipefail
[ $# -ge 5 ] || { sed -n '2,/^set /{s/^# \{0,1\}//;/^set /d;p}' "$0"; exit 2; }
out=$1 parts=$2 tasks=$3
shift 3
a2=${A2:-a2}
mkdir -p "$out.parts"
touch "$out.parts/begun"

# Task T renders the parts T, T + TASKS, T + 2 TASKS ...; `exec` would lose the exit code of all but the last.
read -r -d '' task <<'TASK' || true
#!/usr/bin/env bash
set -euo pipefail
out=$1 parts=$2 tasks=$3 a2=$4
shift 4
for ((part = SLURM_ARRAY_TASK_ID; part <= parts; part += tasks)); do
    "$a2" "$@" -tile "$part/$parts" -output "$out.parts/$part.png" -skip-done -quiet &
    # A shell forwards no signals by itself: SIGTERM ends the program, and then this task.
    trap 'kill -TERM $! 2>/dev/null || true; wait $!; exit 143' TERM
    wait $!
done
TASK
read -r -d '' merge <<'MERGE' || true
#!/usr/bin/env bash
set -euo pipefail
out=$1 parts=$2 a2=$3
files=()
for ((part = 1; part <= parts; part++)); do files+=("$out.parts/$part.png"); done
exec "$a2" -merge "$out" "${files[@]}"
MERGE
# shellcheck disable=SC2086 # SBATCH_FLAGS are words.
job=$(sbatch --parsable --requeue --array="1-$((tasks < parts ? tasks : parts))" --job-name=a2 \
    --output="$out.parts/log-%a.txt" ${SBATCH_FLAGS:-} <(echo "$task") "$out" "$parts" "$tasks" "$a2" "$@")
echo "array job $job renders $parts parts" >&2
sbatch --parsable --dependency="afterok:${job%%;*}" --kill-on-invalid-dep=yes --job-name=a2-merge \
    --output="$out.parts/log-merge.txt" ${WAIT:+--wait} <(echo "$merge") "$out" "$parts" "$a2"
# A job that is cancelled because a part has failed ends without an error.
if [ -n "${WAIT:-}" ] && ! [ "$out" -nt "$out.parts/begun" ]; then
    echo "nothing is merged: see $out.parts/log-*.txt" >&2
    exit 1
fi
