"""Commands that any page of the repository names exist, with these options; so do the files they name.

test_commands.py FLEXOPT SOURCE
"""
import pathlib
import re
import subprocess
import sys

LAUNCHER = {"test", "python", "bench", "docs", "packages"}  # of ./flexopt, not of the program


def help_of(flexopt, *command):
    return subprocess.run([flexopt, *command, "--help"], check=True, capture_output=True, text=True).stdout


def main():
    flexopt, source = sys.argv[1], pathlib.Path(sys.argv[2])
    known = {name: set(re.findall(r"--[a-z-]+", help_of(flexopt, name)))
             for name in re.findall(r"^  ([a-z][a-z-]+) ", help_of(flexopt).split("Subcommands:")[1], re.M)}
    launcher = (source / "flexopt").read_text()
    for name in LAUNCHER:
        assert re.search(rf"^  {name}\)$", launcher, re.M), name
    pages = [*source.glob("*.md"), *(page for folder in ("docs", "core", "optim", "tests")
                                     for page in (source / folder).rglob("*.md")
                                     if "node_modules" not in page.parts)]
    count = 0
    for page in pages:
        text = page.read_text()
        for line in re.findall(r"(?:^    |`)(?:\./|build/release/)flexopt ([a-z][^`\n]*)", text, re.M):
            words = re.split(r"\s{2,}|\s+#|\s+[|>]", line)[0].split()
            if words[0] in LAUNCHER:
                continue
            assert words[0] in known, (page, line)
            for option in words[1:]:
                if option.startswith("--"):
                    assert option.split("=")[0] in known[words[0]], (page, line, option)
                if option.startswith("designs/") and "*" not in option:
                    assert (source / option).exists(), (page, line, option)
            count += 1
    assert count > 40, count
    print(f"{count} commands in {len(pages)} pages")
    return 0


if __name__ == "__main__":
    sys.exit(main())
