#!/usr/bin/env python3
"""The rooms that differ from a base, and those that include them, with sanitizers, in so many seconds.

  .ci/sanitize.py BUILD BASE SECONDS FAILURES     without a base, "", every room

Rooms are those of docs/architecture.md. Each is compiled once more with address and undefined-behaviour
sanitizers; programs of the tests are linked with these objects and, of all other rooms and of the tests,
with those that BUILD has (core/package/rooms.cmake). Then the tests of these rooms run, without those
of the tag [slow]. What has changed most comes first; half of the time is for compiling. Rooms and tests
that the time does not suffice for are named: what is left to ".ci/run nightly".

Exit code 1: a test failed, and FAILURES got what it printed; or something did not compile.
"""
import concurrent.futures
import os
import pathlib
import re
import signal
import subprocess
import sys
import time

root = pathlib.Path(__file__).resolve().parent.parent
build = root / sys.argv[1]
base = sys.argv[2]
begun = time.monotonic()
end = begun + float(sys.argv[3])
logs = build / "sanitized_tests"


def left():
    return end - time.monotonic()


def table():
    """Each room with those that it includes; it stands below all of them."""
    lines = (root / "docs/architecture.md").read_text(encoding="utf-8").splitlines()
    words = [re.findall("`([a-z_/]+)`", line) for line in lines if line.startswith("| `")]
    return {word[0]: word[1:] for word in words}


def chosen(includes):
    """The rooms that have changed, most lines first, and those that include them, by the table.

    A test changes the room that it tests; nobody includes it.
    """
    if not base:
        return [], list(includes)
    lines, sources = {}, set()
    changes = subprocess.run(
        ["git", "diff", "--numstat", "--no-renames", base, "--", "core", "designs", "optim", "results", "tests"],
        cwd=root, check=True, text=True, capture_output=True).stdout
    for added, removed, file in (line.split("\t") for line in changes.splitlines()):
        folder = os.path.dirname(file)
        room = folder.removeprefix("tests/")
        if room in includes and added != "-":
            lines[room] = lines.get(room, 0) + int(added) + int(removed)
            if room == folder and file.endswith((".hpp", ".cpp")):
                sources.add(room)
    changed = sorted(lines, key=lambda room: -lines[room])
    reached = set(sources)
    for room, others in includes.items():
        if reached & set(others):
            reached.add(room)
    return changed, [room for room in includes if room in reached and room not in changed]


def configured(rooms):
    subprocess.run(["cmake", "--preset", "release", "-D", "FLEXOPT_SANITIZED_ROOMS=" + ";".join(rooms)],
                   cwd=root, check=True, stdout=subprocess.DEVNULL)


def objects(room):
    return "sanitized_room_" + room.replace("/", "_")


def compile_rooms(rooms, seconds):
    """Until the time is over: ninja takes the rooms in the order in which they were configured."""
    if not rooms or seconds <= 0:
        return
    with subprocess.Popen(["ninja", "-C", build, "--quiet", *map(objects, rooms)]) as ninja:
        try:
            code = ninja.wait(seconds)
        except subprocess.TimeoutExpired:
            ninja.send_signal(signal.SIGINT)
            ninja.wait()
            return
    if code:
        sys.exit("the rooms do not compile with sanitizers")


def compiled(room):
    """Ninja leaves no object behind that was not finished."""
    commands = subprocess.run(["ninja", "-C", build, "-t", "commands", objects(room)],
                              text=True, capture_output=True, check=True).stdout
    outputs = re.findall(rf" -o (\S+/{objects(room)}\.dir/\S+\.o) ", commands)
    return bool(outputs) and all((build / output).exists() for output in outputs)


def tests_run(program):
    """Runs the tests of a program: how that ended, in words, and whether well."""
    if left() <= 0:
        return program, None
    log = logs / f"{program}.txt"
    started = time.monotonic()
    environment = dict(os.environ, FLEXOPT_BINARY=str(build / "sanitized_flexopt"),
                       LSAN_OPTIONS=f"suppressions={root / '.ci/leaks.supp'}:print_suppressions=0")
    with open(log, "w", encoding="utf-8") as out:
        try:
            code = subprocess.run([build / f"sanitized_{program}", "~[slow]", "--durations", "yes"],
                                  cwd=logs, env=environment, stdin=subprocess.DEVNULL, stdout=out,
                                  stderr=subprocess.STDOUT, timeout=left() + 30).returncode
        except subprocess.TimeoutExpired:
            done = len(re.findall(r"^[0-9.]+ s: ", log.read_text(encoding="utf-8", errors="replace"), re.M))
            return f"{program} after {done} test cases", None
    text = log.read_text(encoding="utf-8", errors="replace").rstrip()
    print(f"sanitized: {program}: {'passed' if code == 0 else 'FAILED'} after "
          f"{time.monotonic() - started:.0f} s: {text[text.rfind(chr(10)) + 1:]}", flush=True)
    return program, code == 0


def main():
    includes = table()
    changed, others = chosen(includes)
    if not changed and not others:
        print("no room has changed")
        return 0
    print("changed:     ", " ".join(changed))
    print("include them:", " ".join(others), flush=True)

    configured(changed + others)
    targets = subprocess.run(["ninja", "-C", build, "-t", "targets", "all"],
                             text=True, capture_output=True, check=True).stdout
    have = [room for room in changed + others if f"{objects(room)}: phony" in targets]
    half = end - left() / 2
    for rooms in changed, others:
        compile_rooms([room for room in rooms if room in have], half - time.monotonic())
    done = [room for room in have if compiled(room)]
    print("with sanitizers:", " ".join(done), f"({time.monotonic() - begun:.0f} s)", flush=True)

    configured(done)
    order = {room: i for i, room in enumerate(changed + others)}
    last = len(order)  # what tests no room alone: jobs, literature
    programs = {}
    for line in (build / "sanitized_tests.txt").read_text(encoding="utf-8").splitlines():
        program, *rooms = line.split()
        places = [order[room] if room in order else last for room in rooms if room in order or room not in includes]
        if places:
            programs[program] = min(places)
    programs = sorted(programs, key=programs.get)
    ninja = ["ninja", "-C", build, "--quiet", "sanitized_flexopt", *("sanitized_" + p for p in programs)]
    if done and subprocess.run(ninja, check=False).returncode:
        sys.exit("the tests do not link with rooms that have sanitizers")
    logs.mkdir(exist_ok=True)
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        ended = list(pool.map(tests_run, programs if done else []))

    failed = [program for program, well in ended if well is False]
    rest = [program for program, well in ended if well is None]
    with open(sys.argv[4], "a", encoding="utf-8") as failures:
        for program in failed:
            log = logs / f"{program}.txt"
            print(f"--- failed: sanitized_{program}, the end of {log}", file=failures)
            print("\n".join(log.read_text(encoding="utf-8", errors="replace").splitlines()[-80:]), file=failures)
    missing = [room for room in have if room not in done]
    if missing:
        print("LEFT to .ci/run nightly, rooms without sanitizers:", " ".join(missing))
    if rest:
        print("LEFT to .ci/run nightly, tests of:", ", ".join(rest))
    return 1 if failed else 0


sys.exit(main())
