#!/bin/sh
# Every number of an equation is there once, and every reference points to one: equations.sh REPOSITORY
#
# A letter belongs to one page, or to the header that defines its equations (F chord_frame.hpp,
# C mixed_condensation.hpp). A number stands in brackets at the end of an indented line of a page, or
# of a comment.
set -eu
cd "$1"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

find core docs optim tests designs README.md CONTRIBUTING.md \( -name node_modules -o -name '*.out' \) \
  -prune -o \( -name '*.md' -o -name '*.hpp' -o -name '*.cpp' \) -print | sort >"$work/files"
xargs grep -HoE '^(    |///? +|// +).*\([A-Z][0-9]+\)$' <"$work/files" |
  grep -E '\.md:    |(chord_frame|mixed_condensation)\.hpp:' |
  sed -E 's/^([^:]*):.*\(([A-Z][0-9]+)\)$/\2 \1/' | sort >"$work/defined"
cut -d' ' -f1 "$work/defined" | uniq -d >"$work/twice"
cut -d' ' -f1 "$work/defined" | sort -u >"$work/numbers"
sed -E 's/^([A-Z])[0-9]+ /\1 /' "$work/defined" | sort -u | cut -d' ' -f1 | uniq -d >"$work/letters"
# References: in pages anywhere, in sources in comments.
{
  grep '\.md$' "$work/files" | xargs grep -noE '\([A-Z][0-9]+\)' -H
  grep -v '\.md$' "$work/files" | xargs grep -nE '//.*\([A-Z][0-9]+\)' -H |
    sed -E 's,^([^:]*:[0-9]+):.*//,\1:,' |
    awk -F: '{ rest = $0; while (match(rest, /\([A-Z][0-9]+\)/)) {
      print $1 ":" $2 ":" substr(rest, RSTART, RLENGTH); rest = substr(rest, RSTART + RLENGTH) } }'
} | tr -d '()' | sort >"$work/references"
awk -F: 'NR == FNR { known[$1]; next } !($3 in known) { print "  " $1 ":" $2 ": no equation (" $3 ")" }' \
  "$work/numbers" "$work/references" >"$work/missing"
sed 's/.*/  (&) is there twice/' "$work/twice" >>"$work/missing"
sed 's/.*/  the letter & is used by two pages/' "$work/letters" >>"$work/missing"
# Numbers that have no letter yet, after "equation" or beside a page's name.
grep -v 'optim/README' "$work/files" | xargs grep -nHE \
  '([Ee]quations?|README\.md|beams\.md|of),? \([0-9]+[a-d]?\)' | sed 's/^/  no letter: /' >>"$work/missing" || :

if [ "$(wc -l <"$work/numbers")" -lt 20 ] || [ "$(wc -l <"$work/references")" -lt 40 ]; then
  echo "hardly any equations found in $1: nothing was checked"
  exit 1
fi
if [ -s "$work/missing" ]; then
  echo "equations:"
  cat "$work/missing"
  exit 1
fi
echo "$(wc -l <"$work/numbers") equations, $(wc -l <"$work/references") references, all there"
