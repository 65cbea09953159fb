// A number of the graph under a hand that drags it: the preview follows. The server prints the text as it would be with a
// uniform in the number's place, so that one kernel does for all of its values; the text itself changes when it is let go.

import { Paced } from "./paced.js";

export class GraphDrag {
    /** `ask` sends a request about the text that is drawn, `place` holds what `begin` is about. */
    constructor(ask) {
        this.ask = ask;
        this.paced = new Paced((values) => this.send(values.get("value")));
        this.place = null;
    }

    showState(live) { this.paced.showState(live); }

    /** `action` makes a uniform of the number; `known` are the names of those of `fablet` there are. */
    begin({ action, fablet, known }) {
        this.place = { action, fablet, known: new Set(known), made: null };
    }

    put(value) {
        if (this.place && Number.isFinite(value)) this.paced.put("value", value);
    }

    /** Let go; the preview stays where the text takes the value, as `done` says once it is known. */
    async end(done) {
        const shown = this.place?.made;
        this.place = null;
        this.paced.drop();
        if (shown && !(await done)) await this.ask("api/untry", {}).catch(() => {});
    }

    async send(value) {
        const { place } = this;
        if (!place) return undefined;
        try {
            if (!place.made) {
                const { text, graph } = await this.ask("api/edit", { action: place.action });
                const name = graph.uniforms.find((one) => one.fablet === place.fablet && !place.known.has(one.name))?.name;
                if (!name || place !== this.place) return undefined;
                place.made = { text, uniform: name };
            }
            return (await this.ask("api/try", { ...place.made, name: place.fablet, value })).change;
        } catch {
            this.place = null;  // what is wrong is told when it is let go
            return undefined;
        }
    }
}
