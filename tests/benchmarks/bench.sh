#!/bin/sh
# The benchmarks; what ./flexopt bench calls.
#
#   bench.sh                      lists them, a sentence each: the first line of each program
#   bench.sh --targets NAME...    what has to be built for them
#   bench.sh BUILD NAME...        runs them from the folder BUILD and writes their tables into pages
#
# A program prints each table between the markers "<!-- bench NAME PART -->" and "<!-- end bench -->";
# every page of the repository that has the same markers gets the table in place of the one it had.
# Exit code 2: no such benchmark; 1: a benchmark failed, and no page was changed by it.
set -u
here=$(CDPATH='' cd -- "$(dirname -- "$0")" && pwd -P) || exit 1
root=$(CDPATH='' cd -- "$here/../.." && pwd -P) || exit 1

list() {
  for source in "$here"/*.cpp; do
    name=${source##*/}
    printf '  %-18s %s\n' "${name%.cpp}" "$(sed -n '1s,^// ,,p' "$source")"
  done
}

known() {
  for name; do
    [ -f "$here/$name.cpp" ] && continue
    printf 'flexopt: no benchmark "%s"; there are:\n' "$name" >&2
    list >&2
    exit 2
  done
}

# into_page TABLES PAGE: the page with each of its tables that TABLES has replaced.
into_page() {
  awk '
    FNR == NR {
      if (/^<!-- bench /) { name = $0; table[name] = "" }
      else if (/^<!-- end bench -->/) name = ""
      else if (name != "") table[name] = table[name] $0 "\n"
      next
    }
    /^<!-- bench / && ($0 in table) { print; printf "%s", table[$0]; skip = 1; next }
    /^<!-- end bench -->/ { skip = 0 }
    !skip
  ' "$1" "$2"
}

case ${1:-} in
  '')
    echo "./flexopt bench NAME runs one of these and writes its tables into the pages:"
    list
    echo "In tests/benchmarks, with Python: calculix (solid elements), kills."
    exit 0
    ;;
  --targets)
    shift
    known "$@"
    printf 'bench_%s ' "$@"
    exit 0
    ;;
esac

build=$1
shift
known "$@"
work=$(mktemp -d) || exit 1
trap 'rm -rf "$work"' EXIT
for name; do
  { (cd "$root" && "$build/bench_$name"); echo $? >"$work/status"; } | tee "$work/tables"
  [ "$(cat "$work/status")" = 0 ] || {
    echo "flexopt: the benchmark $name failed; no page was changed" >&2
    exit 1
  }
  find "$root" \( -name build -o -name node_modules -o -name '*.out' \) -prune -o -name '*.md' -print |
    while IFS= read -r page; do
      into_page "$work/tables" "$page" >"$work/page" || exit 1
      cmp -s "$work/page" "$page" && continue
      cat "$work/page" >"$page"
      echo "flexopt: wrote ${page#"$root"/}" >&2
    done
done
