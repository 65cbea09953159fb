// Files: what is dropped on the page becomes part of the world, a template takes its place, and the whole print is
// written beside it.

import { postBytes, postJson, query } from "./api.js";
import { element } from "./format.js";

const byId = (id) => document.getElementById(id);
const kPartBytes = 3 << 20;

export class Files {
    /** `run` does something that asks the server, and shows what comes of it; `hasPicture` hears that one has come. */
    constructor(run, hasPicture) {
        Object.assign(this, { run, hasPicture });
        this.objects = [];
        this.listen();
    }

    /** What the world has: objects that a mesh can be given, and templates that may take its place. */
    show({ objects, templates }) {
        this.objects = objects.map((one) => one.name);
        byId("start").hidden = templates.length === 0;
        const select = byId("template");
        if (select.options.length !== templates.length + 1)
            select.replaceChildren(element("option", { value: "" }, "choose …"), ...templates.map((name) => element("option", {}, name)));
    }

    showState({ full_print: print, shows_full }) {
        const runs = print?.phase === "printing";
        byId("print").textContent = runs ? "Stop print" : "Print";
        byId("print").title = runs ? "End the print; the slices that are whole stay" : "Print the world at its printer's pitch, to a file beside it";
        byId("print_state").textContent = print ? this.wordsOf(print) : "";
        byId("print_state").classList.toggle("trouble", print?.phase === "failed");
        const done = print?.phase === "done";
        byId("printed").hidden = !done;
        if (done) {
            byId("printed_path").textContent = print.path;
            byId("show_print").textContent = shows_full ? "Show the draft" : "Show the print";
            byId("show_print").dataset.full = shows_full ? 0 : 1;
        }
        byId("print_bar").hidden = !runs;
        byId("print_bar").max = Math.max(print?.slices_total ?? 1, 1);
        byId("print_bar").value = print?.slices_done ?? 0;
        this.printing = runs;
    }

    wordsOf({ phase, file, slices_done, slices_total, seconds_left, message }) {
        if (phase === "done") return `${file} is printed at full pitch.\n${message}`.trim();
        if (phase === "stopped") return `${file}: stopped after ${slices_done} slices`;
        if (phase === "failed") return `${file}: ${message.trim() || "the print failed"}`;
        return slices_total ? `${file}: slice ${slices_done} of ${slices_total}, ${Math.ceil(seconds_left)} s left` : `${file}: begins …`;
    }

    say(text) {
        byId("files_note").textContent = text;
        byId("files_note").hidden = !text;
    }

    async upload(file) {
        let at = 0;
        do {
            this.say(`${file.name}: ${Math.round(100 * at / Math.max(file.size, 1))} % has come`);
            await postBytes("api/upload?" + query({ name: file.name, at }), file.slice(at, at + kPartBytes));
            at += kPartBytes;
        } while (at < file.size);
    }

    /** Takes files one after the other; the mesh goes to the object that is chosen. */
    async take(files) {
        this.say("");
        let used = null;
        await this.run(async () => {
            for (const file of files) {
                await this.upload(file);
                this.say(`${file.name} is read …`);
                used = await this.use(file.name);
                if (!used) return;
            }
        });
        if (byId("files_trouble").textContent) this.say("");
        return used;
    }

    /** Makes a file that has come part of the world, and says what of it; one that is not closed waits for its repair. */
    async use(file, repair = false) {
        try {
            const { name, mesh, notes } = await postJson("api/use", { name: file, object: this.chosenObject(), repair });
            this.say(`${mesh ? `${this.chosenObject()} is the mesh ${name} now.` : ""} ${notes.trim()}`.trim());
            return { mesh };
        } catch (error) {
            if (error.status !== 422 || !error.message.includes("press Repair")) throw error;
            this.say("");
            byId("files_trouble").replaceChildren(error.message, " ", element("button", { onclick: () => this.run(() => this.use(file, true)) }, "Repair"));
            return null;
        }
    }

    /** That of the focused uniform, else the first. */
    chosenObject() {
        const legend = document.activeElement?.closest?.("fieldset")?.querySelector("legend");
        return this.objects.find((name) => name === legend?.textContent) ?? this.objects[0] ?? "";
    }

    listen() {
        const carriesFiles = (event) => [...event.dataTransfer?.types ?? []].includes("Files");
        for (const kind of ["dragenter", "dragover"]) {
            addEventListener(kind, (event) => {
                if (byId("live").hidden || !carriesFiles(event)) return;
                event.preventDefault();
                document.body.classList.add("dropping");
            });
        }
        addEventListener("dragleave", (event) => { if (!event.relatedTarget) document.body.classList.remove("dropping"); });
        addEventListener("drop", (event) => {
            document.body.classList.remove("dropping");
            if (byId("live").hidden || !carriesFiles(event)) return;
            event.preventDefault();
            this.take([...event.dataTransfer.files]);
        });
        byId("files").addEventListener("change", async () => {
            const taken = this.take([...byId("files").files]);
            byId("files").value = "";
            const used = await taken;
            if (used && !used.mesh) this.hasPicture();
        });
        byId("add_file").addEventListener("click", () => byId("files").click());
        byId("print").addEventListener("click", () => this.run(() => postJson(this.printing ? "api/stop" : "api/print", {})));
        byId("show_print").addEventListener("click", (event) => this.run(() => postJson("api/show", { full: Number(event.target.dataset.full) })));
        byId("copy_path").addEventListener("click", () => navigator.clipboard.writeText(byId("printed_path").textContent).then(() => this.say("the path is copied"), () => getSelection().selectAllChildren(byId("printed_path"))));
        byId("template").addEventListener("change", (event) => {
            const name = event.target.value;
            event.target.value = "";
            if (name && confirm(`Begin again with the template ${name}? It takes the place of the fablet and the world.`))
                this.run(() => postJson("api/template", { name }));
        });
    }
}
