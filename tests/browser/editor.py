#!/usr/bin/env python3
# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Tests the editor of `openfab view WORLD --watch` in headless Chromium: help while typing, one history for text and graph, two
windows, edits by another program, leaving the page. Set up and run it like view.py."""

import pathlib
import shutil
import sys

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from graph import node, text  # noqa: E402
from harness import FABLET, WORLD, Page, Viewer, check, run_with_browser  # noqa: E402


def caret(page, before):
    """Places the caret before a piece of the text."""
    page.focus("#source")
    page.evaluate("(at) => document.getElementById('source').setSelectionRange(at, at)", text(page).index(before))


def type_with_help(at):
    page = at.page
    check("words have their colours", page.evaluate("""() => getComputedStyle(document.querySelector("#marks .keyword")).color !== getComputedStyle(document.querySelector("#marks .number")).color"""))
    caret(page, "        return mc;")
    page.keyboard.type("        float q = smoo")
    page.wait_for_selector("#completions:not([hidden])")
    check("names are completed", "smoothstep" in at.text("#completions"))
    at.shot("editor_completion")
    page.keyboard.press("Tab")
    check("by Tab", "float q = smoothstep        return" in text(page))
    page.keyboard.type("(0, ")
    page.wait_for_selector("#source_note:not([hidden])")
    check("a call says what it takes", at.text("#source_note b").strip() == "floatN to")
    at.shot("editor_signature")
    page.keyboard.type("1, attr.vox")
    page.wait_for_selector("#completions:not([hidden])")
    page.keyboard.press("Enter")
    page.keyboard.type(".x);")
    page.keyboard.press("Enter")
    check("Enter keeps the indentation", "smoothstep(0, 1, attr.voxelCenter.x);\n                return mc;" in text(page))
    at.eventually("what was typed has no error", lambda: page.locator("#marks mark.error").count() == 0)
    page.keyboard.press("Alt+Shift+f")
    at.eventually("it is laid out", lambda: "attr.voxelCenter.x);\n        return mc;" in text(page))
    caret(page, "float wave")
    page.keyboard.press("Control+/")
    check("a line becomes a comment", "        // float wave" in text(page))
    page.keyboard.press("Control+/")
    check("and is one again", "        float wave" in text(page))
    caret(page, "wave = 0.5")
    page.keyboard.press("F1")
    page.wait_for_selector("#source_note:not([hidden])")
    check("F1 says what a name is", "float wave" in at.text("#source_note"))
    page.keyboard.press("Escape")


def mark_and_hover(at):
    page = at.page
    page.fill("#source", FABLET.replace("t * wave);", "t * wavy);"))
    page.wait_for_selector("#marks mark.error")
    box = page.locator("#marks mark.error").first.bounding_box()
    page.mouse.move(box["x"] + 6, box["y"] + 6)
    page.wait_for_selector("#source_note:not([hidden])")
    check("a mistake says what it is where the mouse rests", "wavy" in at.text("#source_note"))
    at.shot("editor_mistake")
    page.mouse.move(5, 5)


def one_history(at, folder):
    page = at.page
    page.fill("#source", FABLET)
    page.keyboard.press("Control+s")
    at.eventually("saved", lambda: (folder / "ball.fl").read_text() == FABLET)
    at.settle(1500)  # a pause ends the step
    if not page.is_visible("#graph"):
        page.click("#graph_button")
    page.wait_for_selector("#graph_svg .node")
    page.wait_for_function("() => document.querySelectorAll('#graph_svg .node').length > 11")
    caret(page, "rings * attr")
    page.keyboard.type("2 * ")
    at.eventually("what is typed is drawn", lambda: page.locator("#graph_svg .node").count() >= 14)
    page.click("#graph_fit")
    at.settle(400)
    page.mouse.click(*node(page, "t = smoothstep"))
    page.fill("#inspector [data-control=port0]", "0.25")
    page.keyboard.press("Enter")
    at.eventually("the graph edits what was typed", lambda: "smoothstep(0.25, 1," in text(page) and "2 * rings" in text(page))
    page.focus("#source")
    page.keyboard.press("Control+z")
    check("undo in the text takes back what the graph did", "smoothstep(0.5, 1," in text(page) and "2 * rings" in text(page))
    page.keyboard.press("Control+z")
    check("and then what was typed", text(page) == FABLET)
    page.focus("#graph_svg")
    page.keyboard.press("Control+Shift+z")
    at.eventually("redo in the graph brings it back", lambda: "2 * rings" in text(page))
    page.keyboard.press("Control+z")
    page.click("#graph_button")


def two_windows(browser, options, folder, url, at):
    page = at.page
    page.fill("#source", FABLET)
    page.keyboard.press("Control+s")
    at.eventually("all is saved", lambda: (folder / "ball.fl").read_text() == FABLET and page.is_disabled("#save"))
    other = Page(browser, options, size=(1100, 800), allowed="422")
    other.open(url, text=True)
    questions = []
    page.on("dialog", lambda d: (questions.append(d.message), d.dismiss() if "another program" in d.message and len(questions) == 1 else d.accept()))
    other.page.on("dialog", lambda d: d.accept())
    caret(page, "        return mc;")
    page.keyboard.type("// mine")
    page.keyboard.press("Enter")
    other.page.fill("#source", FABLET.replace("rings = 4", "rings = 5"))
    other.page.keyboard.press("Control+s")
    at.eventually("a second window's text is asked about", lambda: len(questions) == 1)
    check("what was typed here stays", "// mine" in text(page))
    page.keyboard.press("Control+s")
    at.eventually("and replaces the other where that is wanted", lambda: "// mine" in (folder / "ball.fl").read_text())
    other.eventually("which the other window takes, for nothing was typed there", lambda: "// mine" in text(other.page))
    (folder / "ball.fl").write_text(FABLET + "// newest\n")
    for name, one in (("this", at), ("the other", other)):
        one.eventually(f"the newest text is in {name} window", lambda one=one: text(one.page).endswith("// newest\n"))
    check("without a question, for all was saved", len(questions) == 1)
    page.focus("#source")
    page.keyboard.press("Control+z")
    check("and what was there comes back by undoing", "// mine" in text(page))
    leaving = []
    page.on("dialog", lambda d: leaving.append(d.type))
    page.close(run_before_unload=True)
    other.eventually("a page with text that is not saved asks before it is left", lambda: leaving == ["beforeunload"])
    other.close()


def main(browser, options):
    folder = options.out / "editor_world"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    (folder / "ball.fl").write_text(FABLET)
    (folder / "ball.fab.json").write_text(WORLD)
    with Viewer(options, folder / "ball.fab.json", "--watch", "--draft", "8") as url:
        at = Page(browser, options, size=(1600, 1000), allowed="422")
        at.open(url, text=True)
        type_with_help(at)
        mark_and_hover(at)
        one_history(at, folder)
        two_windows(browser, options, folder, url, at)
        long_text(browser, options, folder, url)


def long_text(browser, options, folder, url):
    """Checks that only visible lines are drawn, each at its place."""
    lines = "".join(f"        // {i}\n" for i in range(3000))
    (folder / "ball.fl").write_text(FABLET.replace("        return mc;", f"{lines}        return mc;"))
    at = Page(browser, options, allowed="422")
    page = at.page
    at.open(url, text=True)
    at.eventually("a long text is there", lambda: len(text(page).split("\n")) > 3000)
    page.evaluate("() => { document.getElementById('editor').scrollTop = 2000 * 18; }")
    at.eventually("its lines are drawn where one looks", lambda: "// 1995" in at.text("#marks") and page.locator("#gutter span").count() < 200)
    drawn = page.evaluate("""() => {
        const line = [...document.querySelectorAll("#marks .comment")].find((one) => one.textContent === "// 1995").getBoundingClientRect();
        return line.top - document.getElementById("source").getBoundingClientRect().top;
    }""")
    check("in the place of the letters that are edited", abs(drawn - (4 + 18 * (1995 + FABLET.split("        return mc;")[0].count(chr(10))))) < 4)
    at.shot("editor_long")
    at.close()


if __name__ == "__main__":
    run_with_browser(__doc__, main, volumes=False)
