#!/usr/bin/env python3
# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Follows the steps of a user who has never written a fablet, in headless Chromium: a new world, a dropped mesh, a gyroid, a
colour that depends on depth, a picture, a print: without any text but numbers. Set up and run it like view.py."""

import pathlib
import re
import shutil
import struct
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from graph import drag, text  # noqa: E402
from harness import FABLET, WORLD, Page, Viewer, check, middle, run_with_browser  # noqa: E402

OCTAHEDRON = """v 10 0 0
v -10 0 0
v 0 10 0
v 0 -10 0
v 0 0 10
v 0 0 -10
""" + "".join(f"f {a} {b} {c}\n" for a, b, c in ((1, 3, 5), (3, 2, 5), (2, 4, 5), (4, 1, 5), (3, 1, 6), (2, 3, 6), (4, 2, 6), (1, 4, 6)))


class Actions:
    """User actions, counted."""

    def __init__(self):
        self.count = 0

    def __call__(self, what, does):
        self.count += 1
        print(f"        {self.count:2} {what}")
        return does()


def drop_file(page, path):
    """Drags a file over the page and drops it."""
    page.evaluate("""([name, text]) => {
        const data = new DataTransfer();
        data.items.add(new File([text], name));
        for (const kind of ["dragenter", "dragover", "drop"])
            document.body.dispatchEvent(new DragEvent(kind, { dataTransfer: data, bubbles: true, cancelable: true }));
    }""", [path.name, path.read_text()])


def drop_bytes(page, name, content):
    """As drop_file, of bytes."""
    page.evaluate("""([name, bytes]) => {
        const data = new DataTransfer();
        data.items.add(new File([new Uint8Array(bytes)], name));
        for (const kind of ["dragenter", "dragover", "drop"])
            document.body.dispatchEvent(new DragEvent(kind, { dataTransfer: data, bubbles: true, cancelable: true }));
    }""", [name, list(content)])


def bitmap(width, height, dark):
    """Returns a BMP, black where `dark(x, y)`, white elsewhere; y goes up."""
    row = (3 * width + 3) // 4 * 4
    rows = b"".join(b"".join((b"\0\0\0" if dark(x, y) else b"\xff\xff\xff") for x in range(width)).ljust(row, b"\0") for y in range(height))
    return b"BM" + struct.pack("<IHHI", 54 + len(rows), 0, 0, 54) + struct.pack("<IiiHHIIiiII", 40, width, height, 1, 24, 0, len(rows), 2835, 2835, 0, 0) + rows


def by_label(page, label, which, n=0):
    """Returns the middle of a part of the nth node of that label."""
    return middle(page, f"#graph_svg .node[aria-label='{label}'] {which}", n)


def ready(at):
    """Waits until an edit is done and its graph stands."""
    at.page.wait_for_function("() => !document.body.classList.contains('graph_busy')")
    at.settle(500)


def take(at, act, category, name):
    """Adds a function of a name, by its category's tile: no text is typed."""
    page = at.page
    act("Add", lambda: page.click("#graph_add"))
    page.wait_for_selector("#palette_list .tile")
    act(category, lambda: page.click(f"#palette_list .tile:has(b:text-is('{category}'))"))
    act(name, lambda: page.locator(f"#palette_list .entry:has(b:text-is('{name}'))").first.click())
    ready(at)


