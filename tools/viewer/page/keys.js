// Keys of the whole page. Fields, buttons in a group and sliders have their own use of some.

const kMoves = { ArrowUp: [0, 40], ArrowDown: [0, -40], ArrowLeft: [40, 0], ArrowRight: [-40, 0] };

/**
 * `act` has step(by), goTo(place), limits(), showing(), setView(view), setWhich(which), save(), ready() and model; a
 * view has zoom(factor), fit(), pan(dx, dy) and, of the volume, turnBy(dx, dy).
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
        "?": () => help.showModal(),
    };
    document.addEventListener("keydown", (event) => {
        if (event.ctrlKey || event.altKey || event.metaKey || help.open) return;
        const target = event.target;
        if (target.matches("textarea, select, input:not([type=checkbox]):not([type=color])") && target.id !== "slider") return;
        if (!act.ready() && event.key !== "?") return;
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
