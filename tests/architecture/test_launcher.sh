#!/bin/sh
# Tests of ./flexopt with stand-ins for everything it calls: sh test_launcher.sh PATH_OF_LAUNCHER
set -eu
unset FLEXOPT_NO_INSTALL  # the caller's own choice is not what is tested
launcher=$1
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir -p "$work/repo/core" "$work/repo/designs/jobs" "$work/repo/optim" \
  "$work/repo/results/report" "$work/bin"
cp "$launcher" "$work/repo/flexopt"
touch "$work/repo/CMakeLists.txt" "$work/repo/CMakePresets.json" "$work/repo/core/a.cpp"

# Each stand-in notes how it was called. FAKE_MISSING is a Debian package that is not there yet.
stand_in() { printf '#!/bin/sh\necho "%s $*" >>"%s/calls"\n%s\n' "$1" "$work" "$2" >"$work/bin/$1"
  chmod +x "$work/bin/$1"; }
# It builds in three steps, as ninja shows them.
stand_in cmake "case \$1 in --build) mkdir -p build/release
  printf '#!/bin/sh\necho program \"\$@\"; exit 7\n' >build/release/flexopt
  chmod +x build/release/flexopt
  printf '[0/2] Re-checking globbed directories...\n'
  for k in 1 2 3; do printf \"\${NINJA_STATUS:+[\$k/3] }Building object \$k\n\"; done;; esac"
stand_in ctest ''
stand_in npm ''
stand_in node ''
stand_in sudo '"$@"'
stand_in apt-get ''
stand_in dpkg-query 'for last; do :; done
case $last in "${FAKE_MISSING:-}") exit 1;; esac; printf "installed"'
PATH=$work/bin:$PATH
export PATH

problem() { echo "FAILED: $*"; echo "calls:"; cat "$work/calls"; exit 1; }
called() { grep -q -- "$1" "$work/calls"; }
# start ARGUMENTS: runs the launcher; sets `code`, `out`, `err`, and the file of calls.
start() {
  : >"$work/calls"
  code=0
  "$work/repo/flexopt" "$@" >"$work/out" 2>"$work/err" || code=$?
  out=$(cat "$work/out")
  err=$(cat "$work/err")
}
# A build counts from its second on: step back what was made, so that "newer" means something.
age() { find "$work/repo" -exec touch -d '1 hour ago' {} +; touch "$work/repo/build/release/.built"; }

start run job.json --out 'a folder'
[ "$code" = 7 ] || problem "the program's exit code is handed on, got $code: $err"
[ "$out" = "program run job.json --out a folder" ] || problem "arguments are handed on: $out"
called "cmake --preset release" || problem "configures with the preset release"
called "cmake --build --preset release --target flexopt" || problem "builds the program alone"
called "apt-get" && problem "installs nothing when nothing is missing"

case $err in *"building 33 % (1 of 3)"*"building 100 % (3 of 3)"*) ;;
  *) problem "shows how far the build is: $err" ;; esac
case $err in *object*) problem "keeps the build's log to itself: $err" ;; esac
grep -q "Building object 2" "$work/repo/build/release/build.log" || problem "keeps the build's log"
called "FLEXOPT_BENCHMARKS=ON" && problem "the program needs no benchmarks"

age
start designs
[ -s "$work/calls" ] && problem "a warm start calls nothing"
[ "$out" = "program designs" ] || problem "a warm start runs the program"

sleep 0.01
touch "$work/repo/core/a.cpp"
start designs
called "cmake --build" || problem "a newer source is built"

age
sleep 0.01
rm "$work/repo/core/a.cpp"
start designs
called "cmake --build" || problem "a removed source is noticed"

age
sleep 0.01
touch "$work/repo/designs/jobs/job.json"
start designs
called "cmake --build" && problem "a job file is no source"

age
echo "another processor" >"$work/repo/build/release/.built"
start designs
called "cmake --build" || problem "another processor means another build"

rm -r "$work/repo/build"
FAKE_MISSING=libeigen3-dev FLEXOPT_NO_INSTALL=1 start designs
[ "$code" = 4 ] || problem "forbidden to install what is missing: exit code 4, got $code"
case $err in *libeigen3-dev*) ;; *) problem "names the missing package: $err" ;; esac
called "apt-get" && problem "installs although forbidden"
called "^cmake " && problem "builds although a package is missing"

