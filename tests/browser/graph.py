#!/usr/bin/env python3
# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Tests the graph pane of `openfab view WORLD --watch` in headless Chromium. Set up and run it like view.py."""

import pathlib
import shutil
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from harness import FABLET, WORLD, Page, Viewer, check, middle, run_with_browser  # noqa: E402


def text(page):
    return page.input_value("#source")


def node(page, title):
    """Returns the middle of a node's head."""
    return middle(page, f"#graph_svg .node[aria-label='{title}'] .head")


def dot(page, title, which):
    return middle(page, f"#graph_svg .node[aria-label='{title}'] {which}")


def drag(page, start, end):
    page.mouse.move(*start)
    page.mouse.down()
    page.mouse.move((start[0] + end[0]) / 2, (start[1] + end[1]) / 2, steps=4)
    page.mouse.move(*end, steps=4)
    page.mouse.up()


def work_with(browser, options, folder, url):
    at = Page(browser, options, size=(1600, 1000), allowed="422")
    page = at.page
    at.open(url, text=True)
    page.click("#graph_button")
    page.wait_for_selector("#graph_svg .node")
    at.settle(400)
    at.shot("graph")
    check("the stage's nodes are there", page.locator("#graph_svg .node").count() >= 12)
    page.click("#graph_fit")
    at.settle(300)
    page.mouse.click(*node(page, "t = smoothstep"))
    check("a click shows a node", "smoothstep" in at.text("#inspector"))
    at.shot("graph_node")
    look_at_values(at)
    page.fill("#inspector [data-control=port0]", "0.25")
    page.keyboard.press("Enter")
    at.eventually("a value is edited in the text", lambda: "smoothstep(0.25, 1," in text(page))
    at.eventually("and saved", lambda: "smoothstep(0.25, 1," in (folder / "ball.fl").read_text())
    drag(page, dot(page, "wave = +", ".out"), dot(page, "t = smoothstep", "[data-port='0'] .in"))
    at.eventually("a wire is dragged", lambda: "smoothstep(wave, 1," in text(page))
    check("and what it needs comes before it", text(page).index("float wave") < text(page).index("float t "))
    page.focus("#graph_svg")
    page.keyboard.press("Control+z")
    at.eventually("undo brings the text back", lambda: "smoothstep(0.25, 1," in text(page))
    page.keyboard.press("Escape")
    page.keyboard.press("a")
    page.wait_for_selector("#palette:not([hidden])")
    page.fill("#palette_search", "gyroid")
    at.settle(300)
    at.shot("graph_palette")
    page.keyboard.press("Enter")
    at.eventually("a function of the library is added with its import", lambda: "import lattice;" in text(page) and "gyroid_value" in text(page))
    at.settle(600)
    at.shot("graph_added")
    page.focus("#graph_svg")
    page.keyboard.press("Delete")
    at.eventually("and deleted", lambda: "gyroid_value" not in text(page))
    drag(page, dot(page, "t = smoothstep", ".out"), dot(page, "/", "[data-port='1'] .in"))
    at.eventually("a loop is refused", lambda: "loop" in at.text("#graph_message"))
    drag(page, dot(page, "t = smoothstep", ".out"), dot(page, "mc.Set", "[data-port='1'] .in"))
    at.eventually("the compiler says what does not fit", lambda: "Material" in at.text("#graph_message"))
    page.fill("#source", text(page).replace("1 - t + t", "1 - tt + t"))
    at.eventually("an error stands at its node", lambda: page.locator("#graph_svg .node.wrong").count() == 1)
    page.fill("#source", text(page).replace("return mc;", "return (mc;"))
    at.eventually("text that cannot be read keeps the last graph", lambda: page.is_visible("#graph_stale") and page.locator("#graph_svg .node").count() >= 12)
    at.shot("graph_stale")
    page.fill("#source", text(page).replace("(mc;", "mc;").replace("1 - tt", "1 - t"))
    at.eventually("mended text is drawn again", lambda: not page.is_visible("#graph_stale") and page.locator("#graph_svg .node.wrong").count() == 0)
    answers = []
    page.on("dialog", lambda d: (answers.append(d.message), d.dismiss() if len(answers) == 1 else d.accept(d.default_value)))
    page.fill("#source", text(page).replace("// mine\n", "") + "// mine\n")
    (folder / "ball.fl").write_text(FABLET + "// other\n")
    at.eventually("what another program writes is asked about", lambda: len(answers) == 1 and "another program" in answers[0])
    check("and nothing typed is lost without a yes", "// mine" in text(page))
    (folder / "ball.fl").write_text(FABLET + "// newest\n")
    at.eventually("with a yes the newest text wins", lambda: "// newest" in text(page))
    page.wait_for_function("() => document.querySelectorAll('#graph_svg .node').length > 11")
    at.settle(600)
    page.mouse.click(*node(page, "wave = +"))
    page.focus("#graph_svg")
    page.keyboard.press("ArrowRight")
    check("arrows walk", page.locator("#graph_svg .node.selected").count() == 1 and "wave" not in page.locator("#graph_svg .node.selected").get_attribute("aria-label"))
    at.shot("graph_end")
    choose_by_keyboard(at)
    group_and_insert(at)
    at.close()


