// The world's uniforms: a row each, with what is wrong with its value, and what is done with all of them.

import { postJson } from "./api.js";
import { controlOf } from "./controls.js";
import { element } from "./format.js";
import { Paced } from "./paced.js";

const byId = (id) => document.getElementById(id);

export class Uniforms {
    /** `run` does something that asks the server, and shows what comes of it. */
    constructor(run) {
        this.run = run;
        this.rows = [];  // {object, name, row, control, trouble}
        this.shape = "";
        this.paced = new Paced(async (values) => {
            let change;
            await run(async () => { for (const one of values.values()) change = await this.send(one) ?? change; });
            return change;
        });
        byId("draft").addEventListener("change", (event) => run(() => postJson("api/draft", { draft: Number(event.target.value) })));
        byId("write").addEventListener("click", () => run(() => postJson("api/write", {})));
        byId("revert").addEventListener("click", () => run(() => postJson("api/revert", {})));
    }

    showState(live) {
        this.paced.showState(live);
        byId("write").disabled = !live.writable;
        byId("write").title = live.phase === "failed" ? "The print with these values failed" : "Write the changed uniforms to the world's file";
    }

    show(details) {
        byId("revert").disabled = details.changed === 0;
        this.showDraft(details.draft);
        const shape = JSON.stringify([details.objects.map((o) => [o.name, o.uniforms.map((u) => [u.name, u.type, u.annotations])]), details.materials, details.textures]);
        if (shape !== this.shape) this.build(details);
        this.shape = shape;
        for (const { object, name, row, control, trouble } of this.rows) {
            const uniform = details.objects.find((o) => o.name === object).uniforms.find((u) => u.name === name);
            row.classList.toggle("changed", uniform.changed);
            row.classList.toggle("wrong", Boolean(uniform.trouble));
            trouble.textContent = uniform.trouble ?? "";
            // Not under a hand that holds a slider, nor what is on its way to the server.
            if (!row.contains(document.activeElement) && !this.paced.has(`${object}\0${name}`)) control.show(uniform.value ?? uniform.default);
        }
    }

    showDraft(draft) {
        const select = byId("draft");
        const choices = [...new Set([0, 1, 2, 3, 4, 6, 8, 12, 16, draft])].sort((a, b) => a - b);
        select.replaceChildren(...choices.map((n) => element("option", { value: n, selected: n === draft }, n ? `${n} ×` : "auto")));
    }

    build(details) {
        this.rows = [];
        byId("uniforms").replaceChildren(...details.objects.map((object) => element("fieldset", {},
            element("legend", {}, object.name),
            ...object.uniforms.filter((u) => u.kind !== "object").map((u) => this.row(object.name, u, details)))));
    }

    row(object, uniform, { materials, textures }) {
        const label = uniform.annotations.label ?? uniform.name;
        const first = uniform.value ?? uniform.default;
        const control = controlOf({ uniform, label, first, names: { materials, textures }, set: (value) => this.paced.put(`${object}\0${uniform.name}`, { object, uniform: uniform.name, value }) });
        const trouble = element("p", { class: "trouble", role: "alert" });
        control.show(first);
        const row = element("div", { class: "uniform" },
            element("span", { class: "name", title: [`${uniform.type} ${uniform.name}`, uniform.annotations.help].filter(Boolean).join(": ") }, label),
            ...control.elements, trouble);
        this.rows.push({ object, name: uniform.name, row, control, trouble });
        return row;
    }

    async send(one) {
        try {
            return (await postJson("api/set", one)).change;
        } catch (error) {
            if (error.status !== 422) throw error;
            const { row, trouble } = this.rows.find((r) => r.object === one.object && r.name === one.uniform);
            row.classList.add("wrong");
            trouble.textContent = error.message;
        }
    }
}
