// What the compiler knows while one types: names that fit, what a name is, what a call takes.

import { element } from "./format.js";
import { fromSnippet } from "./source_keys.js";
import { wordBefore } from "./source_words.js";

const byId = (id) => document.getElementById(id);
const kSoonMs = 90, kRestMs = 350, kMost = 60;
const kOutdated = {};  // the answer to a question about a text that was typed on

/** Those that fit what is typed: first what begins with it, in the server's order. */
export function fitting(items, word) {
    const small = word.toLowerCase();
    return items.map((item) => {
        const label = item.label.replace(/^@/, "").toLowerCase();
        return { item, rate: label.startsWith(small) ? 0 : label.includes(small) ? 1 : 2 };
    }).filter((one) => one.rate < 2)
        .sort((a, b) => a.rate - b.rate || (a.item.sortText ?? a.item.label).localeCompare(b.item.sortText ?? b.item.label))
        .map((one) => one.item);
}

/** Markdown of the server as plain text. */
export function plain(markdown) {
    return (markdown ?? "").replace(/```\w*\n?/g, "").replace(/\*\*|`/g, "").trim();
}

export class SourceAssist {
    /** `ask` sends a question about the text, `view` knows where letters stand, `put` replaces a part of the text. */
    constructor({ ask, view, put, diagnosticsAt }) {
        Object.assign(this, { ask, view, put, diagnosticsAt });
        this.source = byId("source");
        this.list = byId("completions");
        this.note = byId("source_note");
        this.items = [];
        this.listen();
    }

    get isOpen() { return !this.list.hidden; }

    hide() {
        clearTimeout(this.timer);
        this.asked = null;
        this.list.hidden = this.note.hidden = true;
        this.source.removeAttribute("aria-activedescendant");
    }

    place() { return this.view.placeOf(this.source.selectionStart); }

    word() {
        const { line, character } = this.place();
        return wordBefore(this.view.lines[line] ?? "", character);
    }

    /** After a letter was typed. */
    typed(letter) {
        if (letter === "(" || letter === ",") return this.soon(() => this.showSignature());
        if (letter === ")" || letter === ";") return this.hide();
        const word = this.word();
        if (letter === "." || letter === "@" || word.length >= (this.isOpen ? 1 : 2)) return this.soon(() => this.complete());
        if (this.isOpen || !letter) this.hide();
    }

    soon(does) {
        clearTimeout(this.timer);
        this.timer = setTimeout(does, kSoonMs);
    }

    async question(kind, place) {
        const text = this.source.value;
        const asked = this.asked = {};
        try {
            const answer = await this.ask({ ask: kind, ...place });
            if (asked !== this.asked) return null;
            return text === this.source.value ? answer : kOutdated;
        } catch {
            return null;  // help that does not come must not be in the way
        }
    }

    async complete(wanted = false) {
        const items = await this.question("complete", this.place());
        if (!items || items === kOutdated) return;
        this.items = fitting(items, this.word()).slice(0, kMost);
        // Nothing to say where all that fits is what stands there.
        if (this.items.length === 0 || (!wanted && this.items.every((one) => one.label === this.word()))) return this.hide();
        this.chosen = 0;
        this.note.hidden = true;
        this.list.replaceChildren(...this.items.map((item, i) => element("li", {
            role: "option", id: `completion${i}`, title: plain(item.documentation?.value), onpointerdown: (event) => { event.preventDefault(); this.take(i); },
        }, element("b", {}, item.label), element("span", { class: "type" }, item.detail ?? ""))));
        const { line, character } = this.place();
        this.stand(this.list, { line, character: character - this.word().length });
        this.choose(0);
    }

    choose(i) {
        this.chosen = (i + this.items.length) % this.items.length;
        [...this.list.children].forEach((one, at) => one.setAttribute("aria-selected", at === this.chosen));
        this.list.children[this.chosen].scrollIntoView({ block: "nearest" });
        this.source.setAttribute("aria-activedescendant", `completion${this.chosen}`);
    }

