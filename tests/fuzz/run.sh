#!/bin/sh
# tests/fuzz/run.sh BUILD SECONDS [TARGET...]: every fuzzer that was built in BUILD, so long each, one on each processor,
# from the corpus; of jobs and designs from the gallery and the library too.
# FUZZ_SEED: of the random changes, for the same texts again on a machine as fast.
# Exit code 1 where one has found something; its input stands beside the log that is named.
set -u
build=$1 seconds=$2
shift 2
root=$(cd "$(dirname "$0")/../.." && pwd) || exit 2
[ $# -gt 0 ] || set -- job design log formula unit set request
built=
for target; do
  [ ! -x "$build/fuzz_$target" ] || built="$built $target"
done
set -- $built
[ $# -gt 0 ] || { echo "no fuzzer in $build" >&2; exit 2; }
if [ $# -gt 1 ]; then # each on a processor of its own
  printf '%s\n' "$@" | xargs -P "$(nproc)" -n 1 "$0" "$build" "$seconds" || exit 1
  exit 0
fi

target=$1
work=$build/fuzzed/$target
mkdir -p "$work/texts"
words=
[ ! -x "$build/fuzz_dictionary" ] || { "$build/fuzz_dictionary" >"$work/words" && words=-dict=$work/words; }
case $target in
  job) more=$root/designs/jobs ;;
  design) more=$root/designs/families ;;
  *) more= ;;
esac
"$build/fuzz_$target" $words -max_total_time="$seconds" -seed="${FUZZ_SEED:-0}" -timeout=10 -print_final_stats=1 \
  -artifact_prefix="$work/" "$work/texts" "$root/tests/fuzz/corpus/$target" $more >"$work/log" 2>&1 ||
  { echo "$target: see $work/log"; exit 1; }
sed -n "s/^stat::number_of_executed_units: */$target: texts /p" "$work/log"