FAKE_MISSING=libeigen3-dev start designs
called "apt-get update" || problem "updates the package lists"
called "apt-get install .*libeigen3-dev" || problem "installs the missing package"
called "apt-get install .*libfmt-dev" && problem "installs a package that is there"
case $err in *"installing Debian packages: libeigen3-dev"*) ;; *) problem "says so first: $err" ;; esac

rm -r "$work/repo/build"
echo '{}' >"$work/repo/results/report/package-lock.json"
stand_in npm 'mkdir -p node_modules'
FLEXOPT_NO_INSTALL=1 start designs
[ "$code" = 4 ] || problem "forbidden to fetch npm packages: exit code 4, got $code"
start designs
called "npm ci" || problem "fetches the report's libraries"

start test -R units
called "cmake --build --preset release --target all" || problem "test builds everything"
called "ctest --preset release .*-R units" || problem "test runs ctest with its options"
called "FLEXOPT_BENCHMARKS=OFF" || problem "test leaves the benchmarks out"
FAKE_MISSING=chromium start test
called "apt-get install .*chromium" || problem "test installs the browser for the reports"
FAKE_MISSING=chromium FLEXOPT_NO_INSTALL=1 start test
called "ctest --preset release" || problem "test runs without the browser where nothing may be installed"
FAKE_MISSING=chromium start run job.json
called "apt-get install" && problem "the program needs no browser"
FAKE_MISSING=python3-pytest start test
called "apt-get install .*python3-pytest" || problem "test installs what the Python module's tests need"

FAKE_MISSING=furo start test
called "apt-get install .*furo" || problem "test installs what builds the site"
age
mkdir -p "$work/repo/docs/site"
echo 'import sys; print("site", *sys.argv[1:])' >"$work/repo/docs/site/build.py"
FAKE_MISSING=python3-myst-parser start docs
called "apt-get install .*python3-myst-parser" || problem "docs installs what builds the site"
[ "$out" = "site $work/repo/build/release/flexopt $work/repo/build/docs $work/repo/build/release/tests/jobs" ] ||
  problem "docs builds the site with the program: $out"
FAKE_MISSING=furo start run job.json
called "apt-get install" && problem "the program needs no Sphinx"

FAKE_MISSING=calculix-ccx start test
called "apt-get install .*calculix-ccx" || problem "test installs what reads exported files"
FAKE_MISSING=calculix-ccx start run job.json
called "apt-get" && problem "a run needs no CalculiX"

FAKE_MISSING=pybind11-dev start python -c 'import os; print(os.environ["PYTHONPATH"])'
called "apt-get install .*pybind11-dev" || problem "python installs what the module needs"
called "FLEXOPT_PYTHON=ON" || problem "python configures with the module"
called "cmake --build --preset release --target flexopt flexopt_python" || problem "python builds it"
case $out in "$work/repo/build/release/python"*) ;; *) problem "Python finds the module: $out" ;; esac
start python -c 'raise SystemExit(3)'
[ -s "$work/calls" ] && problem "a warm start of Python calls nothing"
[ "$code" = 3 ] || problem "Python's exit code is handed on, got $code"

stand_in cpack 'touch build/package/flexopt_1_amd64.deb'
mkdir -p "$work/repo/build/package"
FAKE_MISSING=dpkg-dev start packages
called "apt-get install .*dpkg-dev" || problem "packages installs what makes them"
called "cmake --build --preset package" || problem "packages builds them"
called "cpack --preset package" || problem "packages makes them"
[ "$out" = "$work/repo/build/package/flexopt_1_amd64.deb" ] || problem "packages tells their names: $out"

stand_in ctest 'exit 8'
start test
[ "$code" = 8 ] || problem "the exit code of ctest is handed on, got $code"

mkdir -p "$work/repo/tests/benchmarks"
cat >"$work/repo/tests/benchmarks/bench.sh" <<'END'
case ${1:-} in
  --targets) [ "$2" = sum ] || exit 2; echo bench_sum ;;
  *) echo "bench.sh $*" ;;
