#!/bin/sh
# What packages would be made, without compiling anything: sh test_packages.sh SOURCE FOLDER
set -eu
source=$1
folder=$2
recipe=$source/core/package/Containerfile
problem() { echo "FAILED: $*"; exit 1; }

# --- the container recipe: known instructions, stages and files that are there
unknown=$(awk '/\\$/ { joined = joined substr($0, 1, length($0) - 1); next }
  { print joined $0; joined = "" }' "$recipe" |
  grep -v '^#\|^$\|^\(FROM\|COPY\|WORKDIR\|RUN\|ENTRYPOINT\|CMD\) ' || :)
[ -z "$unknown" ] || problem "no instruction of a Containerfile: $unknown"
[ "$(grep -c '^FROM ' "$recipe")" = 2 ] || problem "one stage builds, the other runs"
stage=$(sed -n 's/^COPY --from=\([a-z]*\) .*/\1/p' "$recipe")
grep -q "^FROM .* AS $stage\$" "$recipe" || problem "no stage is called $stage"
sed -n 's/^ENTRYPOINT \(.*\)/\1/p; s/^CMD \(.*\)/\1/p' "$recipe" |
  python3 -c 'import json, sys; [json.loads(line) for line in sys.stdin]' || problem "no JSON"
grep -q '^  packages)$' "$source/flexopt" || problem "the launcher makes no packages"

# --- the packages
[ -d /usr/lib/cmake/pybind11 ] || [ -d /usr/share/cmake/pybind11 ] || { echo "no pybind11"; exit 77; }
rm -rf "$folder"
cmake -S "$source" --preset package -B "$folder" >"$folder.log" 2>&1 ||
  { cat "$folder.log"; problem "the preset does not configure"; }
config=$folder/CPackConfig.cmake
has() { grep -q "$1" "$config" || problem "CPackConfig.cmake has no $1"; }
version=$(sed -n 's/^project(flexopt VERSION \([0-9.]*\).*/\1/p' "$source/CMakeLists.txt")
short=${version%.*}
has "CPACK_DEBIAN_RUNTIME_PACKAGE_NAME \"libflexopt$short\""
has 'CPACK_DEBIAN_PROGRAM_PACKAGE_NAME "flexopt"'
has 'CPACK_DEBIAN_LIBRARY_PACKAGE_NAME "libflexopt-dev"'
has 'CPACK_DEBIAN_PYTHON_PACKAGE_NAME "python3-flexopt"'
has "CPACK_DEBIAN_PROGRAM_PACKAGE_DEPENDS \"libflexopt$short (= $version)\""
has 'CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS "python3 (>= 3.*python3-numpy"'
has 'CPACK_DEBIAN_PACKAGE_SHLIBDEPS "ON"'
for part in internals Unspecified; do
  grep 'CPACK_COMPONENTS_ALL ' "$config" | grep -q "$part" && problem "$part would be packed"
done
grep -q -- '-march=x86-64 ' "$folder/build.ninja" || problem "the first set is not that of every processor"
grep -q -- '-march=native' "$folder/build.ninja" && problem "compiled for this processor"
for set in x86-64-v3 x86-64-v4; do
  grep -q "FLEXOPT_INSTRUCTIONS=$set " "$folder/build.ninja" || problem "no set $set"
  [ "$(grep -c "glibc-hwcaps/$set\"" "$folder/cmake_install.cmake")" -ge 2 ] ||
    problem "the loader will not find $set, of the library or of the Python module"
done
for name in KLU LDL NLopt Ipopt; do
  grep -q "$name" "$folder/copyright" || problem "the terms of $name are missing"
done
grep -q 'Permission is hereby granted' "$folder/copyright" || problem "our own terms are missing"
grep -q @ "$folder/copyright" && problem "a name in the terms is not filled in"
echo "four packages of $version"
