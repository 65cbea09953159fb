# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Pages of the programs' commands, made from their --help like the manual pages (cmake/command_manual.py)."""
import sys


def rows(title, entries):
    out = [f"| {title} | |", "| --- | --- |"]
    for entry in entries:
        name = entry.name
        told = entry.text
        if entry.option:
            name = ", ".join(entry.spellings) + (f" {entry.value}" if entry.value else "")
            told += f"; one of {', '.join(f'`{choice}`' for choice in entry.choices)}" if entry.choices else ""
            told += f"; default `{entry.default}`" if entry.default else ""
        else:
            name = name.replace(" REQUIRED", "").replace(" TEXT", "").replace(" ...", "…")
        out.append("| `{}` | {} |".format(name, told.replace("|", "\\|").replace("<", "&lt;")))
    return "\n".join(out)


def write(root, programs, pages):
    sys.path.insert(0, str(root / "cmake"))
    from command_manual import read
    names = []
    for program in ("openfab", "openflc", "openfab-texture", "openfab-color"):
        top = read(programs, [program])
        page = [f"# {program}", top.summary]
        for command in [top] + [below for below in top.below if below.name not in ("openfab-texture", "openfab-color")]:
            if command is not top:
                page += [f"## {' '.join(command.words)}", command.summary]
            page.append(f"```\n{command.usage}\n```")
            if command.positionals:
                page.append(rows("argument", command.positionals))
            if command is not top or not top.below:
                page.append(rows("option", command.options))
            if command.notes and command is not top:
                page.append(f"```text\n{command.notes}\n```")
        names.append(f"commands/{program}.md")
        (pages / names[-1]).parent.mkdir(parents=True, exist_ok=True)
        (pages / names[-1]).write_text("\n\n".join(page) + "\n", encoding="utf-8")
    return names
