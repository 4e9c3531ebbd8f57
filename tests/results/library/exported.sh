#!/bin/sh
# The symbols that a shared library shows: sh exported.sh LIBRARY. Those of flexopt.hpp, and the command
# line for the program; no header of another library may leak through it.
shown=$(nm -D --defined-only "$1" | awk '{ print $NF }') || exit 1
[ "$(printf '%s\n' "$shown" | grep -c '^_ZNK\{0,1\}7flexopt2v0')" -gt 40 ] ||
  { echo "the names of flexopt.hpp are missing"; exit 1; }
printf '%s\n' "$shown" | grep -qx flexopt_program || { echo "flexopt_program is missing"; exit 1; }
others=$(printf '%s\n' "$shown" | grep -v '^_ZNK\{0,1\}7flexopt2v0\|^_ZT[ISV]N7flexopt2v0\|^flexopt_program$')
[ -z "$others" ] || { echo "these are shown too:"; printf '%s\n' "$others" | head -20; exit 1; }
echo "$(printf '%s\n' "$shown" | wc -l) names"
