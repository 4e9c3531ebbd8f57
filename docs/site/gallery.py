"""The gallery: a page for each family and each shipped job, with drawing and expected numbers."""
import concurrent.futures
import json
import math
import re
import subprocess


def run(program, *arguments):
    return subprocess.run([program, *map(str, arguments)], check=True, capture_output=True,
                          text=True).stdout


def cell(text):
    return re.sub(r"([|\\<>*_`\[\]])", r"\\\1", str(text))


def table(head, rows):
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in rows]) + "\n"


def families_of(program):
    """[(name, summary)] in the order of the program."""
    listed = run(program, "designs").split("\nMaterials:")[0].splitlines()[1:]
    return [tuple(line.strip().split(None, 1)) for line in listed if line.strip()]


def limits(parameter):
    words = []
    for key, sign in (("above", ">"), ("min", "≥"), ("below", "<"), ("max", "≤")):
        if key in parameter:
            words.append(f"{sign} {parameter[key]}")
    return ", ".join(words)


def write_small(drawing):
    """Beside a drawing its slanting view alone: NAME_small.svg."""
    svg = drawing.read_text()
    box = re.search(r'<view id="slanting" viewBox="([^"]+)"', svg)[1]
    x, y, width, height = box.split()
    svg = re.sub(r'width="\d+" height="\d+" viewBox="[^"]+"',
                 f'width="{width}" height="{height}" viewBox="{box}"', svg, count=1)
    svg = re.sub(r'(class="paper" )x="[^"]+" y="[^"]+"', rf'\g<1>x="{x}" y="{y}"', svg)
    drawing.with_name(f"{drawing.stem}_small.svg").write_text(svg)


def drawn(name, alt):
    return "```{container} drawing\n" + f"![{alt}]({name})\n```\n"


def family_page(program, root, out, name, summary, jobs):
    design = json.loads(run(program, "designs", "--export", name))
    run(program, "designs", name, "--svg", out / f"{name}.svg")
    write_small(out / f"{name}.svg")
    unit = lambda p: "" if p["unit"] == "1" else p["unit"]
    rows = [[f"`{key}`", cell(unit(p)),
             cell(p["default"]) if "default" in p else f"required (drawn: {cell(p['example'])})",
             cell(limits(p)), cell(p.get("meaning", ""))]
            for key, p in design["parameters"].items()]
    text = ORPHAN + f"# {name}\n\n{cell(summary)}\n\n" + drawn(f"{name}.svg", f"{name} with its dimensions")
    text += "\n## Parameters\n\n" + table(["name", "unit", "default", "range", "meaning"], rows)
    for key, option in design.get("options", {}).items():
        text += (f"\n`{key}`: {cell(option.get('meaning', ''))}; one of "
                 + ", ".join(f"`{c}`" for c in option["choices"]) + ", the first if nothing is said.\n")
    text += "\n## Jobs\n\n"
    text += "".join(f"- [{cell(title)}](../jobs/{job}.md)\n" for job, title in jobs) or "None is shipped.\n"
    text += f"\n## Its design file\n\n    ./flexopt designs --export {name}\n\n"
    text += "```json\n" + run(program, "designs", "--export", name).rstrip() + "\n```\n"
    (out / f"{name}.md").write_text(text)


def family_of(job):
    design = job.get("design", {})
    return design.get("family")


def shown(value):
    if isinstance(value, float) and value and math.isfinite(value):
        return f"{value:.6g}"
    return str(value)


def optimum_of(job, runs, name):
    """Its parameters {name: SI} by the finished run RUNS/NAME.out of this very job; None without one."""
    file = runs / f"{name}.out" / "result.json" if runs else None
    if not file or not file.is_file():
        return None
    result = json.loads(file.read_text())
    told = [(e["pointer"], e["expected"]) for e in result.get("expectations", []) if e["ok"]]
    if told != [(e["pointer"], e["value"]) for e in job.get("expect", [])]:
        return None
    return (result.get("optimum") or {}).get("parameters")


def shown_in(value, unit):
    """A number in SI as drawings show it: lengths in mm, angles in degrees."""
    if unit == "m":
        return f"{1e3 * value:.4g} mm"
    return f"{math.degrees(value):.4g}°" if unit == "rad" else f"{value:.4g}"


