# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Pages of the standard library: each function with its signature, comment, swatch (gallery/library), cost and bounds
(stdlib/costs.json)."""
import json
import re
from dataclasses import dataclass, field

from PIL import Image

FUNCTION = re.compile(r"(\w+) ([a-z]\w*)\(")
# Names that may be called from outside begin with a letter.
DECLARATION = re.compile(r"(?:const )?\w+ _?\w+")


@dataclass
class Function:
    name: str
    signatures: list = field(default_factory=list)
    comment: str = ""


@dataclass
class Section:
    title: str = ""
    text: str = ""
    functions: list = field(default_factory=list)


def paragraphs(lines):
    """Converts a comment to Markdown; names of gallery objects become links."""
    text = "\n".join(lines).strip().replace("<", "&lt;")
    return re.sub(r"\bgallery/(\w+)", r"[gallery/\1](../gallery/\1/README.md)", text)


def read(path):
    """Reads a module: its introduction, and its sections with their functions."""
    sections = [Section()]
    introduction = None
    comment = []
    inside = 0
    previous = None
    lines = path.read_text(encoding="utf-8").splitlines()
    at = 0
    while at < len(lines):
        line = lines[at]
        at += 1
        if inside:
            inside += line.count("{") - line.count("}")
        elif line.startswith("// ----"):
            sections.append(Section(line.strip("/- ")))
            comment, previous = [], None
        elif line.startswith("//"):
            comment.append(line[2:].removeprefix(" "))
        elif not line.strip():
            if introduction is None:
                introduction = paragraphs(comment[3:] if comment[:1] and comment[0].startswith("Copyright") else comment)
            elif comment:
                # A comment that stands alone is about what follows in its section.
                sections[-1].text += ("\n\n" if sections[-1].text else "") + paragraphs(comment)
            comment, previous = [], None
        elif DECLARATION.match(line):
            signature = line
            while "{" not in signature and ";" not in signature and not lines[at].startswith("{"):
                signature += " " + lines[at].strip()
                at += 1
            inside = signature.count("{") - signature.count("}")
            if found := FUNCTION.match(line):
                signature = re.sub(r"\s*\{.*", "", signature)
                functions = sections[-1].functions
                same = next((f for f in functions if f.name == found[2]), None)
                if same is None or comment:
                    same = Function(found[2], [], paragraphs(comment))
                    functions.append(same)
                    # One comment may stand above several.
                    if not comment and previous:
                        same.comment = ""
                same.signatures.append(signature)
                previous = same
            comment = []
        elif line.startswith("{"):
            inside = line.count("{") - line.count("}")
        elif not line.startswith("import "):
            raise SystemExit(f"{path}:{at}: not understood as part of a module: {line}")
    return introduction, sections


def swatches(root, pages):
    """Cuts the sheets of gallery/library into one picture per function; returns their paths by the names in its tables."""
    out = {}
    text = (root / "gallery/library/README.md").read_text(encoding="utf-8")
    for sheet, table in re.findall(r"!\[(\w+)\]\(\1\.png\)\n.*?\n\n(\|.*?)\n\n", text + "\n\n", flags=re.DOTALL):
        picture = Image.open(root / f"gallery/library/{sheet}.png")
        rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in table.splitlines()[2:]]
        # Squares of 9 mm, 10 mm apart, around the middle of a plate 61 mm wide (gallery/library/sheet.fl).
        scale = (picture.width - 2) / 61
        for y, row in enumerate(rows):
            for x, cell in enumerate(row):
                if not cell:
                    continue
                middle = (picture.width / 2 + (x - 2.5) * 10 * scale, picture.height / 2 + (y - (len(rows) - 1) / 2) * 10 * scale)
                box = [round(c + sign * 4.5 * scale) for sign in (-1, 1) for c in middle]
                file = f"library/swatches/{re.sub(r'[^a-z0-9]+', '_', cell).strip('_')}.png"
                (pages / file).parent.mkdir(parents=True, exist_ok=True)
                picture.crop(box).save(pages / file)
                # One square may show several functions at work.
                out |= dict.fromkeys(re.findall(r"`([^`]+)`", cell), file)
    return out


def parameters(signature):
    """Returns the type and the name of each parameter. A default value may hold commas: `float3 low = {0, 0, 0}`."""
    inside = signature[signature.index("(") + 1:signature.rindex(")")]
    inside = re.sub(r"\s*=\s*(?:\{[^{}]*\}|\w*\([^()]*\)|[^,])*", "", inside)
    return [part.split() for part in inside.split(",") if part.strip()]


def swatch_of(signature, name, known):
    """Returns the swatch of an overload, which the gallery names by a type, `dots (float2)`, or a count, `color_ramp (3)`."""
    if name in known:
        return known[name]
    given = parameters(signature)
    for key, file in known.items():
        if match := re.fullmatch(rf"{name} \((\w+)\)", key):
            which = match[1]
            kind = {"color_ramp": "float3", "grade_materials": "Material"}.get(name)
            count = sum(p[0] == kind for p in given)
            if which == str(count) or which == given[0][0]:
                return file
    return None


class Costs:
    """The cost of each function and the tightness of its interval, by module and types, as measured by bench/library."""

    def __init__(self, file):
        table = json.loads(file.read_text(encoding="utf-8"))
        self.processor, self.rounds = table["processor"], table["rounds"]
        self.rows = {(row["module"], row["function"]): row for row in table["functions"]}
        self.shown = set()

    def row_of(self, module, signature):
        head = signature[:signature.index("(")]
        types = [type_ + "".join(re.findall(r"\[\w*\]", name)) for type_, name in parameters(signature)]
        key = (module, f"{head}({', '.join(types)})")
        self.shown.add(key)
        if key not in self.rows:
            raise SystemExit(f"stdlib/costs.json has no row of {module}'s `{key[1]}`")
        return self.rows[key]

    def table(self, module, signatures):
        """Returns the Markdown of a function's table, and notes on overloads without a call."""
        rows = [self.row_of(module, signature) for signature in signatures]
        lines = ["| call | [ns a voxel](index.md#cost-and-bounds) | of a copy | interval | cubes decided |",
                 "| --- | --- | --- | --- | --- |"]
        for row in rows:
            if "call" not in row:
                continue
            cost = f"{row['ns']:g}" if row["ns"] >= 0.1 else "< 0.1"
            interval = ("none" if not row.get("bounded") else f"{row['width']:.3g}" if "width" in row else "mostly unknown")
            decided = f"{100 * row['decided']:.0f} of {100 * row['one_sided']:.0f} %" if "decided" in row else ""
            if row["module"] == "dither":
                interval = ""
            lines.append(f"| `{row['call']}` | {cost} | {max(row['copies'], 1):g} | {interval} | {decided} |")
        notes = [row["note"] for row in rows if "note" in row]
        return ["\n".join(lines)] * (len(lines) > 2) + notes

    def explanation(self):
        return f"""## Cost and bounds

Each function has a call of it with what that costs: processor time of one core of an {self.processor} with kernels for
AVX2, beyond that of a kernel that copies the voxel's position, and the ratio of both kernels. They are medians of
{self.rounds} rounds in turn. That of a dither rule is beyond a rule that always returns 0, with three materials in each
voxel. A print adds its own work for each voxel: it finds, dithers and writes it.

*Interval*: how many times as wide as the values themselves the interval is that culling works with, over cubes of 8
voxels a side, 0.4 mm, at random places within 32 mm (the median). 1 is exact. *Cubes decided*: in how many of these cubes
the interval tells on which side of a level all values lie, and in how many they do lie on one side. The level is that at which a
fablet would change its material: 0, or the middle of a range that does not contain it. Of a mixture, it is the
cubes that are the same throughout. Whole cubes that are decided are filled without evaluating their voxels; larger
ones are tried first.

In a call `p` is the voxel's centre, `unit` the same as 0 ... 1, `t` and `d` their first components. The figures are in
`stdlib/costs.json`; `bench_library` writes them."""

    def check(self):
        if gone := set(self.rows) - self.shown:
            raise SystemExit("stdlib/costs.json has rows of what is not in stdlib: " +
                             ", ".join(f"{module}'s `{function}`" for module, function in sorted(gone)))


