#!/usr/bin/env bash
# One shard of a study, as a task of a Slurm job array:
#
#     sbatch --array=1-8 --cpus-per-task=4 --time=01:00:00 scripts/slurm/shard.sh -o NAME DECK
#
# Task I of N runs shard I of N on as many threads as it has processors. A minute before its time is over
# Slurm sends USR1: the program puts what is finished into NAME.shard-I-of-N.h5 and ends, and the task is
# put into the queue again, where it goes on. GENTBEAM names the program, GENTBEAM_SHARDS the number of
# shards where the array is not 1-N (to run single shards again). scripts/slurm/submit writes the line
# above.
#SBATCH --job-name=gentbeam
#SBATCH --signal=B:USR1@60
#SBATCH --requeue
#SBATCH --open-mode=append
set -u

shards=${GENTBEAM_SHARDS:-$SLURM_ARRAY_TASK_COUNT}
"${GENTBEAM:-gentbeam}" --threads "${SLURM_CPUS_PER_TASK:-1}" --shard "$SLURM_ARRAY_TASK_ID/$shards" "$@" &
program=$!

# Whoever cancels the job sends TERM: then it shall not come back.
requeue=no
trap 'requeue=yes; kill -USR1 "$program" 2>/dev/null' USR1
trap 'requeue=no; kill -TERM "$program" 2>/dev/null' TERM

# A trap ends `wait` before the program has ended.
while :; do
    wait "$program"
    status=$?
    kill -0 "$program" 2>/dev/null || break
done

if [ "$requeue" = yes ] && [ "$status" -eq 4 ]; then
    echo "shard $SLURM_ARRAY_TASK_ID of $shards was stopped before its end and goes back into the queue"
    scontrol requeue "${SLURM_ARRAY_JOB_ID}_$SLURM_ARRAY_TASK_ID"
fi
exit "$status"
