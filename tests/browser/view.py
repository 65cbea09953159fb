#!/usr/bin/env python3
# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Tests `openfab view` in headless Chromium. Neither the set-up nor `scripts/test` includes the steps that it needs:

    python3 -m venv out/browser/venv && out/browser/venv/bin/pip install playwright
    apt-get install chromium                  # or: out/browser/venv/bin/playwright install chromium
    out/browser/venv/bin/python tests/browser/view.py [--bin build/release/bin] [--out out/browser] [--page tools/viewer/page]

It checks what a script can check, exits with 1 if something is wrong, and leaves screenshots in --out for you to look at."""

import re
import subprocess

from harness import FABLET, WORLD, Page, Viewer, check, numbers_of, run_with_browser

SHEET = """fablet Sheet {
    @uniform { Material white, black; }
    @Volume(@varying { VolumeAttributes attr })
    {
        MaterialComposition mc;
        float3 p = attr.voxelCenter;
        float ink = p.z > 3.5 ? 0.5 + 0.5 * sin(2 * p.x) * sin(2 * p.y) : 0;
        mc.Set(white, 1 - ink);
        mc.Set(black, ink);
        return mc;
    }
}
"""

SHEET_WORLD = """{
    "openfab": 1,
    "printer": "j750",
    "fablets": {"sheet": {"source": "sheet.fl", "fablet": "Sheet"}},
    "materials": {"white": {"key": "#ffffff", "preview": "#f4f2ecff"}, "black": {"key": "#000000", "preview": "#161616ff"}},
    "meshes": {"box": {"box": [30, 20, 4]}},
    "objects": {"sheet": {"mesh": "box", "fablet": "sheet", "uniforms": {"white": "white", "black": "black"}}},
    "build": [{"object": "sheet"}]
}
"""

def look_at_a_print(browser, options, url):
    at = Page(browser, options)
    at.open(url)
    page = at.page
    check("a slice has colours", at.colors("#plane") >= 4)
    at.shot("slice")
    number = int(page.input_value("#number"))
    first = at.pixels("#plane")
    page.keyboard.press("PageUp")
    at.settle()
    check("Page up goes ten slices up", int(page.input_value("#number")) == number + 10)
    check("and shows another slice", at.pixels("#plane") != first)
    page.mouse.click(420, 430)
    at.settle()
    check("a click names the material", "Material" in at.text("#pick") and "mm" in at.text("#pick"))
    page.wait_for_function("() => /dither:[^]*\\d %/.test(document.getElementById('pick').innerText)", timeout=60_000)
    check("and what the dither was given there", "." in at.text("#pick"))
    at.shot("picked")
    before = at.pixels("#plane")
    page.click("#materials li:nth-child(2) input[type=checkbox]")
    at.settle()
    check("a switch hides a material", at.pixels("#plane") != before)
    page.click("#materials li:nth-child(2) input[type=checkbox]")
    for _ in range(9):
        page.keyboard.press("+")
    at.settle()
    at.shot("zoomed")
    check("zoom is shown", "px/mm" in at.text("#zoom"))
    page.keyboard.press("0")
    page.keyboard.press("2")
    at.settle(2000)
    check("a cut has colours", at.colors("#plane") >= 4)
    at.shot("cut")
    page.keyboard.press("4")
    at.settle(4000)
    turned = at.pixels("#volume")
    check("the volume has colours", at.colors("#volume") >= 8)
    at.shot("volume")
    page.mouse.move(500, 400)
    page.mouse.down()
    page.mouse.move(650, 380, steps=8)
    page.mouse.up()
    at.settle()
    check("it turns", at.pixels("#volume") != turned)
    page.click("[data-clip='1']")
    at.settle()
    at.shot("volume_cut")
    page.keyboard.press("?")
    check("the keys are listed", page.is_visible("#help"))
    page.keyboard.press("Escape")
    page.keyboard.press("1")
    for _ in range(4):
        page.keyboard.press("Tab")
    check("Tab reaches the controls", page.evaluate("document.activeElement.matches('button, input, canvas')"))
    at.close()


def look_in_3d(browser, options, url):
    """Checks standard views, picking, cuts, measuring and the picture with the mouse."""
    at = Page(browser, options)
    page = at.page
    at.open(url)
    page.keyboard.press("4")
    at.settle(4000)
    seen = {at.pixels("#above")}
    for name in ("top", "bottom", "front", "back", "left", "right"):
        page.click(f"#standpoints button:text-is('{name}')")
        at.eventually(f"{name} is another view", lambda: at.pixels("#above") not in seen)
        seen.add(at.pixels("#above"))
    box = page.locator("#volume").bounding_box()
    # From the front, the tip of z is above the middle of the axes: a click at it looks from above.
    page.click("#standpoints button:text-is('front')")
    page.mouse.click(box["x"] + box["width"] - 58, box["y"] + box["height"] - 66 - 34)
    at.eventually("the tips of the axes turn the volume", lambda: "camera=0,1.5708" in page.url)
    page.click("#standpoints button:text-is('front')")
    at.settle(600)
    # The first of two balls, whose middle is a fourth of the way along x.
    ball = (box["x"] + box["width"] / 2 - float(at.text("#zoom").split()[0]) * 7, box["y"] + box["height"] / 2)
    page.mouse.click(*ball)
    page.wait_for_function("() => document.getElementById('pick').innerText.includes('Position')")
    x, y, z = numbers_of(at.text("#pick").split("Position")[1])[:3]
    check("a click in 3-D picks the surface in front", abs(x) < 0.5 and -6.2 < y < -5.4 and abs(z - 6) < 0.5)
    at.eventually("the slice's figures follow", lambda: at.text("#slice_title").split()[-1] == at.text("#pick").split("Voxel")[1].split()[2])
    check("which is solid", "void" not in at.text("#pick").split("Position")[0])
    before = at.pixels("#volume")
    page.click("[data-clip='1']")
    at.settle(1500)
    check("a cut shows what is inside", at.pixels("#volume") != before and at.text("#slider_label") == "Cut y")
    page.eval_on_selector("#slider", "s => { s.value = Math.floor(s.max / 2); s.dispatchEvent(new Event('input')); }")
    at.settle(1000)
    page.mouse.click(*ball)
    page.wait_for_function("y => !document.getElementById('pick').innerText.includes(y)", arg=f"{y:.3f}")
    check("and a click there picks the cut", abs(numbers_of(at.text("#pick").split("Position")[1])[1]) < 0.6)
    at.shot("volume_cut_y")
    page.keyboard.press("m")
    page.mouse.click(*ball)
    page.mouse.click(ball[0] + float(at.text("#zoom").split()[0]) * 3, ball[1])
    check("two points are measured", abs(numbers_of(at.text("#measured").split("Distance")[1])[0] - 3) < 0.05)
    at.settle(600)
    at.shot("measured")
    with page.expect_download() as download:
        page.click("#save_picture")
    picture = options.out / download.value.suggested_filename
    download.value.save_as(picture)
    check("a picture is saved", picture.name == "a-3-D.png" and picture.read_bytes()[:4] == b"\x89PNG")
    # All of it comes back at the same address, in another window as well.
    at.settle(400)
    shown = [page.url] + [at.text(s) for s in ("#pick", "#measured", "#height", "#zoom")]
    again = Page(browser, options)
    again.open(page.url, view=None)
    again.eventually("the address brings it back", lambda: [again.page.url] + [again.text(s) for s in ("#pick", "#measured", "#height", "#zoom")] == shown)
    again.eventually("and the picture", lambda: again.pixels("#above") == at.pixels("#above"))
    again.close()
    page.click("#measure_clear")
    page.keyboard.press("Escape")
    check("a measure is forgotten", not page.is_visible("#measure_panel"))
    at.close()


# Where lengths are written, and how near to the middle of the axes' disc: the last of each.
WRITTEN = """
    window.written = {}; window.disc = null;
    const { fillText, arc } = CanvasRenderingContext2D.prototype;
    CanvasRenderingContext2D.prototype.fillText = function (text, x, y) {
        if (/^[xyz] [0-9.]+ mm$/.test(text)) window.written[text[0]] = { x, y, half: this.measureText(text).width / 2 };
        return fillText.apply(this, arguments);
    };
    CanvasRenderingContext2D.prototype.arc = function (x, y, radius) {
        if (radius > 20) window.disc = { x, y, radius };
        return arc.apply(this, arguments);
    };
