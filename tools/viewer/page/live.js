// The live loop on a world: its uniforms, its fablets, and what is wrong with the world itself.

import { getJson } from "./api.js";
import { Editor } from "./editor.js";
import { Files } from "./files.js";
import { GraphPane } from "./graph.js";
import { PartPanel } from "./part.js";
import { forgetTextures } from "./textures.js";
import { Uniforms } from "./uniforms.js";

const byId = (id) => document.getElementById(id);

export class LivePanel {
    /** `refresh` asks for the state again; `tell` makes of a place for words one for errors; colours are red, green, blue. */
    constructor({ refresh, tell, colorOfMaterial }) {
        this.version = -1;
        this.fail = tell((text) => this.showMessage(text, true));
        // Does something that asks the server, and shows at `id` what is wrong with it.
        const run = (id) => async (action) => {
            byId(id).textContent = "";
            try {
                await action();
                refresh();
            } catch (error) {
                tell((text) => { byId(id).textContent = text; })(error);
            }
        };
        this.uniforms = new Uniforms(run("uniforms_trouble"));
        this.files = new Files(run("files_trouble"), () => {
            this.part.expectPicture();
            if (this.details) this.part.show(this.details);
        });
        this.editor = new Editor(run("editor_trouble"));
        this.part = new PartPanel(run("part_trouble"), this.editor);
        this.graph = new GraphPane(this.editor, tell((text) => this.graph.say(text)),
            { colorOf: (uniform) => colorOfMaterial(this.boundTo(uniform)), boundTo: (uniform) => this.boundTo(uniform) });
    }

    /** The material or texture that the first object with a uniform of this name has there. */
    boundTo(uniform) {
        const value = this.details?.objects.flatMap((object) => object.uniforms).find((one) => one.name === uniform)?.value;
        const first = Array.isArray(value) ? value[0] : value;
        return typeof first === "string" ? first : undefined;
    }

    showMessage(text, isError) {
        byId("world_message").textContent = text;
        byId("world_message").hidden = !text;
        byId("world_message").classList.toggle("error", isError);
    }

    async showState(live) {
        if (!live?.watch) return;
        this.uniforms.showState(live);
        this.graph.showState(live);
        this.files.showState(live);
        if (live.version === this.version) return;
        this.version = live.version;
        try {
            const details = await getJson("api/live");
            this.details = details;
            forgetTextures();
            this.uniforms.show(details);
            this.files.show(details);
            this.part.show(details);
            this.showMessage(details.message.trimEnd(), live.phase === "failed");
            await this.editor.show(details);
        } catch (error) {
            this.version = -1;
            this.fail(error);
        }
    }
}
