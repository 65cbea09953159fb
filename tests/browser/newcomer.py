#!/usr/bin/env python3
# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Follows the steps of a user who has never written a fablet, in headless Chromium: a new world, a dropped mesh, a gyroid, a
colour that depends on depth, a print. Set up and run it like view.py."""

import pathlib
import re
import shutil
import struct
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from graph import dot, drag, text  # noqa: E402
from harness import Page, Viewer, check, run_with_browser  # noqa: E402

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


def walk(browser, options):
    folder = options.out / "newcomer"
    shutil.rmtree(folder, ignore_errors=True)
    mesh = options.out / "octahedron.obj"
    mesh.write_text(OCTAHEDRON)
    act = Actions()
    with act("openfab view --new", lambda: Viewer(options, "--new", folder, "--draft", "6")) as url:
        at = Page(browser, options, size=(1600, 1000))
        page = at.page
        act("open the page", lambda: at.open(url))
        act("drop a mesh", lambda: drop_file(page, mesh))
        at.eventually("the mesh is the object's", lambda: "is the mesh octahedron" in at.text("#files_note"))
        check("its file lies beside the world", (folder / "octahedron.obj").is_file())
        check("the world names it", '"mesh": "octahedron"' in (folder / "newcomer.fab.json").read_text())
        act("open the graph", lambda: page.click("#graph_button"))
        page.wait_for_selector("#graph_svg .node")
        act("Add", lambda: page.click("#graph_add"))
        page.wait_for_selector("#palette:not([hidden])")
        act("search", lambda: page.fill("#palette_search", "gyroid"))
        at.settle(300)
        entry = page.locator("#palette_list button").first
        act("drag it in", lambda: entry.drag_to(page.locator("#graph_svg"), target_position={"x": 520, "y": 20}))
        at.eventually("a gyroid is there", lambda: "gyroid_value" in text(page))
        at.settle(500)
        act("see all", lambda: page.click("#graph_fit"))
        at.settle(400)
        start = time.monotonic()
        act("the gyroid colours the core", lambda: drag(page, dot(page, "gyroid_value = gyroid", ".out"), dot(page, "mc.Set", "[data-port='2'] .in")))
        at.eventually("the wire is in the text", lambda: "mc.Set(core, gyroid_value)" in text(page))
        print(f"        the text answers after {time.monotonic() - start:.2f} s")
        act("Add", lambda: page.click("#graph_add"))
        act("search", lambda: page.fill("#palette_search", "grade_depth"))
        at.settle(300)
        act("take it", lambda: page.keyboard.press("Enter"))
        at.eventually("a grade by depth is there", lambda: "grade_depth(" in text(page))
        act("see all", lambda: page.click("#graph_fit"))
        at.settle(400)
        title = page.locator("#graph_svg .node:has(.title:text-matches('grade_depth'))").first.locator(".title").text_content()
        act("it colours the shell", lambda: drag(page, dot(page, title, ".out"), page_dot(page)))
        at.eventually("the wire is in the text", lambda: re.search(r"mc\.Set\(shell, \w+\)", text(page)))
        at.eventually("it is printed as a draft", lambda: not page.is_visible("#progress"))
        at.eventually("and nothing is wrong", lambda: not at.text("#diagnostics") and not page.is_visible("#world_message"))
        at.settle(1500)
        at.shot("newcomer_graph")
        act("print", lambda: page.click("#print"))
        at.eventually("the print is done", lambda: "is printed" in at.text("#print_state"))
        check("it lies beside the world", (folder / "newcomer.ofr").stat().st_size > 1000)
        at.shot("newcomer_printed")
        check(f"{act.count} actions are at most 25", act.count <= 25)
        at.close()


def page_dot(page):
    """Returns the amount of the second mc.Set."""
    box = page.locator("#graph_svg .node:has(.title:text-is('mc.Set')) [data-port='2'] .in").nth(1).bounding_box()
    return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2


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


def main(browser, options):
    walk(browser, options)
    templates(browser, options)


if __name__ == "__main__":
    run_with_browser(__doc__, main, volumes=False)