"""
NEAREST = """() => Math.min(...Object.values(window.written).map(({ x, y, half }) => Math.hypot(
    Math.max(Math.abs(x - window.disc.x) - half, 0), Math.max(Math.abs(y - window.disc.y) - 6, 0)) - window.disc.radius))"""


def look_in_a_narrow_window(browser, options, url):
    """Lengths stand beside the disc of the axes, wherever one looks from."""
    at = Page(browser, options, size=(400, 800))
    page = at.page
    page.add_init_script(WRITTEN)
    at.open(url, view="3")
    at.settle(3000)
    box = page.locator("#volume").bounding_box()
    room = [page.evaluate(NEAREST)]
    for _ in range(9):
        page.mouse.move(box["x"] + 60, box["y"] + 60)
        page.mouse.down()
        page.mouse.move(box["x"] + 90, box["y"] + 64, steps=2)
        page.mouse.up()
        at.settle(300)
        room.append(page.evaluate(NEAREST))
    check("lengths stand beside the axes", page.evaluate("Object.keys(window.written).length") == 3 and min(room) >= 0)
    at.close()


def look_by_keyboard(browser, options, url):
    at = Page(browser, options)
    page = at.page
    at.open(url)
    z = page.input_value("#number")
    page.keyboard.press("Enter")
    check("Enter shows a cursor", page.is_visible("#cursor"))
    for key in ["ArrowLeft"] * 4 + ["Shift+ArrowLeft"] * 4 + ["ArrowUp"]:
        page.keyboard.press(key)
    where = numbers_of(at.text("#hover"))
    page.keyboard.press("Enter")
    page.wait_for_function("() => document.getElementById('pick').innerText.includes('Position')")
    check("and picks there", [abs(a - b) < 0.001 for a, b in zip(where, numbers_of(at.text("#pick").split("Position")[1]))] == [True] * 3)
    check("arrows have not left the slice", page.input_value("#number") == z)
    page.keyboard.press("m")
    page.keyboard.press("Enter")
    page.keyboard.press("Shift+ArrowRight")
    page.keyboard.press("Shift+ArrowRight")
    page.keyboard.press("Enter")
    check("and measures", abs(numbers_of(at.text("#measured").split("Distance")[1])[0] - 80 / float(at.text("#zoom").split()[0])) < 0.01)
    at.shot("keyboard")
    page.keyboard.press("Escape")
    check("Escape ends the cursor", not page.is_visible("#cursor"))
    page.keyboard.press("ArrowUp")
    check("then arrows go through the slices", int(page.input_value("#number")) == int(z) + 1)
    page.keyboard.press("4")
    at.settle(4000)
    page.keyboard.press("Enter")
    page.keyboard.press("Shift+ArrowLeft")
    before = at.text("#pick")
    page.keyboard.press("Shift+ArrowLeft")
    page.keyboard.press("Escape")
    page.keyboard.press("Escape")
    page.keyboard.press("Enter")
    for _ in range(3):
        page.keyboard.press("Shift+ArrowLeft")
    page.keyboard.press("Enter")
    page.wait_for_function("before => document.getElementById('pick').innerText !== before", arg=before)
    check("in 3-D, too", "void" not in at.text("#pick").split("Position")[0])
    at.close()


def look_at_a_server_that_ends(browser, options, print_a):
    at = Page(browser, options, allowed="ERR_")
    with Viewer(options, print_a) as url:
        at.open(url)
        check("while the server answers, nothing is said of it", not at.page.is_visible("#connection"))
        stranger = Page(browser, options, allowed="403")
        stranger.page.goto(url.split("#")[0])
        stranger.page.wait_for_function("() => document.getElementById('notice').innerText.includes('the token is wrong')")
        stranger.close()
    at.page.wait_for_selector("#connection:not([hidden])", timeout=60_000)
    check("a server that ended is told, over a picture that stays", at.colors("#plane") >= 4 and not at.page.is_visible("#notice"))
    at.close()


def look_at_what_opens(browser, options):
    """Checks the first view of a blank sheet with a picture on top, such as a postcard."""
    folder = options.out / "sheet"
    folder.mkdir(exist_ok=True)
    (folder / "sheet.fl").write_text(SHEET)
    (folder / "sheet.fab.json").write_text(SHEET_WORLD)
    file = options.out / "sheet.ofr"
    subprocess.run([options.bin / "openfab", "print", folder / "sheet.fab.json", "-o", file, "--draft", "2", "--progress", "none"], check=True)
    with Viewer(options, file) as url:
        at = Page(browser, options)
        at.open(url)
        check("a print opens on what there is to see", "black" in at.text("#slice_stats") and at.colors("#plane") >= 4)
        at.shot("opening")
        at.close()


def look_at_the_rest(browser, options, print_a, print_b):
    with Viewer(options, print_a, print_b) as url:
        at = Page(browser, options, "dark")
        at.open(url)
        at.page.keyboard.press("d")
        at.settle()
        check("different voxels are counted", "Different" in at.text("#slice_stats"))
        check("by what became of what", "→" in at.text("#slice_stats"))
        at.shot("difference")
        at.page.keyboard.press("4")
        at.page.wait_for_function("() => location.hash.includes('print=diff') && location.hash.includes('view=3')")
        at.settle(4000)
        different = at.pixels("#volume")
        check("a difference is shown in 3-D", at.page.get_attribute("[data-print=diff]", "aria-checked") == "true" and at.colors("#volume") >= 8)
        at.shot("difference_3d")
        at.page.keyboard.press("a")
        at.eventually("and is not the first print", lambda: at.pixels("#volume") != different)
        at.close()
    other = options.out / "other.ofr"
    subprocess.run([options.bin / "openfab", "print", options.out / "world" / "ball.fab.json", "-o", other, "--draft", "3", "--progress", "none"], check=True)
    with Viewer(options, print_a, other) as url:
        at = Page(browser, options)
        at.open(url)
        button = at.page.locator("[data-print=diff]")
        check("where there is none, the button says why", button.get_attribute("aria-disabled") == "true" and "grids of one size" in button.get_attribute("title"))
        button.click(force=True)
        check("and a click, too", "grids of one size" in at.text("#notice"))
        at.close()
    half = options.out / "half.ofr"
    half.write_bytes(print_a.read_bytes()[: print_a.stat().st_size // 2])
    with Viewer(options, half) as url:
        at = Page(browser, options, size=(800, 900))
        at.open(url)
        check("an unfinished print says so", "slices" in at.text("#progress"))
        at.shot("unfinished_narrow")
        half.write_bytes(print_a.read_bytes())
        at.page.wait_for_selector("#progress", state="hidden", timeout=10_000)
        check("and is seen to end", "yes" in at.text("#stats"))
        at.close()


def look_at_a_world(browser, options, world):
    with Viewer(options, world, "--watch", "--draft", "3") as url:
        at = Page(browser, options, "dark")
        page = at.page
        at.open(url, text=True)
        page.wait_for_selector("#progress", state="hidden", timeout=120_000)
        before = at.text("#stats")
        page.eval_on_selector("#uniforms input[type=range]", "r => { r.value = 2.5; r.dispatchEvent(new Event('input')); }")
        page.wait_for_function("before => document.getElementById('stats').innerText !== before", arg=before, timeout=60_000)
        check("a slider makes another print", page.is_enabled("#write"))
        source = page.input_value("#source")
        number = page.locator("#uniforms input[type=number]").first
        number.fill("-99")
        number.press("Tab")
        page.wait_for_selector(".uniform.wrong", timeout=60_000)
        check("a refused value is told at its uniform", "its `min` is 0.1" in at.text(".uniform.wrong") and not page.is_visible("#notice"))
        check("and cannot be written", page.is_disabled("#write"))
        at.shot("live_refused")
        number.fill("2.5")
        number.press("Tab")
        page.wait_for_selector(".uniform.wrong", state="detached", timeout=60_000)
        page.wait_for_function("() => !document.getElementById('write').disabled", timeout=60_000)
        page.fill("#source", source.replace("t * wave)", "t * wav)"))
        page.wait_for_selector("#marks mark", timeout=30_000)
        check("a mistake is marked at its line", "line 13" in at.text("#diagnostics"))
        at.shot("live_mistake")
        page.fill("#source", source.replace("voxelCenter.z", "voxelCenter.x"))
        before = at.text("#stats")
        page.keyboard.press("Control+s")
        page.wait_for_function("before => document.getElementById('stats').innerText !== before", arg=before, timeout=120_000)
        check("what was saved is on disk", "voxelCenter.x" in (world.parent / "ball.fl").read_text())
        stats = at.text("#stats")
        page.fill("#source", source.replace("t * wave)", "t * wav)"))
        page.keyboard.press("Control+s")
        page.wait_for_selector("#marks mark", timeout=60_000)
        at.settle(3000)
        check("a mistake that was saved leaves the print in view", at.text("#stats") == stats and at.colors("#plane") >= 3)
        page.fill("#source", source.replace("voxelCenter.z", "voxelCenter.x"))
        page.keyboard.press("Control+s")
        page.wait_for_selector("#marks mark", state="detached", timeout=60_000)
        text = world.read_text()
        world.write_text(text.replace('{"sphere": 12}', '{"file": "gone.obj", "unit": "mm"}'))
        page.wait_for_function("() => document.body.innerText.includes('gone.obj')", timeout=60_000)
        check("a mesh that is missing is named", at.colors("#plane") >= 3)
        world.write_text(text[:200])
        page.wait_for_function("() => document.getElementById('world_message').innerText.includes('ball.fab.json:')", timeout=60_000)
        check("controls stay while the world is wrong", page.locator("#uniforms input[type=range]").count() == 2)
        at.shot("live_no_mesh")
        world.write_text(text)
        page.wait_for_function("() => !document.body.innerText.includes('gone.obj')", timeout=120_000)
        other = Page(browser, options, size=(520, 900))
        other.open(url)
        before = other.text("#stats")
        page.eval_on_selector("#uniforms input[type=range]", "r => { r.value = 2; r.dispatchEvent(new Event('input')); }")
        other.page.wait_for_function("before => document.getElementById('stats').innerText !== before", arg=before, timeout=120_000)
        other.settle()
        check("a second page follows the first", other.page.input_value("#uniforms input[type=range]") == "2")
        other.shot("second_page_narrow")
        page.eval_on_selector("#uniforms input[type=range]", "r => { r.value = 2.5; r.dispatchEvent(new Event('input')); }")
        other.page.wait_for_function("() => document.querySelector('#uniforms input[type=range]').value === '2.5'", timeout=120_000)
        other.close()
        page.click("#write")
        page.wait_for_function("() => document.getElementById('write').disabled", timeout=60_000)
        check("the slider's value is in the world", '"skin": 2.5' in world.read_text())
        page.keyboard.press("Escape")
        page.click("[data-view='3']")
        at.settle(3000)
        page.click("[data-clip='1']")
        at.settle(1500)
        at.shot("live")
        at.close()


def look_while_prints_are_replaced(browser, options, world):
    """A print is replaced while pictures of it are asked for, and the page hears of the new one before it is refused the old."""
    with Viewer(options, world, "--watch", "--draft", "6") as url:
        for what, pattern, view in (("volume", "**/api/volume?*", "3"), ("slice", "**/api/tile?*", "z")):
            at = Page(browser, options)
            page = at.page
            at.open(url, view=view)
            held, asked = [], []

            def answer(route):
                asked.append(re.search(r"generation=(\d+)", route.request.url)[1])
                if held or len(set(asked)) < 2:
                    return route.continue_()
                held.append(route)

            page.route(pattern, answer)
            page.evaluate("dispatchEvent(new Event('resize'))")
            for draft in ("4", "3"):
                before = at.text("#subtitle")
                asked.append("0")
                page.select_option("#draft", draft)
                at.eventually(f"{what}: a draft of {draft} is shown", lambda before=before: at.text("#subtitle") != before)
                at.settle(600)
            check(f"{what}: a picture of the print between was asked for", len(held) == 1)
            late = re.search(r"generation=(\d+)", held[0].request.url)[1]
            held[0].fulfill(status=409, json={"error": "another print is shown now"})
            at.eventually(f"{what}: that of the new print is asked for then", lambda late=late: int(asked[-1]) > int(late))
            page.select_option("#draft", "6")
            at.settle(3000)
            at.close()


def main(browser, options):
    folder = options.out / "world"
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "ball.fl").write_text(FABLET)
    world = folder / "ball.fab.json"
    world.write_text(WORLD)
    prints = [options.out / "a.ofr", options.out / "b.ofr"]
    for file, extra in zip(prints, ([], ["--set", "ball.skin=0.9"])):
        subprocess.run([options.bin / "openfab", "print", world, "-o", file, "--draft", "2", "--progress", "none", *extra], check=True)
    with Viewer(options, prints[0], "--world", world) as url:
        look_at_a_print(browser, options, url)
        look_in_3d(browser, options, url)
        look_in_a_narrow_window(browser, options, url)
        look_by_keyboard(browser, options, url)
    look_at_a_server_that_ends(browser, options, prints[0])
    look_at_what_opens(browser, options)
    look_at_the_rest(browser, options, *prints)
    look_at_a_world(browser, options, world)
    look_while_prints_are_replaced(browser, options, world)


if __name__ == "__main__":
    run_with_browser(__doc__, main)
