#!/bin/bash
# A sweep on hosts that ssh reaches without a password, and where this folder has the same name; bash runs it anywhere.
# It starts again while the sweep stops early (a host lost, the network cut), 20 times at most, a minute apart.
set -u
spec=$1
table=$2
bin=$3
writer=$4
ranks=$5
shards=$6
hosts=$7
most_tries=20

again() { # COMMAND...
    for ((try = 0; try <= most_tries; try++)); do
        "$@"
        local status=$?
        [ "$status" -eq 75 ] || [ "$status" -eq 255 ] || return "$status" # 255 is ssh's own: no connection
        sleep 60
    done
    return 75
}

export OMP_NUM_THREADS=1 NUMBA_NUM_THREADS=1
if [ -z "$shards" ]; then
    again "$bin/mpirun" -hosts "$hosts" -n "$ranks" "$bin/sweep" run "$spec" -o "$table" --writer "$writer"
    exit $?
fi

# Shards never talk: each runs on the next host, and all at once.
IFS=, read -r -a names <<<"$hosts"
shard() { # INDEX HOST
    local words=("$bin/sweep" run "$spec" -o "${table%.h5}-$1-of-$shards.h5" --writer "$writer" --shard "$1/$shards")
    [ "$ranks" -le 1 ] || words=("$bin/mpirun" -n "$ranks" "${words[@]}")
    again ssh "$2" "$(printf '%q ' "${words[@]}")"
}
worst=0
for ((index = 1; index <= shards; index++)); do
    shard "$index" "${names[(index - 1) % ${#names[@]}]%%:*}" &
done
for job in $(jobs -p); do
    wait "$job" || worst=$?
done
exit "$worst"
