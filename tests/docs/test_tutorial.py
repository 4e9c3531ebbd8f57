"""Every command of docs/tutorial.md runs, in its order, and prints what the page says.

test_tutorial.py FLEXOPT SOURCE WORK [--update]

Files are saved under the names that the page tells; lines of ```output blocks must be among what the
command before them printed, numbers within 0.2 %. A picture that the page shows has the words of the
one that its command drew. --update puts the new pictures and the new numbers in their place.
"""
import pathlib
import re
import shutil
import signal
import subprocess
import sys

NUMBER = re.compile(r"[-+]?\d+\.?\d*(?:e[-+]?\d+)?")
BLOCK = re.compile(r"^```(\w+)\n(.*?)^```$|^    (\./flexopt [^\n]*)$"
                   r"|!\[[^]\n]*\]\(tutorial/([^)\n]+)\)", re.S | re.M)


def blocks(page):
    """(kind, text) of files, commands, outputs and pictures; a command is one line."""
    for match in BLOCK.finditer(page):
        kind, text, command, picture = match.groups()
        if kind == "json":
            name = re.findall(r"`([\w.]+\.json)`", page[: match.start()])[-1]
            yield "file", (name, text)
        elif kind:
            yield kind, text
        elif command:
            yield "command", command
        else:
            yield "picture", picture


def same_words(told, printed):
    return NUMBER.sub("#", " ".join(told.split())) == NUMBER.sub("#", " ".join(printed.split()))


def same_line(told, printed):
    """The same words, and numbers that are equal to what the machine's rounding leaves."""
    if not same_words(told, printed):
        return False
    pairs = zip(map(float, NUMBER.findall(told)), map(float, NUMBER.findall(printed)))
    return all(abs(a - b) <= 2e-3 * max(abs(a), abs(b)) + 2e-3 * (a == 0) for a, b in pairs)


def words_of(svg):
    return sorted(re.findall(r"<text[^>]*>([^<]*)</text>", svg))


def serve(command, flexopt, work):
    """A command that goes on until it is interrupted: it serves an address."""
    program = subprocess.Popen(f"exec '{flexopt}' {command}", shell=True, cwd=work, text=True,
                               stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    address = program.stdout.readline()
    program.send_signal(signal.SIGINT)
    program.communicate(timeout=60)
    assert address.startswith("http://127.0.0.1:"), address
    return address


def main():
    flexopt, source, work = map(pathlib.Path, sys.argv[1:4])
    page = (source / "docs/tutorial.md").read_text()
    shutil.rmtree(work, ignore_errors=True)
    work.mkdir(parents=True)
    (work / "designs").symlink_to(source / "designs")
    commands, printed, fresh = [], "", page
    for kind, text in blocks(page):
        if kind == "file":
            (work / text[0]).write_text(text[1])
        elif kind == "command":
            command = text.removeprefix("./flexopt ")
            commands.append(command)
            if command.startswith("explore"):
                printed = serve(command, flexopt, work)
                continue
            ran = subprocess.run(f"'{flexopt}' {command}", shell=True, cwd=work, text=True,
                                 capture_output=True)
            assert ran.returncode == 0, (command, ran.stdout, ran.stderr)
            printed = ran.stdout
        elif kind == "output":
            for line in text.splitlines():
                if "--update" in sys.argv:
                    new = [other for other in printed.splitlines() if same_words(line, other)]
                    if new and not any(same_line(line, other) for other in new):
                        fresh = fresh.replace(line, new[0], 1)
                        continue
                assert any(same_line(line, other) for other in printed.splitlines()), \
                    f"after {commands[-1]}\n{line}\nis not in\n{printed}"
        else:
            assert kind == "picture", f"```{kind}: nothing is known of such a block"
            kept, drawn = source / "docs/tutorial" / text, work / text
            if "--update" in sys.argv:
                shutil.copyfile(drawn, kept)
            assert words_of(drawn.read_text()) == words_of(kept.read_text()), \
                f"{kept} is not what {commands} drew: --update"
    if fresh != page:
        (source / "docs/tutorial.md").write_text(fresh)
    told = re.findall(r"\./flexopt [a-z]", page)
    assert len(commands) == len(told) and len(commands) > 10, (len(commands), len(told))
    print(f"{len(commands)} commands")
    return 0


if __name__ == "__main__":
    sys.exit(main())