def write(root, pages):
    """Writes library/*.md and returns their paths; an error names functions without a swatch."""
    known = swatches(root, pages)
    costs = Costs(root / "stdlib/costs.json")
    names, bare = [], []
    index = ["# Standard library", "Modules of OpenFL that `openflc` has inside: `import lattice;` makes the functions of "
             "one callable. The sources are in `stdlib/`.", "", "| module | functions |", "| --- | --- |"]
    for path in sorted((root / "stdlib").glob("*.fl")):
        introduction, sections = read(path)
        about = introduction.removeprefix(f"{path.stem}: ")
        page = [f"# {path.stem}", about[:1].upper() + about[1:]]
        listed = []
        for section in sections:
            if section.title and section.functions:
                page.append(f"## {section.title}")
            if section.text and section.functions:
                page.append(section.text)
            for function in section.functions:
                page.append(f"### {function.name}" if function.name not in listed else f"### {function.name}, more")
                listed.append(function.name)
                for signature in function.signatures:
                    file = swatch_of(signature, function.name, known)
                    if file is None:
                        bare.append(f"{path.stem}: {signature}")
                    else:
                        page.append(f"![{function.name}]({file.removeprefix('library/')})" + "{ width=120 align=right }")
                page.append("```openfl\n" + "\n".join(function.signatures) + "\n```")
                if function.comment:
                    page.append(function.comment)
                page += costs.table(path.stem, function.signatures)
        names.append(f"library/{path.stem}.md")
        (pages / names[-1]).parent.mkdir(parents=True, exist_ok=True)
        (pages / names[-1]).write_text("\n\n".join(page) + "\n", encoding="utf-8")
        links = ", ".join(f"[`{name}`]({path.stem}.md#{name})" for name in dict.fromkeys(listed))
        index.append(f"| [{path.stem}]({path.stem}.md) | {links} |")
    costs.check()
    index += ["", costs.explanation()]
    (pages / "library/index.md").write_text("\n".join(index) + "\n", encoding="utf-8")
    if bare:
        raise SystemExit("no swatch in gallery/library shows\n  " + "\n  ".join(bare))
    return ["library/index.md"] + names