def drawings(program, root, out, name, job, runs):
    """Of an optimisation its start, and the optimum where a run has found it."""
    file = root / "designs/jobs" / f"{name}.json"
    run(program, "show", file, "--svg", out / f"{name}.svg")
    plain = drawn(f"{name}.svg", f"the mechanism of {name} with its dimensions")
    if job.get("job") != "optimise":
        return plain
    optimum = optimum_of(job, runs, name)
    if not optimum:
        return "The drawing shows the start of the optimisation.\n\n" + plain
    values = [word for key, value in optimum.items()
              for word in ("--set", f"/design/parameters/{key}={value!r}")]
    run(program, "show", file, "--svg", out / f"{name}_optimum.svg", *values)
    start = job["design"].get("parameters", {})
    family = family_of(job)
    known = json.loads(run(program, "designs", "--export", family))["parameters"] if family else {}
    rows = []
    for key in (v["parameter"] for v in job["optimise"]["variables"]):
        own = known.get(key, {})
        rows.append([f"`{key}`", cell(start.get(key, own.get("default", ""))),
                     shown_in(optimum[key], own.get("unit"))])
    return ("\n## The optimum\n\n" + drawn(f"{name}_optimum.svg", f"the optimum of {name} with its dimensions")
            + "\n" + table(["variable", "start", "optimum"], rows) + "\n## The start\n\n" + plain)


def job_page(program, root, out, name, job, runs):
    title = job.get("name", name)
    text = ORPHAN + f"# {cell(name)}\n\n{cell(title)}: a job of kind *{job.get('job', 'evaluate')}*"
    family = family_of(job)
    if family:
        text += f" for the family [{cell(family)}](../families/{family}.md)"
    text += f".\n\n    ./flexopt run designs/jobs/{name}.json\n\n"
    if "design" in job:
        text += drawings(program, root, out, name, job, runs)
    text += "\n## What it must show\n\nEach of these numbers of `result.json`, in SI units, is a test.\n\n"
    rows = [[f"`{e['pointer']}`", shown(e["value"]), shown(e["tolerance"]) if "tolerance" in e else "",
             cell(e.get("source", ""))] for e in job.get("expect", [])]
    text += table(["number", "value", "within", "where it comes from"], rows)
    text += "\n## The job\n\n```json\n"
    text += (root / "designs/jobs" / f"{name}.json").read_text().rstrip() + "\n```\n"
    (out / f"{name}.md").write_text(text)


def grid(entries):
    return ("```{container} gallery\n"
            + "\n\n".join(f"[![]({picture})]({page})\n[{cell(name)}]({page})" for name, picture, page in entries)
            + "\n```\n")


# Not in the tables of contents beside every page; the lists of the gallery lead to it.
ORPHAN = "---\norphan: true\n---\n\n"


def write(program, root, out, runs):
    jobs = {file.stem: json.loads(file.read_text())
            for file in sorted((root / "designs/jobs").glob("*.json"))}
    families = families_of(program)
    for folder in ("families", "jobs"):
        (out / folder).mkdir(parents=True)
    with concurrent.futures.ThreadPoolExecutor(4) as pool:
        made = [pool.submit(family_page, program, root, out / "families", name, summary,
                            [(job, content.get("name", job)) for job, content in jobs.items()
                             if family_of(content) == name]) for name, summary in families]
        made += [pool.submit(job_page, program, root, out / "jobs", name, job, runs)
                 for name, job in jobs.items()]
        for one in made:
            one.result()
    (out / "families.md").write_text(
        "# Families\n\nMechanisms that flexopt brings along, drawn from their design files at their "
        "usual dimensions. `./flexopt designs FAMILY --svg` makes such a drawing.\n\n"
        + grid([(name, f"families/{name}_small.svg", f"families/{name}.md") for name, _ in families])
        + "\n" + table(["family", "what it is"],
                       [[f"[{cell(n)}](families/{n}.md)", cell(s)] for n, s in families]))
    (out / "jobs.md").write_text(
        "# Jobs\n\nEvery job that is shipped, with the numbers that it must show; each is a test.\n\n"
        + table(["job", "kind", "what it is"],
                [[f"[{cell(n)}](jobs/{n}.md)", j.get("job", "evaluate"), cell(j.get("name", ""))]
                 for n, j in jobs.items()]))