def look_at_values(at):
    """Checks pictures at nodes, and their values in a voxel; the node `t` is selected."""
    page = at.page
    start = time.monotonic()
    at.eventually("nodes show what they are over the slice", lambda: page.locator("#graph_svg .look image").count() >= 10)
    print(f"        after {time.monotonic() - start:.2f} s")
    # The middle of the first of two balls: deep inside, t is 1.
    box = page.locator("#plane").bounding_box()
    page.mouse.click(box["x"] + box["width"] / 2 - float(at.text("#zoom").split()[0]) * 7, box["y"] + box["height"] / 2)
    at.eventually("and in the voxel that is picked", lambda: "in the voxel: 1" in at.text("#inspector"))
    at.eventually("a wire says what it brings", lambda: page.locator("#graph_svg .wire title").count() >= 5)
    at.shot("graph_values")
    for over, seen in (("surface", ".look image"), ("z", ".look .curve"), ("slice", ".look image")):
        before = page.evaluate("() => document.querySelector('#graph_svg .look')?.innerHTML")
        page.select_option("#graph_over", over)
        at.eventually(f"values are shown {over}", lambda seen=seen, before=before: page.locator(f"#graph_svg {seen}").count() >= 10 and page.evaluate("() => document.querySelector('#graph_svg .look').innerHTML") != before)
        at.shot(f"graph_values_{over}")
    check("and nothing is refused", at.text("#graph_look_trouble") == "")
    page.click("#graph_look")
    check("without Values there is no picture", page.locator("#graph_svg .look").count() == 0)
    page.click("#graph_look")
    at.eventually("with it there is", lambda: page.locator("#graph_svg .look image").count() >= 10)


def choose_by_keyboard(at):
    """Selects several nodes with Shift and arrows; one step deletes them all, one restores them."""
    page = at.page
    page.focus("#graph_svg")
    page.keyboard.press("Escape")
    page.mouse.click(*node(page, "wave = +"))
    page.focus("#graph_svg")
    page.keyboard.press("Shift+ArrowLeft")
    page.keyboard.press("Shift+ArrowLeft")
    check("Shift and arrows choose more", page.locator("#graph_svg .node.selected").count() == 3 and "3 nodes are chosen" in at.text("#inspector"))
    before = text(page)
    page.keyboard.press("Delete")
    at.eventually("several are deleted", lambda: "sin(" not in text(page))
    page.wait_for_function("() => !document.body.classList.contains('graph_busy')")
    page.keyboard.press("Control+z")
    check("and come back in one step", text(page) == before)
    page.wait_for_function("() => document.querySelectorAll('#graph_svg .node').length > 11")
    at.settle(600)
    page.mouse.click(*node(page, "wave = +"))
    page.focus("#graph_svg")
    page.keyboard.press("Enter")
    page.keyboard.press("Escape")
    check("Enter goes to the node's inputs, Escape comes back", page.evaluate("document.activeElement.id") == "graph_svg")


