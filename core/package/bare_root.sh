#!/bin/sh
# Installs packages into a bare Debian 12 and runs a job there: no compiler, none of our sources.
#
#   sh bare_root.sh PACKAGES ROOT
#
# PACKAGES: folder with the .deb files. ROOT: folder of the new system, made by debootstrap where there
# is none; the container recipe gives "/", a system that is there already. Needs root. Exit code 0: the
# program, the C++ library's runtime and the Python module answer as they should.
set -eu
packages=$(cd "$1" && pwd)
root=$2

if [ "$root" != / ] && [ ! -e "$root/etc/debian_version" ]; then
  debootstrap --variant=minbase bookworm "$root" "${DEBIAN_MIRROR:-http://deb.debian.org/debian}"
fi
inside() {
  if [ "$root" = / ]; then env "$@"; else chroot "$root" env PATH=/usr/sbin:/usr/bin:/sbin:/bin "$@"; fi
}
from=/tmp/flexopt_packages
rm -rf "${root%/}$from"
mkdir -p "${root%/}$from"
cp "$packages"/*.deb "${root%/}$from"
inside apt-get update -q
begin=$(date +%s)
inside sh -c "DEBIAN_FRONTEND=noninteractive apt-get install -q -y --no-install-recommends $from/flexopt_*.deb \
  $from/libflexopt0*.deb $from/python3-flexopt_*.deb"
echo "installed in $(($(date +%s) - begin)) s"
for compiler in cc c++ gcc g++ clang; do
  inside sh -c "command -v $compiler" >/dev/null && { echo "$compiler is here: not a bare system"; exit 1; }
done

inside flexopt --version
inside sh -c 'LD_DEBUG=libs flexopt --version 2>&1 >/dev/null' |
  sed -n 's/.*calling init: \(.*libflexopt.*\)/the loader takes \1/p'
jobs=/usr/share/doc/flexopt/examples
begin=$(date +%s)
inside flexopt run "$jobs/three_flexure_cross_hinge.json" --quiet --out /tmp/hinge.out
echo "first result after $(($(date +%s) - begin)) s"
[ -s "${root%/}/tmp/hinge.out/report.html" ] || { echo "no report"; exit 1; }
# As an older processor would: the first set.
inside /lib64/ld-linux-x86-64.so.2 --glibc-hwcaps-mask none /usr/bin/flexopt \
  run "$jobs/three_flexure_cross_hinge.json" --quiet --out /tmp/hinge_first.out
inside python3 - <<'END'
import json, flexopt
job = "/usr/share/doc/flexopt/examples/parallel_guide.json"
r = flexopt.evaluate(job, gradients=["thickness"])
print("python:", flexopt.__version__, r.status, r["drive_load"][-1], r.gradients["drive_load"]["thickness"][-1])
assert r.status == "ok" and abs(r["drive_load"][-1] / 35.25 - 1) < 1e-3
first, chosen = (json.load(open(f"/tmp/{name}.out/result.json"))["optimum"]["objective"]
                 for name in ("hinge_first", "hinge"))
print("objective, first and chosen set of instructions:", first, chosen)
assert abs(first / chosen - 1) < 1e-4
END
echo "the packages work"
