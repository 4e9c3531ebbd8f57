"""The documentation builds as a site without a warning, and the site needs no network.

test_site.py FLEXOPT SOURCE WORK
"""
import html.parser
import json
import pathlib
import re
import shutil
import subprocess
import sys
import urllib.parse

OPTIMISED = "shaken_guide"  # in a tenth of a second


class Page(html.parser.HTMLParser):
    """What a page loads, where it leads, and which places it has."""

    def __init__(self, text):
        super().__init__()
        self.loads, self.links, self.ids, self.text = [], [], set(), ""
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        own = dict(attributes)
        if "id" in own:
            self.ids.add(own["id"])
        if tag in ("img", "script", "iframe", "source") and own.get("src"):
            self.loads.append(own["src"])
        if tag == "link" and own.get("href") and own.get("rel") not in ("canonical",):
            self.loads.append(own["href"])
        if tag == "a" and own.get("href"):
            self.links.append(own["href"])

    def handle_data(self, data):
        self.text += data


def main():
    flexopt, source, work = sys.argv[1:]
    runs = pathlib.Path(work + ".runs")  # of one optimisation: its page shows the optimum
    shutil.rmtree(runs, ignore_errors=True)
    subprocess.run([flexopt, "run", f"{source}/designs/jobs/{OPTIMISED}.json", "--quiet", "--out",
                    runs / f"{OPTIMISED}.out"], check=True)
    spoilt = runs / "fast_guide.out"  # of a run that is not of this job
    spoilt.mkdir()
    shutil.copy(runs / f"{OPTIMISED}.out" / "result.json", spoilt)
    built = subprocess.run([sys.executable, f"{source}/docs/site/build.py", flexopt, work, runs],
                           capture_output=True, text=True,
                           env={"PYTHONDONTWRITEBYTECODE": "1", "PATH": "/usr/bin:/bin"})
    print(built.stdout, built.stderr)
    if built.returncode != 0:
        return built.returncode
    root = pathlib.Path(work)
    pages = {file.relative_to(root): Page(file.read_text()) for file in root.rglob("*.html")}
    assert len(pages) > 100, len(pages)
    for name, page in pages.items():
        folder = (root / name).parent
        for load in page.loads:
            if load.startswith("#"):
                continue
            assert "://" not in load and not load.startswith("//"), (name, load)
            file = urllib.parse.unquote(load.split("?")[0].split("#")[0])
            assert file.startswith("data:") or (folder / file).is_file(), (name, load)
        for link in page.links:
            if "://" in link or link.startswith("mailto:"):
                continue
            path, _, place = link.partition("#")
            target = (folder / urllib.parse.unquote(path)).resolve() if path else (root / name).resolve()
            assert target.is_file(), (name, link)
            if place and target.suffix == ".html":
                other = pages[target.relative_to(root.resolve())]
                assert urllib.parse.unquote(place) in other.ids, (name, link)
    # every design file and every job has its page, with its drawing
    for kind, folder in (("families", "designs/families"), ("jobs", "designs/jobs")):
        for file in pathlib.Path(source, folder).glob("*.json"):
            page = pages[pathlib.Path("gallery", kind, file.stem + ".html")]
            drawing = re.compile(rf"/{file.stem}\d*\.svg$")  # one of several of a name has a number
            assert any(drawing.search(load) for load in page.loads), file
    # an optimisation whose optimum is known shows it beside its start, the others say what is drawn
    optimised = pages[pathlib.Path("gallery", "jobs", OPTIMISED + ".html")]
    assert any(re.search(rf"/{OPTIMISED}_optimum\d*\.svg$", load) for load in optimised.loads)
    assert "0.2912 mm" in optimised.text  # thickness; the start has 0.5 mm
    for file in pathlib.Path(source, "designs/jobs").glob("*.json"):
        says = "The drawing shows the start" in pages[
            pathlib.Path("gallery", "jobs", file.stem + ".html")].text
        job = json.loads(file.read_text())
        assert says == (job.get("job") == "optimise" and file.stem != OPTIMISED), file
    # keys of the schema stand in the reference
    for word in ("stroke", "load_capacity", "optimise.variables", "tolerances"):
        assert word in pages[pathlib.Path("reference/jobs.html")].text, word
    print(f"{len(pages)} pages")
    return 0


if __name__ == "__main__":
    sys.exit(main())
