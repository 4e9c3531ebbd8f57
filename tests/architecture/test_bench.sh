#!/bin/sh
# Tests of ./flexopt bench with a stand-in for a benchmark: sh test_bench.sh PATH_OF_BENCH_SH
set -eu
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir -p "$work/repo/tests/benchmarks" "$work/repo/docs" "$work/build"
cp "$1" "$work/repo/tests/benchmarks/bench.sh"
echo "// What one and one is." >"$work/repo/tests/benchmarks/sum.cpp"
page=$work/repo/docs/page.md
printf 'before\n\n<!-- bench sum one -->\n\n| old |\n\n<!-- end bench -->\n\nafter\n<!-- bench other -->\n| kept |\n<!-- end bench -->\nend\n' >"$page"
cp "$page" "$work/page.before"
printf '#!/bin/sh\nprintf "said\\n<!-- bench sum one -->\\n\\n| 2 |\\n\\n<!-- end bench -->\\n"; exit $(cat "%s/code")\n' \
  "$work" >"$work/build/bench_sum"
chmod +x "$work/build/bench_sum"

problem() { echo "FAILED: $*"; exit 1; }
bench() { sh "$work/repo/tests/benchmarks/bench.sh" "$@" 2>"$work/err"; }

case $(bench) in *"sum "*"What one and one is."*) ;; *) problem "lists names and sentences" ;; esac
[ "$(bench --targets sum)" = "bench_sum " ] || problem "names the targets to build"
code=0
bench --targets product >/dev/null || code=$?
[ "$code" = 2 ] || problem "an unknown name: exit code 2, got $code"
grep -q "sum .*What one and one is." "$work/err" || problem "an unknown name: lists the known ones"

echo 3 >"$work/code"
code=0
bench "$work/build" sum >/dev/null || code=$?
[ "$code" = 1 ] || problem "a benchmark that fails: exit code 1, got $code"
cmp -s "$page" "$work/page.before" || problem "a benchmark that fails changes no page"

echo 0 >"$work/code"
bench "$work/build" sum >/dev/null || problem "runs: $(cat "$work/err")"
sed 's/| old |/| 2 |/' "$work/page.before" | cmp -s - "$page" || problem "writes its table alone: $(cat "$page")"
echo "the benchmarks write what they say"