def group_and_insert(at):
    """Makes a function from some nodes, and drops a function on a wire."""
    page = at.page
    before = text(page)
    # The page asks for its name; whoever answers dialogs here takes the one that is there.
    page.mouse.click(*node(page, "t = smoothstep"))
    page.keyboard.down("Shift")
    page.mouse.click(*node(page, "/"))
    page.keyboard.up("Shift")
    check("Shift and a click choose more", page.locator("#graph_svg .node.selected").count() == 2)
    page.keyboard.press("g")
    at.eventually(f"nodes become a function {at.text('#graph_message')}", lambda: "float part(" in text(page) and "part(" in text(page).split("@Volume")[1])
    page.wait_for_function("() => !document.body.classList.contains('graph_busy')")
    check("which is a tab", "part" in at.text("#graph_tabs"))
    page.keyboard.press("Control+z")
    at.eventually("undone", lambda: text(page) == before)
    page.click("#graph_fit")
    page.wait_for_function("() => document.querySelectorAll('#graph_svg .node').length > 11")
    page.click("#graph_add")
    page.wait_for_selector("#palette:not([hidden])")
    page.fill("#palette_search", "saturate")
    at.settle(600)
    # The wire into the second amount of `/`: a point of it that nothing covers.
    place = page.wait_for_function("""() => {
        for (const wire of document.querySelectorAll("#graph_svg .wire path.hit"))
            for (let t = 0.2; t < 0.9; t += 0.1) {
                const at = wire.getPointAtLength(t * wire.getTotalLength()).matrixTransform(wire.getScreenCTM());
                if (document.elementFromPoint(at.x, at.y)?.closest(".wire") === wire.parentNode && wire.closest(".wire").classList.contains("number")) return [at.x, at.y];
            }
    }""").json_value()
    box = page.locator("#graph_svg").bounding_box()
    page.locator("#palette_list button").first.drag_to(page.locator("#graph_svg"), target_position={"x": place[0] - box["x"], "y": place[1] - box["y"]})
    at.eventually("a function is dropped on a wire", lambda: "saturate(" in text(page) and text(page).count("saturate(") == before.count("saturate(") + 1)
    page.focus("#graph_svg")
    page.keyboard.press("Control+z")
    at.eventually("and taken off again", lambda: text(page) == before)


def look(browser, options, url):
    """Checks window sizes and colour schemes."""
    for name, size, scheme in (("graph_phone", (390, 844), "dark"), ("graph_dark", (1280, 800), "dark"), ("graph_wide", (1920, 1080), "light")):
        at = Page(browser, options, scheme=scheme, size=size)
        at.open(url)
        at.page.click("#graph_button")
        at.page.wait_for_selector("#graph_svg .node")
        at.page.locator("#graph_svg .node").last.evaluate("n => n.scrollIntoView()")
        at.page.keyboard.press("Escape")
        at.settle(500)
        at.shot(name)
        check(f"{name}: nothing is wider than the window", at.page.evaluate("document.documentElement.scrollWidth <= innerWidth"))
        at.close()


def many_nodes(browser, options, folder):
    """Checks that a chain of 300 nodes is drawn and moved without delay."""
    lines = "".join(f"        float v{i} = sin(v{i - 1}) + {i};\n" for i in range(1, 150))
    (folder / "ball.fl").write_text(FABLET.replace("        mc.Set(core", f"        float v0 = t;\n{lines}        mc.Set(core", 1))
    with Viewer(options, folder / "ball.fab.json", "--watch", "--draft", "6") as url:
        at = Page(browser, options)
        page = at.page
        at.open(url)
        start = time.monotonic()
        page.click("#graph_button")
        page.wait_for_function("() => document.querySelectorAll('#graph_svg .node').length > 290", polling=20)
        print(f"        300 nodes drawn after {time.monotonic() - start:.2f} s")
        spent = page.evaluate("""async () => {
            const box = document.getElementById("graph_svg").getBoundingClientRect();
            const start = performance.now();
            for (let i = 0; i < 30; ++i) {
                document.getElementById("graph_svg").dispatchEvent(new WheelEvent("wheel", { deltaY: i % 2 ? 40 : -40, clientX: box.x + 200, clientY: box.y + 100, cancelable: true }));
                await new Promise(requestAnimationFrame);
            }
            const busy = performance.now() - start;
            for (let i = 0; i < 30; ++i) await new Promise(requestAnimationFrame);
            return [busy / 30, (performance.now() - start - busy) / 30];
        }""")
        print(f"        {spent[0]:.1f} ms a frame while it is scaled, {spent[1]:.1f} ms at rest")
        check("300 nodes stay smooth", spent[0] < 2 * spent[1] + 60)
        at.close()


