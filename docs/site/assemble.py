#!/usr/bin/env python3
# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Gathers the pages of the site: assemble.py ROOT PROGRAMS OUT makes OUT/pages and OUT/mkdocs.yml for mkdocs.

The pages have the same places as in the repository, so their links hold: every Markdown file except those of tests, with
the files that it shows or links to. Pages of libraries, commands and worlds are made from the sources. A new document
needs no line here; NAVIGATION places it by its path.
"""
import json
import pathlib
import re
import shutil
import subprocess
import sys

import commands
import library
import worlds

LEFT_OUT = ("tests/", "gallery/figures/")
# Titles of the tabs, and what is in them: patterns of paths in order; what none names is under the last.
NAVIGATION = [
    ("OpenFab", ["README.md", "docs/systems.md", "docs/glossary.md", "CHANGELOG.md"]),
    ("Tutorial", ["docs/tutorial/*.md"]),
    ("How to", ["docs/printing.md", "docs/machines.md", "docs/process.md", "docs/how-to/*.md", "docs/mechanics.md", "docs/streaming.md", "docs/viewer.md", "docs/graph.md", "docs/trust.md"]),
    ("Parts", ["core/mesh/read/README.md", "runtime/solid/*/README.md", "runtime/process/*/README.md", "backends/*.md", "backends/*/*.md"]),
    ("Language", ["compiler/OPENFL.md", "schedules/README.md", "docs/editor.md", "editors/*/README.md"]),
    ("Library", ["library/index.md", "library/*.md", "compiler/functions/README.md"]),
    ("Worlds", ["world/WORLDS.md", "world/reference.md"]),
    ("Commands", ["commands/*.md"]),
    ("Python", ["docs/python.md", "docs/python/*.md", "docs/scale.md"]),
    ("Gallery", ["gallery/index.md", "gallery/magic_postcard/README.md", "gallery/*/README.md"]),
    ("Inside", ["docs/architecture.md", "docs/determinism.md", "docs/nearest.md", "docs/*.md", "docs/measurements/*.md",
                "CONTRIBUTING.md"]),
]
LINK = re.compile(r"(!?)\[((?:[^\[\]]|\[[^\]]*\])*)\]\(([^)\s]+)\)")


def title_of(path):
    found = re.search(r"^# (.+)$", path.read_text(encoding="utf-8"), flags=re.MULTILINE)
    return found[1].replace("`", "") if found else path.stem


class Site:
    def __init__(self, root, out):
        self.root, self.pages = root, out / "pages"
        listed = subprocess.run(["git", "ls-files", "--cached", "--others", "--exclude-standard"], cwd=root, text=True,
                                capture_output=True, check=True).stdout.splitlines()
        self.files = {name for name in listed if (root / name).exists()}
        self.documents = {name for name in self.files if name.endswith(".md") and not name.startswith(LEFT_OUT)}
        self.made = set()
        self.copied = set()

    def copy(self, name):
        if name not in self.copied:
            self.copied.add(name)
            (self.pages / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(self.root / name, self.pages / name)

    def folder_page(self, name):
        """Returns the page for a link to a folder; None if there is none."""
        if name == "stdlib":
            return "library/index.md"
        if f"{name}/README.md" in self.documents:
            return f"{name}/README.md"
        return f"{name}/index.md" if f"{name}/index.md" in self.made else None

    def link(self, page, match):
        picture, text, target = match.groups()
        if "://" in target or target.startswith(("#", "mailto:")):
            return match[0]
        file, _, anchor = target.partition("#")
        folder = pathlib.PurePosixPath(page).parent
        full = pathlib.Path("/", folder, file).resolve().relative_to("/").as_posix()
        if full in self.documents | self.made:
            return match[0]
        if full in self.files:
            self.copy(full)
            return match[0]
        if landing := self.folder_page(full):
            up = "../" * (len(folder.parts) if folder.parts else 0)
            return f"{picture}[{text}]({up}{landing}{'#' + anchor if anchor else ''})"
        if any(name.startswith(full + "/") for name in self.files):
            return text  # a folder of sources, which the site does not have
        raise SystemExit(f"{page}: `{target}` is not there")

    def write(self, page):
        """Copies a document, with the empty lines that this Markdown needs before lists, tables and blocks."""
        out, code, previous = [], False, ""
        for line in (self.root / page).read_text(encoding="utf-8").splitlines():
            if line.lstrip().startswith("```"):
                if not code and previous.strip() and not line.startswith(" "):
                    out.append("")
                code = not code
                # Only the language: what tests read after it is no fence to this Markdown.
                line = re.sub(r"^(\s*```\w*).*", r"\1", line)
            elif not code:
                line = LINK.sub(lambda match: self.link(page, match), line)
                starts_list = re.match(r"(?:[-*] |\d+\. )", line) and not re.match(r"(?:[-*] |\d+\. |  )", previous)
                starts_table = line.startswith("|") and not previous.startswith("|")
                if previous.strip() and (starts_list or starts_table):
                    out.append("")
            out.append(line)
            previous = line
        (self.pages / page).parent.mkdir(parents=True, exist_ok=True)
        (self.pages / page).write_text("\n".join(out) + "\n", encoding="utf-8")

    def index_folders(self):
        """Makes a list for each folder of documents that is linked to and has no page of its own."""
        for folder in ("docs/measurements", "docs/how-to"):
            inside = sorted(name for name in self.documents if name.startswith(folder + "/"))
            name = f"{folder}/index.md"
            if not inside or name in self.documents or f"{folder}/README.md" in self.documents:
                continue
            rows = [f"- [{title_of(self.root / one)}]({pathlib.PurePosixPath(one).name})" for one in inside]
            title = {"docs/measurements": "Measurements", "docs/how-to": "How to"}[folder]
            (self.pages / name).parent.mkdir(parents=True, exist_ok=True)
            (self.pages / name).write_text(f"# {title}\n\n" + "\n".join(rows) + "\n", encoding="utf-8")
            self.made.add(name)

    def gallery(self):
        """Makes a page with the first picture of each exhibit."""
        cards = ["# Gallery", "Printed objects, each with its fablet and its world; every picture is made of the print's own voxels.",
                 '<div class="grid cards" markdown>']
        for page in sorted(name for name in self.documents if re.fullmatch(r"gallery/\w+/README.md", name)):
            folder = page.split("/")[1]
            shown = re.search(r"!\[[^\]]*\]\(([\w.]+)\)", (self.root / page).read_text(encoding="utf-8"))
            pictures = sorted(name for name in self.files if re.fullmatch(rf"gallery/{folder}/\w+\.png", name))
            picture = f"gallery/{folder}/{shown[1]}" if shown else pictures[-1]
            self.copy(picture)
            title = title_of(self.root / page)
            cards.append(f"-   [![{title}]({picture.removeprefix('gallery/')}){{ width=220 }}]({folder}/README.md)\n\n"
                         f"    [{title}]({folder}/README.md)")
        cards.append("</div>")
        (self.pages / "gallery").mkdir(exist_ok=True)
        (self.pages / "gallery/index.md").write_text("\n\n".join(cards) + "\n", encoding="utf-8")
        self.made.add("gallery/index.md")

    def navigation(self):
        left = sorted(self.documents | self.made)
        out = []
        for title, patterns in NAVIGATION:
            chosen = []
            for pattern in patterns:
                matching = [name for name in left if pathlib.PurePosixPath(name).match(pattern)
                            and name.count("/") == pattern.count("/")]
                matching.sort(key=lambda name: (not name.endswith("index.md"), name))
                chosen += matching
                left = [name for name in left if name not in matching]
            if (title, patterns) == NAVIGATION[-1]:
                chosen += left
            if chosen:
                entries = [{title_of(self.pages / name): name} for name in chosen]
                out.append({title: entries if len(entries) > 1 else chosen[0]})
        return out


def main():
    root, programs, out = (pathlib.Path(argument).resolve() for argument in sys.argv[1:4])
    shutil.rmtree(out / "pages", ignore_errors=True)
    site = Site(root, out)
    (site.pages / "world").mkdir(parents=True)
    site.made.update(library.write(root, site.pages))
    site.made.add(worlds.write(root, site.pages))
    site.made.update(commands.write(root, programs, site.pages))
    site.copy("world/fab_world.schema.json")
    for picture in commands.PICTURES.values():
        site.copy(picture)
    site.index_folders()
    site.gallery()
    for page in sorted(site.documents):
        site.write(page)
    settings = {"INHERIT": str(root / "docs/site/mkdocs.yml"), "docs_dir": str(site.pages), "site_dir": str(out / "html"),
                "nav": site.navigation()}
    # JSON is YAML.
    (out / "mkdocs.yml").write_text(json.dumps(settings, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
