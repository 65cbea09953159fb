// Follows the server's state: of a world the server answers once there is another, of prints it is asked now and then.
// Tells in the head of the page what happens, and when the server is gone.

import { getJson, query } from "./api.js";

const byId = (id) => document.getElementById(id);
const kSoonMs = 30, kGrowingMs = 500, kQuietMs = 2000;

export class Follower {
    /** `show` gets each state; `refused` the error of a server that does not let this page in. */
    constructor(show, refused) {
        this.show = show;
        this.refused = refused;
        this.timer = 0;
        this.known = -1;       // what the server calls the state that was shown last
        this.waiting = false;  // until there is another
    }

    async refresh() {
        if (this.waiting) return;
        clearTimeout(this.timer);
        let again = kQuietMs;
        try {
            const { known } = this;
            this.waiting = known >= 0;
            const state = await getJson("api/state?" + query(known >= 0 ? { known } : {}));
            this.waiting = false;
            this.known = state.live?.watch ? state.live.change : -1;
            byId("connection").hidden = true;
            this.showProgress(state);
            this.show(state);
            // Where nothing is new, the server has many that wait, or a print of its own.
            if (this.known !== known) again = kSoonMs;
            else if (this.known >= 0 || state.prints.some((p) => !p.complete)) again = kGrowingMs;
        } catch (error) {
            this.waiting = false;
            this.known = -1;
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
