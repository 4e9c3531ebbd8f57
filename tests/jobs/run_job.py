"""A job runs, shows what it expects, and has one verdict: in the terminal, in result.json, on its page.

run_job.py FLEXOPT JOB OUT
"""
import json
import pathlib
import re
import subprocess
import sys


def data_of(page):
    """The result that the page shows, and what it says of it in first_screen.js."""
    return json.loads(re.search(r'<script type="application/json" id="result">(.*?)</script', page, re.S)[1])


def main():
    flexopt, job, out = sys.argv[1:]
    ran = subprocess.run([flexopt, "run", job, "--out", out, "--quiet"], text=True, stdout=subprocess.PIPE)
    print(ran.stdout, end="")
    if ran.returncode != 0:
        return ran.returncode
    result = json.loads(pathlib.Path(out, "result.json").read_text())
    page = data_of(pathlib.Path(out, "report.html").read_text())
    said = result["verdict"]
    assert said["tone"] in ("good", "warn", "bad") and said["word"] and said["text"], said
    told = f"{result['job']['name']}: {said['word']}. {said['text']}\n"
    assert ran.stdout.startswith(told), f"the terminal does not say\n{told}"
    assert page["verdict"] == said, f"the page says {page['verdict']}, result.json {said}"
    assert page["status"] == result["status"] == "ok", (page["status"], result["status"])
    return 0


if __name__ == "__main__":
    sys.exit(main())
