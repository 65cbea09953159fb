// Copying nodes: their statements as text, which any other place for text takes as well.

export class GraphClips {
    /** `pane` is the graph's (graph.js). */
    constructor(pane) {
        this.pane = pane;
        this.held = "";
        const here = () => document.activeElement?.id === "graph_svg";
        document.addEventListener("copy", (event) => {
            if (!here() || !this.copy()) return;
            event.clipboardData.setData("text/plain", this.held);
            event.preventDefault();
        });
        document.addEventListener("cut", (event) => {
            if (!here() || !this.copy()) return;
            event.clipboardData.setData("text/plain", this.held);
            event.preventDefault();
            pane.remove();
        });
        document.addEventListener("paste", (event) => {
            if (!here()) return;
            event.preventDefault();
            this.paste(event.clipboardData.getData("text/plain") || this.held);
        });
    }

    /** The statements of the chosen nodes, as they are written. */
    text() {
        const { statements } = this.pane.graph.tabs[this.pane.tab];
        const numbers = new Set(this.pane.chosen.map((id) => this.pane.nodes[id]).filter((node) => node.kind !== "input" && node.kind !== "result").map((node) => node.statement));
        return [...numbers].filter((n) => n >= 0).sort((a, b) => a - b).map((n) => this.pane.drawn.slice(statements[n].begin, statements[n].end)).join("\n");
    }

    copy() {
        if (!this.pane.graph) return false;
        const text = this.text();
        if (!text) return this.pane.say("choose nodes to copy: inputs and the result are in each stage already"), false;
        this.held = text;
        this.pane.say(`copied: ${text.split("\n").length === 1 ? text : `${text.split("\n").length} lines`}`, false);
        return true;
    }

    paste(text = this.held) {
        if (!text) return this.pane.say("nothing is copied yet");
        return this.pane.act({ do: "paste", text }, this.place());
    }

    duplicate() {
        const text = this.text();
        if (text) this.pane.act({ do: "paste", text }, this.place());
    }

    /** Somewhat below what is chosen. */
    place() {
        const at = this.pane.drawing.placed.at[this.pane.chosen[0]];
        return at ? { x: at.x + 110, y: at.y + 120 } : null;
    }
}