esac
END
start bench
[ "$out" = "bench.sh " ] || problem "bench lists the benchmarks: $out"
[ -s "$work/calls" ] && problem "a list needs no build"
start bench nothing
[ "$code" = 2 ] || problem "an unknown benchmark: exit code 2, got $code"
called "cmake" && problem "an unknown benchmark is not built"
start bench sum
called "FLEXOPT_BENCHMARKS=ON" || problem "bench configures with the benchmarks"
called "cmake --build --preset release --target flexopt bench_sum" || problem "bench builds its program"
[ "$out" = "bench.sh $work/repo/build/release sum" ] || problem "bench runs it: $out"

# An installed program stands for a build where it was made from the same sources.
rm -r "$work/repo/build"
echo 'project(flexopt VERSION 1.2.3 LANGUAGES CXX)' >"$work/repo/CMakeLists.txt"
stand_in flexopt 'case $1 in --version) echo "flexopt 1.2.3 (${FAKE_COMMIT:-abc})";; *) echo "installed $*"; exit 5;; esac'
start run job.json
[ "$out" = "installed run job.json" ] || problem "sources without repository: the version counts: $out"
[ "$code" = 5 ] || problem "the installed program's exit code is handed on, got $code"
called "^cmake" && problem "builds although the same is installed"
FLEXOPT_BUILD=1 start designs
[ "$out" = "program designs" ] || problem "FLEXOPT_BUILD builds: $out"
start designs
[ "$out" = "program designs" ] || problem "what is built is preferred: $out"
rm -r "$work/repo/build"
sed -i s/1.2.3/1.2.4/ "$work/repo/CMakeLists.txt"
start designs
[ "$out" = "program designs" ] || problem "another version is not taken: $out"
sed -i s/1.2.4/1.2.3/ "$work/repo/CMakeLists.txt"
rm -r "$work/repo/build"
mkdir "$work/repo/.git"
stand_in git 'case "$*" in *describe*) echo "${FAKE_HEAD:-abc}";; *status*) printf "%s" "${FAKE_STATUS:-}";; esac'
start designs
[ "$out" = "installed designs" ] || problem "the same commit is taken: $out"
for differs in FAKE_HEAD=def FAKE_HEAD=abc-dirty "FAKE_STATUS=?? core/new.cpp" FAKE_COMMIT=abd; do
  start_with() { env "$differs" "$work/repo/flexopt" designs 2>/dev/null || :; }
  [ "$(start_with)" = "program designs" ] || problem "taken although $differs"
  rm -r "$work/repo/build"
done
start test
called "cmake --build --preset release --target all" || problem "tests are those of the sources"
rm -r "$work/repo/build"
stand_in python3 'case $2 in *__version__*) echo "flexopt 1.2.3 (${FAKE_MODULE:-abc})";; *) echo "python $*";; esac'
sed -i "s|^\[ -x /usr/bin/python3 \].*|python=$work/bin/python3|" "$work/repo/flexopt"
start python script.py
[ "$out" = "python script.py" ] || problem "runs a script: $out"
called "^cmake" && problem "builds although the same module is installed"
FAKE_MODULE=other start python script.py
called "FLEXOPT_PYTHON=ON" || problem "another module is not taken"
rm -r "$work/repo/build"
cp "$launcher" "$work/repo/flexopt"
cp "$work/repo/flexopt" "$work/bin/flexopt"  # a launcher is no installed program
start designs
[ "$out" = "program designs" ] || problem "a launcher in PATH is taken for a program: $out"
rm "$work/bin/flexopt" "$work/bin/git" "$work/bin/python3"
rmdir "$work/repo/.git"

# A build that fails at its second step: ninja's exit code must survive the progress line.
stand_in cmake 'case $1 in --build) echo "[1/9] Building object"; echo "FAILED: b.o"; exit 1;; esac'
touch "$work/repo/core/b.cpp"
start designs
[ "$code" = 4 ] || problem "a failed build: exit code 4, got $code"
case $out in *program*) problem "a failed build does not start the old program" ;; esac
case $err in *build/release/build.log*"FAILED: b.o"*) ;;
  *) problem "a failed build names its log and shows its end: $err" ;; esac
start designs
[ "$code" = 4 ] || problem "a failed build is tried again"
stand_in cmake 'echo "CMake Error: no Eigen"; exit 1'
start designs
[ "$code" = 4 ] || problem "a failed configuration: exit code 4, got $code"
case $err in *"CMake Error: no Eigen"*) ;; *) problem "shows why configuring failed: $err" ;; esac
echo "the launcher does what it says"
