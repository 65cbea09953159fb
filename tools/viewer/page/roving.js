// A group with one stop of Tab: arrows, Home and End go through what it holds.

const kBy = { ArrowLeft: -1, ArrowUp: -1, ArrowRight: 1, ArrowDown: 1 };
const isCurrent = (one) => ["aria-checked", "aria-selected"].some((name) => one.getAttribute(name) === "true");

/** Tab comes to one of these alone. */
export function oneStop(list, stop) {
    for (const one of list) one.tabIndex = one === stop ? 0 : -1;
}

/** `choose`: what the focus comes to is chosen, as by a click. What it holds may be made anew at any time. */
export function rove(group, { choose = false, items = "button" } = {}) {
    const all = () => [...group.querySelectorAll(items)].filter((one) => !one.hidden && !one.disabled);
    const mark = () => {
        const list = all();
        oneStop(list, list.includes(document.activeElement) ? document.activeElement : list.find(isCurrent) ?? list[0]);
    };
    group.addEventListener("focusin", mark);
    group.addEventListener("keydown", (event) => {
        if (event.ctrlKey || event.altKey || event.metaKey || event.shiftKey) return;
        const list = all();
        const at = list.indexOf(event.target);
        const to = { Home: 0, End: list.length - 1 }[event.key] ?? at + kBy[event.key];
        if (at < 0 || Number.isNaN(to)) return;
        event.preventDefault();
        event.stopPropagation();
        const next = list[(to + list.length) % list.length];
        next.focus();
        if (choose) next.click();
    });
    new MutationObserver(mark).observe(group, { childList: true, subtree: true, attributes: true, attributeFilter: ["aria-checked", "aria-selected", "disabled", "hidden"] });
    mark();
}
