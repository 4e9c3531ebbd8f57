"""What the comparisons with CalculiX share: their arguments, stored numbers, and runs of flexopt."""
import argparse
import json
import os
import subprocess


def parser_of(description, cases):
    parser = argparse.ArgumentParser(description=description,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--flexopt", required=True)
    parser.add_argument("--work", required=True, help="scratch folder")
    parser.add_argument("--case", action="append", choices=list(cases))
    parser.add_argument("--mesh", type=int, nargs=3, help="along across through, instead")
    parser.add_argument("--store", help="write CalculiX's numbers here")
    parser.add_argument("--reuse", help="take CalculiX's numbers from here")
    return parser


def stored_numbers(options, empty):
    """What the file to reuse, or to store into, has so far."""
    for name in (options.reuse, options.store):
        if name and os.path.exists(name):
            with open(name) as file:
                return json.load(file)
    return empty


def store(options, numbers):
    if options.store:
        with open(options.store, "w") as file:
            json.dump(numbers, file, indent=1)


def written(job, folder):
    """The job's file in the folder."""
    os.makedirs(folder, exist_ok=True)
    path = os.path.join(folder, "job.json")
    with open(path, "w") as file:
        json.dump(job, file, indent=2)
    return path


def expanded(program, job, folder):
    """The flat design of a job."""
    done = subprocess.run([program, "expand", written(job, folder)], check=True,
                          capture_output=True, text=True)
    return json.loads(done.stdout)


def path_of(program, job, folder):
    """The points of the path that a job finds."""
    out = os.path.join(folder, "out")
    subprocess.run([program, "run", written(job, folder), "--out", out, "--quiet"], check=True,
                   stdout=subprocess.DEVNULL)
    with open(os.path.join(out, "result.json")) as file:
        return json.load(file)["path"]
