# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Pages of the programs' commands, made from their --help like the manual pages (cmake/command_manual.py)."""
import sys


# Of commands that a picture says more of than words, from a page that has the commands that make it.
PICTURES = {
    "openfab print": "docs/tutorial/knob.png",
    "openfab split": "docs/pieces.png",
    "openfab view": "docs/viewer.png",
    "openfab render": "gallery/peach/peach.png",
    "openfab text": "docs/how-to/tag.png",
    "openfab mechanics part": "docs/mechanics-part.png",
    "openfab mechanics strengthen": "docs/mechanics-strong.png",
}


def with_commands_below(command):
    """A command, and all that stand in it, but for the programs that have a page of their own."""
    out = [command]
    for below in command.below:
        if below.name not in ("openfab-texture", "openfab-color"):
            out += with_commands_below(below)
    return out


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
        for command in with_commands_below(top):
            words = " ".join(command.words)
            if command is not top:
                page += [f"## {words}", command.summary]
            if words in PICTURES:
                page.append(f"![{command.summary}](../{PICTURES[words]})")
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
