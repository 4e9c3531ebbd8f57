"""The reference: what the program says of its jobs, design files, quantities and commands."""
import json
import re

from gallery import cell, run, table

DEPTH = 4  # of headings for nested records


def short(text, limit=400):
    return text if len(text) <= limit else text[:limit] + " …"


def alternatives(schema):
    return schema.get("anyOf", [schema])


def records(schema):
    """Records that may stand there: itself, in a list, by name, or one of several shapes."""
    found = []
    for one in alternatives(schema):
        if "properties" in one:
            found.append(one)
        elif isinstance(one.get("items"), dict):
            found += records(one["items"])
        elif isinstance(one.get("additionalProperties"), dict):
            found += records(one["additionalProperties"])
    return found


def kind(schema):
    """What may stand there, in words."""
    words = []
    for one in alternatives(schema):
        if "enum" in one:
            words.append(", ".join(f"`{json.dumps(value)}`" for value in one["enum"]))
        elif one.get("type") == "array":
            least, most = one.get("minItems", 0), one.get("maxItems")
            count = f"{least} " if least == most and most is not None else ""
            words.append(f"list of {count}({kind(one.get('items', {}))})")
        elif "properties" in one:
            words.append("record")
        elif isinstance(one.get("additionalProperties"), dict):
            words.append(f"by name: {kind(one['additionalProperties'])}")
        else:
            words.append({"string": "text", "integer": "whole number", "boolean": "true or false"}
                         .get(one.get("type"), one.get("type", "any")))
    return " or ".join(dict.fromkeys(words))


def limits(schema):
    """Bounds of numbers, which texts with units keep as well."""
    signs = (("exclusiveMinimum", ">"), ("minimum", "≥"), ("exclusiveMaximum", "<"), ("maximum", "≤"))
    for one in alternatives(schema):
        words = [f"{sign} {one[key]:g}" for key, sign in signs if key in one and abs(one[key]) < 1e9]
        if words and "value" not in schema.get("description", ""):
            return ", ".join(words)
    return ""


def meaning(schema):
    text = cell(schema.get("description", ""))
    bounds = limits(schema)
    if bounds:
        text += f" ({bounds})"
    if "default" in schema and schema["default"] not in (None, {}, []):
        text += f"; default `{json.dumps(schema['default'])}`"
    return text


def fields(record):
    required = set(record.get("required", []))
    return table(["key", "what may stand there", "meaning"],
                 [[f"`{key}`" + (" (required)" if key in required else ""), short(kind(value)),
                   meaning(value)] for key, value in sorted(record["properties"].items())])


def sections(path, schema, level, seen):
    """A section for each record below; one of the same keys was told already."""
    text = ""
    for record in records(schema):
        mark = json.dumps(record["properties"], sort_keys=True)
        title = "#" * min(level, DEPTH) + f" `{path}`\n\n"
        if mark in seen:
            text += title + f"The keys of `{seen[mark]}`.\n\n"
            continue
        seen[mark] = path
        text += title
        if schema.get("description"):
            text += cell(schema["description"]) + ".\n\n"
        text += fields(record) + "\n"
        for key, value in sorted(record["properties"].items()):
            text += sections(f"{path}.{key}" if path else key, value, level + 1, seen)
    return text


def schema_page(title, head, schema):
    seen = {}
    text = f"# {title}\n\n{head}\n\n" + fields(schema) + "\n"
    for key, value in sorted(schema["properties"].items()):
        text += sections(key, value, 2, seen)
    return text


def quantities_page(program):
    lines = run(program, "quantities").splitlines()
    starts = [lines[0].index(word) for word in lines[0].split()]
    rows = []
    for line in lines[1:]:
        parts = [line[a:b].strip() for a, b in zip(starts, starts[1:] + [None])]
        rows.append([f"`{parts[0]}`", *map(cell, parts[1:])])
    return ("# Quantities\n\nWhat goals, maps and comparisons may name, for a drive along y; "
            "`./flexopt quantities FAMILY` has the units of another drive.\n\n"
            + table(lines[0].split(), rows))


def commands_page(program):
    overview = run(program, "--help")
    text = "# Commands\n\n```\n" + overview.rstrip() + "\n```\n"
    for name in re.findall(r"^  ([a-z][a-z-]+) ", overview.split("Subcommands:")[1], re.M):
        text += f"\n## {name}\n\n```\n{run(program, name, '--help').rstrip()}\n```\n"
    return text


def write(program, out):
    out.mkdir(parents=True)
    units = ("A number is one in SI units or a text with a unit (`\"0.35 mm\"`). This page is written "
             "from the JSON Schema that the program itself reads by, ")
    (out / "jobs.md").write_text(schema_page(
        "Job files", units + "`./flexopt schema`. Parameters of a design are those of "
        "[its family](../gallery/families.md) or [its file](../docs/designs.md).",
        json.loads(run(program, "schema"))))
    (out / "designs.md").write_text(schema_page(
        "Design file keys", units + "`./flexopt schema --design`. Numbers may be formulas; what "
        "they mean is told in [design files](../docs/designs.md).",
        json.loads(run(program, "schema", "--design"))))
    (out / "quantities.md").write_text(quantities_page(program))
    (out / "commands.md").write_text(commands_page(program))