    take(i) {
        const item = this.items[i];
        const at = this.source.selectionStart;
        const begin = at - this.word().length;
        const marker = item.label.startsWith("@") && this.source.value[begin - 1] === "@";
        const { line } = this.place();
        const indentation = /^\s*/.exec(this.view.lines[line])[0];
        this.hide();
        this.put(begin - (marker ? 1 : 0), at, item.insertText ? fromSnippet(item.insertText, indentation) : { text: item.label, begin: item.label.length, end: item.label.length });
    }

    async showSignature() {
        const place = this.place();
        const answer = await this.question("signature", place);
        if (answer === kOutdated) return this.soon(() => this.showSignature());
        const signature = answer?.signatures?.[answer.activeSignature];
        if (!signature) return this.hide();
        const now = signature.parameters?.[answer.activeParameter]?.label;
        const at = now === undefined ? -1 : signature.label.indexOf(now, signature.label.indexOf("("));
        const parts = at < 0 ? [signature.label] : [signature.label.slice(0, at), element("b", {}, now), signature.label.slice(at + now.length)];
        this.say(place, element("code", {}, ...parts), plain(signature.documentation?.value));
    }

    /** What stands at a place: what is wrong there, and what the name is. */
    async showHelp(place) {
        const wrong = this.diagnosticsAt(place);
        const answer = await this.question("hover", place);
        if (answer === kOutdated) return;
        if (answer === null && wrong.length === 0) return this.hide();
        const [code, ...rest] = plain(answer?.contents?.value).split("\n");
        this.say(place, ...wrong.map((d) => element("p", { class: `trouble ${d.severity}` }, d.message)), ...(code ? [element("code", {}, code)] : []), rest.join("\n").trim());
    }

    say(place, ...parts) {
        const full = parts.filter(Boolean).map((part) => (typeof part === "string" ? element("p", {}, part) : part));
        if (full.length === 0) return this.hide();
        this.list.hidden = true;
        this.note.replaceChildren(...full);
        this.stand(this.note, place);
    }

    /** Below a letter, or above it where there is no room. */
    stand(box, place) {
        box.hidden = false;
        const { left, top, bottom } = this.view.boxOf(place);
        const { width, height } = box.getBoundingClientRect();
        box.style.left = `${Math.max(4, Math.min(left, innerWidth - width - 8))}px`;
        box.style.top = `${bottom + height > innerHeight - 4 ? Math.max(4, top - height - 2) : bottom + 2}px`;
    }

    /** Whether the key was one for the list. */
    key(event) {
        if (event.key === " " && event.ctrlKey) this.complete(true);
        else if (event.key === "F1") this.showHelp(this.place());
        else if (event.key === "Escape" && (this.isOpen || !this.note.hidden)) this.hide();
        else if (this.isOpen && event.key === "ArrowDown") this.choose(this.chosen + 1);
        else if (this.isOpen && event.key === "ArrowUp") this.choose(this.chosen - 1);
        else if (this.isOpen && !event.shiftKey && (event.key === "Tab" || event.key === "Enter") && this.items[this.chosen].label !== this.word()) this.take(this.chosen);
        else return false;
        return true;
    }

    listen() {
        const source = this.source;
        source.addEventListener("blur", () => this.hide());
        source.addEventListener("pointerdown", () => this.hide());
        byId("editor").addEventListener("scroll", () => this.hide());
        source.addEventListener("pointerleave", () => { clearTimeout(this.resting); });
        source.addEventListener("pointermove", (event) => {
            clearTimeout(this.resting);
            if (this.isOpen || event.buttons || event.pointerType === "touch") return;
            this.resting = setTimeout(() => {
                const place = this.view.placeAt(event.clientX, event.clientY);
                if (place && !this.isOpen) this.showHelp(place);
                else if (!this.isOpen) this.note.hidden = true;
            }, kRestMs);
        });
    }
}
