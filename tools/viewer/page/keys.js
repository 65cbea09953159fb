// Keys of the whole page. Fields, buttons in a group and sliders have their own use of some.

const kMoves = { ArrowUp: [0, 40], ArrowDown: [0, -40], ArrowLeft: [40, 0], ArrowRight: [-40, 0] };

/** What F6 goes through: a part of the page, and what in it gets the focus. */
const kRegions = [["live", "button, select, input"], ["stage", "canvas[tabindex]:not([hidden])"], ["text", "textarea"], ["graph", "#graph_svg"], ["details", "button, input"]];

/** The part of the page after the one that has the focus, or before it. */
function nextRegion(by) {
    const open = kRegions.filter(([id]) => document.getElementById(id).getClientRects().length > 0);
    const now = open.findIndex(([id]) => document.getElementById(id).contains(document.activeElement));
    const to = now < 0 ? (by > 0 ? 0 : open.length - 1) : (now + by + open.length) % open.length;
    [...document.querySelectorAll(open[to][1].split(", ").map((one) => `#${open[to][0]} ${one}`).join(", "))].find((one) => !one.disabled && one.tabIndex >= 0 && one.getClientRects().length > 0)?.focus();
}

/** Out of a field, which keeps what it had, to the picture. */
function leave(field, canvas) {
    if (field.matches("[data-control][type=number]")) field.value = field.defaultValue;
    canvas.focus({ preventScroll: true });
}

/**
 * `act` has step(by), goTo(place), limits(), showing(), setView(view), setWhich(which), save(), ready() and model, and press(id)
 * for what a world is changed by; a view has zoom(factor), fit(), pan(dx, dy) and, of the volume, turnBy(dx, dy).
 */
export function listenToKeys(act, cursor, help) {
    const keys = {
        ArrowUp: () => act.step(1), ArrowDown: () => act.step(-1), ArrowRight: () => act.step(1), ArrowLeft: () => act.step(-1),
        PageUp: () => act.step(10), PageDown: () => act.step(-10),
        Home: () => act.goTo(act.limits().low), End: () => act.goTo(act.limits().high),
        "+": () => act.showing().zoom(1.25), "=": () => act.showing().zoom(1.25), "-": () => act.showing().zoom(0.8), 0: () => act.showing().fit(),
        1: () => act.setView("z"), 2: () => act.setView("y"), 3: () => act.setView("x"), 4: () => act.setView("3"),
        a: () => act.setWhich("0"), b: () => act.setWhich("1"), d: () => act.setWhich("diff"),
        m: () => act.model.measure.toggle(), s: () => act.save(),
        Escape: () => act.model.measure.toggle(false),
        o: () => act.press("add_file"), g: () => act.press("graph_button"), p: () => document.querySelector("#part [data-control]")?.focus(),
        "?": () => help.showModal(),
    };
    const always = new Set(["?", "o", "g", "p"]);
    document.addEventListener("keydown", (event) => {
        if (help.open) return;
        const target = event.target;
        if (event.key === "F6") {
            event.preventDefault();
            return nextRegion(event.shiftKey ? -1 : 1);
        }
        if ((event.ctrlKey || event.metaKey) && event.key.toLowerCase() === "p" && act.press("print")) return event.preventDefault();
        if (event.ctrlKey || event.altKey || event.metaKey) return;
        if (event.key === "Escape" && target.matches("#live input, #live select, #stage input, #details input")) return leave(target, act.showing().canvas);
        if (target.matches("textarea, select, input:not([type=checkbox]):not([type=color])") && target.id !== "slider") return;
        if (!act.ready() && !always.has(event.key.toLowerCase())) return;
        const onControl = target.matches("button, input, summary, a");
        if (!(onControl && event.key === "Enter") && cursor.key(event)) return event.preventDefault();
        if (event.shiftKey && kMoves[event.key]) {
            event.preventDefault();
            const view = act.showing();
            if (view.turnBy) view.turnBy(...kMoves[event.key].map((v) => v / 2));
            else view.pan(...kMoves[event.key]);
            return;
        }
        const action = keys[event.key] ?? keys[event.key.toLowerCase()];
        if (!action) return;
        event.preventDefault();
        action();
    });
}