def by_hand(browser, options, folder):
    """Checks that dragging a slider changes the preview and not the text, and that two fingers scale the graph."""
    (folder / "ball.fl").write_text(FABLET)
    with Viewer(options, folder / "ball.fab.json", "--watch", "--draft", "6") as url:
        at = Page(browser, options, size=(1600, 1000))
        page = at.page
        at.open(url)
        page.click("#graph_button")
        page.wait_for_selector("#graph_svg .node")
        check("the tab that is shown stands out", page.get_attribute("#graph_tabs button:text-is('@Volume')", "aria-selected") == "true")
        page.click("#graph_fit")
        at.settle(500)
        page.mouse.click(*node(page, "t = smoothstep"))
        box = page.locator("#inspector [data-control=slide_port0]").bounding_box()
        before, at_first = text(page), at.text("#stats")
        y = box["y"] + box["height"] / 2
        page.mouse.move(box["x"] + box["width"] / 2, y)
        page.mouse.down()
        page.mouse.move(box["x"] + box["width"] * 0.2, y, steps=3)
        at.eventually("the preview follows a number that is dragged", lambda: at.text("#stats") != at_first)
        check("whose text stays", text(page) == before and (folder / "ball.fl").read_text() == before)
        there = at.text("#stats")
        page.mouse.move(box["x"] + box["width"] * 0.05, y, steps=3)
        at.eventually("and goes on", lambda: at.text("#stats") != there)
        page.mouse.up()
        at.eventually("until it is let go", lambda: text(page) != before and (folder / "ball.fl").read_text() == text(page))
        page.wait_for_function("() => document.getElementById('progress').hidden")
        check("and one step takes it back", page.evaluate("() => { document.getElementById('graph_undo').click(); return document.getElementById('source').value; }") == before)
        high = page.locator("#graph").bounding_box()
        drag(page, middle(page, "#graph_split"), (high["x"] + 200, high["y"] - 150))
        grown = page.locator("#graph").bounding_box()["height"] - high["height"]
        check(f"the bar above it gives the graph more room, {grown:.0f} px", 140 < grown < 160)
        page.focus("#graph_split")
        page.keyboard.press("ArrowDown")
        check("arrows take some of it", page.locator("#graph").bounding_box()["height"] < high["height"] + grown - 5)
        scale = page.evaluate("() => document.querySelector('#graph_svg > svg').getBoundingClientRect().width")
        box = page.locator("#graph_svg").bounding_box()
        session = page.context.new_cdp_session(page)
        def touch(kind, *apart):
            session.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": [{"x": box["x"] + box["width"] / 2 + d, "y": box["y"] + box["height"] / 2, "id": i} for i, d in enumerate(apart)]})
        touch("touchStart", -40)
        touch("touchStart", -40, 40)
        touch("touchMove", -60, 60)
        touch("touchMove", -80, 80)
        touch("touchEnd")
        grown = page.evaluate("() => document.querySelector('#graph_svg > svg').getBoundingClientRect().width") / scale
        check(f"two fingers scale it {grown:.2f} times", 1.8 < grown < 2.2)
        at.close()
    (folder / "ball.fl").write_text(FABLET.replace("return mc;", "return mm;"))
    with Viewer(options, folder / "ball.fab.json", "--watch", "--draft", "6") as url:
        at = Page(browser, options, size=(1600, 1000))
        at.page.goto(url)
        at.eventually("a world that never printed says so", lambda: "see what is wrong" in at.text("#notice") and "mm" in at.text("#diagnostics"))
        at.close()


def textures(browser, options):
    """Checks that a texture is shown at its uniform and in the graph."""
    folder = options.out / "texture_world"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    (folder / "spots.ppm").write_text("P3 4 4 255 " + " ".join("250 40 10" if (i + i // 4) % 2 else "20 90 220" for i in range(16)) + "\n")
    (folder / "ball.fl").write_text(FABLET.replace("Material core", "ImageTexture2D spots;\n        Material core").replace("float wave = 0.5", "float2 uv = attr.voxelCenter.xy / 12;\n        float wave = 0.2 * spots.Sample1(uv, 0) + 0.5"))
    (folder / "ball.fab.json").write_text(WORLD.replace('"meshes"', '"textures": {"spots": {"file": "spots.ppm"}},\n    "meshes"').replace('"core": "white"', '"spots": "spots", "core": "white"'))
    with Viewer(options, folder / "ball.fab.json", "--watch", "--draft", "6") as url:
        at = Page(browser, options, size=(1600, 1000))
        at.open(url)
        at.eventually("a texture is shown at its uniform", lambda: at.page.evaluate("() => document.querySelector('#uniforms img.thumb')?.naturalWidth") == 4)
        at.page.click("#graph_button")
        at.page.wait_for_selector("#graph_svg .node")
        at.eventually("and in the graph", lambda: at.page.locator("#graph_svg .node[aria-label='spots'] .look image").count() == 1)
        at.settle(3000)
        at.shot("graph_texture")
        at.close()


def main(browser, options):
    folder = options.out / "graph_world"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    (folder / "ball.fl").write_text(FABLET)
    (folder / "ball.fab.json").write_text(WORLD)
    with Viewer(options, folder / "ball.fab.json", "--watch", "--draft", "6") as url:
        work_with(browser, options, folder, url)
        look(browser, options, url)
    by_hand(browser, options, folder)
    many_nodes(browser, options, folder)
    textures(browser, options)


if __name__ == "__main__":
    run_with_browser(__doc__, main, volumes=False)
