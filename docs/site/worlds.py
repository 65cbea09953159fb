# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""The reference of worlds, made from world/fab_world.schema.json."""
import json


def reference(target):
    name = target.rsplit("/", 1)[-1]
    return f"[{name}](#{name})"


def kind(schema):
    """Returns the type and the limits of a value in words."""
    if isinstance(schema.get("additionalProperties"), dict):
        return f"object: name to {kind(schema['additionalProperties'])}"
    if "$ref" in schema:
        return reference(schema["$ref"])
    if "const" in schema:
        return f"`{json.dumps(schema['const'])}`"
    if "enum" in schema:
        return ", ".join(f"`{json.dumps(value)}`" for value in schema["enum"])
    for several in ("anyOf", "oneOf"):
        if several in schema and "type" not in schema:
            return ", or ".join(kind(one) for one in schema[several])
    types = schema.get("type", "anything")
    if isinstance(types, list):
        return " or ".join(types)
    if types == "array":
        low, high = schema.get("minItems"), schema.get("maxItems")
        count = f"{low} " if low is not None and low == high else ""
        return f"array of {count}{kind(schema.get('items', {}))}"
    limits = [f"{sign} {schema[key]}" for key, sign in (("minimum", "≥"), ("exclusiveMinimum", ">"), ("maximum", "≤"))
              if key in schema]
    return types + (f" {', '.join(limits)}" if limits else "")


def cell(text):
    return text.replace("|", "\\|").replace("\n", " ")


def table(schema):
    rows = ["| key | value | |", "| --- | --- | --- |"]
    for key, value in schema["properties"].items():
        told = value.get("description", "")
        if "default" in value:
            told += f" Default: `{json.dumps(value['default'])}`."
        if key in schema.get("required", []):
            told = f"Required. {told}"
        rows.append(f"| `{cell(key)}` | {cell(kind(value))} | {cell(told.strip())} |")
    return "\n".join(rows)


def write(root, pages):
    schema = json.loads((root / "world/fab_world.schema.json").read_text(encoding="utf-8"))
    page = ["# World reference", schema["description"], "[Worlds](WORLDS.md) explains how the parts go together; editors read "
            "[the schema](fab_world.schema.json) from which this page is made.", "## World", table(schema)]
    for name, part in schema["$defs"].items():
        page.append(f"## {name}")
        if "description" in part:
            page.append(part["description"])
        page.append(table(part) if "properties" in part else f"Value: {kind(part)}.")
    (pages / "world/reference.md").write_text("\n\n".join(page) + "\n", encoding="utf-8")
    return "world/reference.md"
