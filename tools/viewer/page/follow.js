// Follows the server's state, quickly while something happens; tells in the head of the page what happens, and when the
// server is gone.

import { getJson } from "./api.js";

const byId = (id) => document.getElementById(id);
const kBusyMs = 200, kGrowingMs = 500, kQuietMs = 2000;

export class Follower {
    /** `show` gets each state; `refused` the error of a server that does not let this page in. */
    constructor(show, refused) {
        this.show = show;
        this.refused = refused;
        this.timer = 0;
    }

    async refresh() {
        clearTimeout(this.timer);
        let again = kQuietMs;
        try {
            const state = await getJson("api/state");
            byId("connection").hidden = true;
            this.showProgress(state);
            this.show(state);
            const busy = state.live && ["checking", "printing"].includes(state.live.phase);
            const growing = state.prints.some((p) => !p.complete);
            if (busy) again = kBusyMs;
            else if (growing || state.live?.watch) again = kGrowingMs;
        } catch (error) {
            if (error.status === 0) this.lost();
            else this.refused(error);
        }
        // Not while nobody looks.
        this.timer = setTimeout(() => (document.hidden ? document.addEventListener("visibilitychange", () => this.refresh(), { once: true }) : this.refresh()), again);
    }

    lost() { byId("connection").hidden = false; }

    showProgress({ live, prints }) {
        const print = prints[0];
        const text = byId("progress");
        let words = "";
        if (live && live.phase !== "done") {
            words = { checking: "compiling …", printing: "printing", failed: "failed" }[live.phase] ?? "";
            if (live.phase === "printing" && live.slices_total) words += ` ${Math.floor(100 * live.slices_done / live.slices_total)} %`;
        } else if (print && !print.complete) {
            words = `${print.whole} of ${print.slice_end - print.slice_begin} slices`;
        }
        text.textContent = words;
        text.hidden = !words;
        text.classList.toggle("failed", live?.phase === "failed");
    }
}
