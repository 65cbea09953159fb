// Parts of the page that are shown when asked for: the graph, the text, details of the print.

const byId = (id) => document.getElementById(id);
const kColumn = "(max-width: 900px)";

/** Tab goes through the parts of the page as they stand: in one column what is looked at comes first. */
export function standInOrder() {
    const narrow = matchMedia(kColumn);
    const order = () => {
        const ids = narrow.matches ? ["stage", "graph", "live", "text", "details"] : ["live", "stage", "text", "graph", "details"];
        if (ids.some((id, i) => document.querySelector("main").children[i].id !== id)) document.querySelector("main").append(...ids.map(byId));
    };
    narrow.addEventListener("change", order);
    order();
}

export class Pane {
    /** The element `id` is shown by the button `${id}_button`; `opened` is done once it is there. */
    constructor(id, opened = () => {}) {
        Object.assign(this, { host: byId(id), button: byId(`${id}_button`), name: id, opened });
        this.button.addEventListener("click", () => this.show(!this.isOpen));
        this.mark();
    }

    get isOpen() { return !this.host.hidden; }

    mark() {
        this.button.setAttribute("aria-pressed", this.isOpen);
        document.body.classList.toggle(`with_${this.name}`, this.isOpen);
    }

    show(open) {
        if (open === this.isOpen) return;
        this.host.hidden = !open;
        this.mark();
        if (!open) return;
        // In a narrow window the page is one column, of which this may be anywhere.
        if (matchMedia(kColumn).matches) this.host.scrollIntoView({ block: "start" });
        this.opened();
    }
}
