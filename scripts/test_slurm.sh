#!/usr/bin/env bash
# Tests scripts/cluster/slurm.sh on a private Slurm, which it starts on the loopback interface of this machine and stops.
#
#   scripts/test_slurm.sh          two nodes; one of them and its task are killed in the middle of the job (some 4 minutes)
#   scripts/test_slurm.sh short    one node, nothing is killed
#
# The picture must be that of a single run, byte for byte. Slurm and munge are installed if they are missing, where that is
# allowed. SIZE, PARTS and TASKS are those of the job.
set -euo pipefail

# shellcheck source=scripts/program.sh
source "$(dirname "$0")/program.sh"
size=${SIZE:-1600} parts=${PARTS:-64} tasks=${TASKS:-8}
nodes=(n1 n2)
if [ "${1:-}" = short ]; then
    nodes=(n1) size=${SIZE:-400} parts=${PARTS:-8} tasks=${TASKS:-3}
fi
if ! command -v slurmctld slurmd munged sbatch >/dev/null; then
    apt-get install -y --no-install-recommends slurm-wlm munge >/dev/null
fi

# munge wants a folder that all may enter.
state=$(mktemp -d)
chmod 755 "$state"
mkdir "$state/state" "$state/spool" "$state/log" "$state/munge"
export SLURM_CONF=$state/slurm.conf
pids=()

# Prints the processes of our Slurm whose environment has a further line, such as that of a node, and before each the
# slurmstepd that started it, which has another environment.
ours() {
    local process environment parent
    for process in /proc/[0-9]*; do
        # It may have ended meanwhile.
        environment=$({ tr '\0' '\n' <"$process/environ"; } 2>/dev/null) || continue
        if grep -qxF "SLURM_CONF=$SLURM_CONF" <<<"$environment" && grep -qxE "$1" <<<"$environment"; then
            parent=$(awk '/^PPid:/ { print $2 }' "$process/status" 2>/dev/null) || continue
            [ "$(cat "/proc/$parent/comm" 2>/dev/null)" != slurmstepd ] || echo "$parent"
            echo "${process#/proc/}"
        fi
    done
}

clean_up() {
    local code=$? pid
    for pid in "${pids[@]}"; do kill "$pid" 2>/dev/null || true; done
    sleep 1
    for pid in $(ours "A2_TEST_NODE=.*|SLURMD_NODENAME=.*"); do kill -9 "$pid" 2>/dev/null || true; done
    [ $code -eq 0 ] || tail -n 20 "$state"/log/* >&2
    rm -rf "$state"
}
trap clean_up EXIT

user=$(id -un)
cat >"$SLURM_CONF" <<CONF
ClusterName=test
SlurmctldHost=$(hostname)(127.0.0.1)
SlurmUser=$user
SlurmdUser=$user
AuthType=auth/munge
AuthInfo=socket=$state/munge/munge.socket.2
CredType=cred/munge
SlurmctldPort=16817
StateSaveLocation=$state/state
SlurmdSpoolDir=$state/spool/%n
SlurmctldPidFile=$state/slurmctld.pid
SlurmdPidFile=$state/slurmd-%n.pid
SlurmctldLogFile=$state/log/slurmctld
SlurmdLogFile=$state/log/slurmd-%n
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SwitchType=switch/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
CommunicationParameters=NoInAddrAny,NoCtldInAddrAny
SlurmdParameters=config_overrides
SlurmdTimeout=10
ReturnToService=2
$(for i in "${!nodes[@]}"; do
    echo "NodeName=${nodes[i]} NodeHostname=$(hostname) NodeAddr=127.0.0.1 Port=$((16818 + i)) CPUs=1 State=UNKNOWN"
done)
PartitionName=main Nodes=ALL Default=YES MaxTime=INFINITE State=UP
CONF
dd if=/dev/urandom of="$state/munge/key" bs=1024 count=1 status=none
chmod 400 "$state/munge/key"
munged --foreground --key-file "$state/munge/key" --socket "$state/munge/munge.socket.2" --pid-file "$state/munge/pid" \
    --log-file "$state/log/munged" --seed-file "$state/munge/seed" >/dev/null 2>&1 &
pids+=($!)
sleep 2
slurmctld -D >/dev/null 2>&1 &
pids+=($!)
sleep 2
for node in "${nodes[@]}"; do
    A2_TEST_NODE=$node slurmd -D -N "$node" >/dev/null 2>&1 &
    pids+=($!)
done
for _ in $(seq 60); do
    [ "$(sinfo --noheader --Node --states=idle --format=%N | wc -l)" -eq ${#nodes[@]} ] && break
    sleep 1
done
sinfo

scene=$project/data/scene06_bunny_1k.txt
flags=(-input "$scene" -size "$size" "$size" -bounces 4 -jitter -filter)
start=$SECONDS
WAIT=1 "$project/scripts/cluster/slurm.sh" "$state/out.png" "$parts" "$tasks" "${flags[@]}" &
job=$!
if [ ${#nodes[@]} -gt 1 ]; then
    # In the middle: when a quarter of the parts are there.
    until [ "$(find "$state/out.png.parts" -name '[0-9]*.png' 2>/dev/null | wc -l)" -ge $((parts / 4)) ]; do sleep 0.2; done
    until [ -n "$(ours SLURMD_NODENAME=n2)" ]; do sleep 0.2; done
    squeue
    killed=$(ours "A2_TEST_NODE=n2|SLURMD_NODENAME=n2" | tr '\n' ' ')
    # One of them may have ended meanwhile, but not all.
    # shellcheck disable=SC2086 # numbers of processes
    kill -9 $killed 2>/dev/null || { echo "error: nothing ran on node n2" >&2; exit 1; }
    echo "after $((SECONDS - start)) s node n2 and its task are killed (processes $killed)"
fi
wait $job
echo "the job has ended after $((SECONDS - start)) s"
"$A2" "${flags[@]}" -output "$state/whole.png" -quiet
cmp "$state/out.png" "$state/whole.png"
echo "ok: $parts parts in $tasks tasks on ${#nodes[@]} node(s) make the picture of a single run, byte for byte"
