#!/usr/bin/python3
"""Builds the documentation as a site: ./flexopt docs

    docs/site/build.py build/release/flexopt build/docs [RUNS]

The pages are those of the repository, where they stand; the reference is written from what the
program says of itself, the gallery from the shipped design files and jobs. OUT/index.html is the
first page. RUNS: a folder with finished runs of the shipped jobs, JOB.out each (the tests of the gallery
leave them in build/release/tests/jobs); pages of optimisations then show the optimum. Nothing on the site needs a network. A link that leads nowhere is an error.
Needs Debian's python3-sphinx, python3-myst-parser and furo. Exit code 77 without them.
"""
import pathlib
import re
import shutil
import subprocess
import sys

import gallery
import reference
import theme

ROOT = pathlib.Path(__file__).resolve().parents[2]

# Chapters and their pages, of the repository or written here.
CHAPTERS = [
    ("Start", ["docs/tutorial.md", "gallery/families.md", "gallery/jobs.md"]),
    ("How to", ["docs/designs.md", "docs/report.md", "docs/terminal.md", "docs/explore.md",
                "docs/loads.md", "docs/stress.md", "docs/dynamics.md", "docs/tolerances.md",
                "docs/maps.md", "docs/accuracy.md", "docs/export.md", "docs/python.md",
                "docs/library.md", "docs/cluster.md", "docs/install.md", "docs/six_hinges.md",
                "docs/monolithic_guide.md",
                "docs/limits.md", "docs/robustness.md"]),
    ("Reference", ["reference/jobs.md", "reference/designs.md", "reference/quantities.md",
                   "reference/commands.md", "docs/glossary.md", "docs/versions.md"]),
    ("Theory", ["core/README.md", "core/elements/README.md", "core/elements/plate/beams.md",
                "core/elements/solid/README.md",
                "core/equilibrium/README.md", "core/reduction/README.md",
                "core/reduction/superelement/README.md", "core/response/README.md",
                "core/response/modes/README.md",
                "optim/README.md"]),
    ("Benchmarks", ["docs/benchmarks.md", "tests/benchmarks/compare/README.md",
                    "tests/benchmarks/calculix/README.md"]),
    ("Development", ["docs/architecture.md", "CONTRIBUTING.md", "CHANGELOG.md"]),
]
WRITTEN_HERE = ("gallery/", "reference/")
LINK = re.compile(r"(\]\()([^)#\s]+)(#[^)\s]*)?(\))")


def without_code(text):
    """The text with its code blanked, so that no link is looked for in it."""
    blank = lambda match: re.sub(r"[^\n]", " ", match[0])
    return re.sub(r"`[^`\n]+`", blank, re.sub(r"^```.*?^```", blank, text, flags=re.S | re.M))


def stage_page(page, pages, source):
    """Copies a page and what it shows. README.md is the first page of the site."""
    text = (ROOT / page).read_text()
    place = pathlib.PurePosixPath(page).parent
    changes = []
    for link in LINK.finditer(without_code(text)):
        target = link[2]
        if "://" in target or target.startswith("mailto:"):
            continue
        file = (ROOT / place / target).resolve()
        if not file.is_file():
            continue  # Sphinx says so
        name = file.relative_to(ROOT).as_posix()
        if name == "README.md":
            changes.append((link.span(2), target[: -len("README.md")] + "index.md"))
        elif name not in pages:
            (source / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(file, source / name)
    for (begin, end), new in reversed(changes):
        text = text[:begin] + new + text[end:]
    staged = source / ("index.md" if page == "README.md" else page)
    staged.parent.mkdir(parents=True, exist_ok=True)
    staged.write_text(text)


def contents(chapters):
    """The tables of contents, which stand beside every page."""
    return "".join(
        "\n```{toctree}\n:hidden:\n:caption: " + caption + "\n\n" + "\n".join(pages) + "\n```\n"
        for caption, pages in chapters)


def stage(program, source, runs):
    shutil.rmtree(source, ignore_errors=True)
    source.mkdir(parents=True)
    pages = ["README.md"] + [page for _, own in CHAPTERS for page in own
                             if not page.startswith(WRITTEN_HERE)]
    for page in pages:
        stage_page(page, pages, source)
    missed = {str(p.relative_to(ROOT)) for p in (ROOT / "docs").glob("*.md")} - set(pages)
    if missed:
        sys.exit(f"docs/site/build.py: pages that no chapter has: {sorted(missed)}")
    reference.write(program, source / "reference")
    gallery.write(program, ROOT, source / "gallery", runs)
    with (source / "index.md").open("a") as index:
        index.write(contents(CHAPTERS))


def main():
    program, out, *runs = (pathlib.Path(word).resolve() for word in sys.argv[1:])
    try:
        import furo, myst_parser, sphinx  # noqa: E401, F401
    except ImportError as missing:
        print(f"{missing.name} is missing: install python3-sphinx, python3-myst-parser and furo")
        return 77
    source, site = out / ".pages", out / ".site"
    stage(str(program), source, runs[0] if runs else None)
    shutil.rmtree(site, ignore_errors=True)
    code = subprocess.run([sys.executable, "-m", "sphinx", "-W", "--keep-going", "-q", "-E",
                           "-j", "auto", "-d", out / ".doctrees", "-c", ROOT / "docs/site",
                           source, site]).returncode
    if code != 0:
        return 1
    theme.complete(site / "_static")
    for old in out.iterdir():  # the new site in the place of the old one
        if old not in (source, site):
            shutil.rmtree(old) if old.is_dir() else old.unlink()
    for new in site.iterdir():
        new.rename(out / new.name)
    site.rmdir()
    shutil.rmtree(source)
    print(out / "index.html")
    return 0


if __name__ == "__main__":
    sys.exit(main())