def walk(browser, options):
    folder = options.out / "newcomer"
    shutil.rmtree(folder, ignore_errors=True)
    mesh = options.out / "octahedron.obj"
    mesh.write_text(OCTAHEDRON)
    act = Actions()
    with act("openfab view --new", lambda: Viewer(options, "--new", folder)) as url:
        at = Page(browser, options, size=(1440, 900))
        page = at.page
        act("open the page", lambda: at.open(url, view=None))
        act("drop a mesh", lambda: drop_file(page, mesh))
        at.eventually("the mesh is the object's", lambda: "is the mesh octahedron" in at.text("#files_note"))
        check("its file lies beside the world", (folder / "octahedron.obj").is_file())
        act("60 mm", lambda: (page.fill("[data-control=size0]", "60"), page.keyboard.press("Tab")))
        at.eventually("it is 60 mm wide", lambda: "60 × 60 × 60" in at.text("#part"))
        act("J850", lambda: page.select_option("[data-control=printer]", "j850"))
        at.eventually("the world has the printer", lambda: '"printer": "j850"' in (folder / "newcomer.fab.json").read_text())
        act("open the graph", lambda: page.click("#graph_button"))
        page.wait_for_selector("#graph_svg .node")
        at.settle(500)
        take(at, act, "Lattices", "gyroid")
        take(at, act, "Materials", "mix_field")
        act("see all", lambda: page.click("#graph_fit"))
        at.settle(400)
        gyroid = page.locator("#graph_svg .node[aria-label*='= gyroid']").first.get_attribute("aria-label")
        mix = page.locator("#graph_svg .node[aria-label*='mix_field']").first.get_attribute("aria-label")
        start = time.monotonic()
        act("the gyroid is the field", lambda: drag(page, by_label(page, gyroid, ".out"), by_label(page, mix, "[data-port='2'] .in")))
        ready(at)
        at.eventually("the wire is in the text", lambda: re.search(r"mix_field\(core, shell, gyroid_value", text(page)))
        print(f"        the text answers after {time.monotonic() - start:.2f} s")
        act("which is the result", lambda: drag(page, by_label(page, mix, ".out"), by_label(page, "return", "[data-port='0'] .in")))
        ready(at)
        act("the wire to the result", lambda: page.mouse.click(*by_label(page, "return", "[data-port='0'] .strip")))
        take(at, act, "Materials", "mix_depth")
        at.eventually("a colour by depth lies over it", lambda: re.search(r"return mix_depth\(core, \w+, distance\(", text(page)))
        at.shot("newcomer_graph")
        act("drop a picture", lambda: drop_bytes(page, "spots.bmp", bitmap(32, 16, lambda x, y: (x // 4 + y // 4) % 2 == 0)))
        at.eventually("which can be put on", lambda: page.locator("[data-control=picture_put]").count() == 1)
        act("put it on", lambda: page.click("[data-control=picture_put]"))
        at.eventually("it is on the part", lambda: "mix_picture_on(" in (folder / "newcomer.fl").read_text() and '"picture": "spots"' in (folder / "newcomer.fab.json").read_text())
        at.settle(1500)
        at.eventually("it is printed as a draft", lambda: not page.is_visible("#progress"))
        at.eventually("and nothing is wrong", lambda: "error" not in at.text("#diagnostics") and not page.is_visible("#world_message.error"))
        act("close the graph", lambda: page.click("#graph_button"))
        at.settle(2500)
        at.shot("newcomer_part")
        act("print", lambda: page.click("#print"))
        page.wait_for_function("() => document.getElementById('print_state').textContent.includes('is printed')", timeout=600_000)
        print_file = folder / "newcomer.ofr"
        check("it lies beside the world", print_file.stat().st_size > 1000)
        at.eventually("it is in view, with its path", lambda: at.text("#title") == "newcomer.ofr" and at.text("#printed_path") == str(print_file))
        at.settle(4000)
        at.shot("newcomer_printed")
        check(f"{act.count} actions are at most 30", act.count <= 30)
        at.close()


def templates(browser, options):
    folder = options.out / "fromtemplate"
    shutil.rmtree(folder, ignore_errors=True)
    with Viewer(options, "--new", folder, "--template", "lattice", "--draft", "8") as url:
        at = Page(browser, options)
        page = at.page
        at.open(url)
        check("a template is a stock fablet", "fablet Lattice" in text(page))
        page.on("dialog", lambda dialog: dialog.accept())
        page.select_option("#template", "shell")
        at.eventually("another takes its place", lambda: "fablet Shell" in text(page))
        at.eventually("and is printed", lambda: not page.is_visible("#progress"))
        check("without a fault", not page.is_visible("#world_message"))
        picture = options.out / "spots.bmp"
        rows = bytes([0, 0, 255, 255, 255, 255, 0, 0]) + bytes([255, 0, 0, 0, 255, 0, 0, 0])
        picture.write_bytes(b"BM" + struct.pack("<IHHI", 54 + len(rows), 0, 0, 54) + struct.pack("<IiiHHIIiiII", 40, 2, 2, 1, 24, 0, len(rows), 2835, 2835, 0, 0) + rows)
        page.set_input_files("#files", picture)
        at.eventually("a picture becomes a texture", lambda: "texture" in at.text("#files_note"))
        check("beside the world", (folder / "spots.bmp").is_file() and '"spots": {"file": "spots.bmp"}' in (folder / "fromtemplate.fab.json").read_text())
        at.close()


def notes(browser, options):
    """What a print notes is told on the page, in its words."""
    folder = options.out / "notes_world"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    (folder / "ball.fl").write_text(re.sub(r"float t = .*;", "float t = attr.voxelCenter.x > 0 ? 1 : 0;", FABLET).replace("mc.Set(shell, 1 - t + t * (1 - wave) * (1 - tint.x));", "mc.Set(shell, 0);"))
    (folder / "ball.fab.json").write_text(WORLD)
    with Viewer(options, folder / "ball.fab.json", "--watch", "--draft", "6") as url:
        at = Page(browser, options, allowed="422")
        page = at.page
        at.open(url)
        at.eventually("places without material are told of a draft", lambda: "without material" in at.text("#world_message"))
        page.click("#print")
        at.eventually("and of the print", lambda: "is printed at full pitch" in at.text("#print_state") and "without material" in at.text("#print_state"))
        drop_bytes(page, "notes.txt", b"no mesh")
        at.eventually("what is dropped is refused in the page's words", lambda: "is neither a mesh nor a picture" in at.text("#files_trouble"))
        check("without options or folders", not re.search(r"--[a-z]{2}|openfab\.tmp|/dropped/", page.inner_text("body")))
        at.close()


def main(browser, options):
    walk(browser, options)
    notes(browser, options)
    templates(browser, options)


if __name__ == "__main__":
    run_with_browser(__doc__, main, volumes=False)
