// Undo and redo of one text that is both typed and edited by the graph, and of what stands beside it: where a hand has put
// its nodes. Nothing here touches the page.

const kTogetherMs = 800, kMost = 500, kMostCharacters = 16 << 20;

export class TextHistory {
    /** `beside` is any value, never changed but for another one. */
    constructor(text = "", beside = null) { this.reset(text, beside); }

    /** Forgets all but this. */
    reset(text, beside = this.beside) {
        this.now = text;
        this.beside = beside;
        this.past = [];
        this.future = [];
        this.open = -Infinity;  // when the last letter was typed of a step that more letters may join
    }

    get canUndo() { return this.past.length > 0; }
    get canRedo() { return this.future.length > 0; }
    get depth() { return this.past.length; }

    /** A new text; one that was typed, at a time in ms, is one step with what was typed shortly before. */
    record(text, typedAt = null) {
        if (text === this.now) return;
        const joins = typedAt !== null && typedAt - this.open < kTogetherMs && this.past.length > 0;
        if (!joins) this.past.push({ text: this.now, beside: this.beside });
        this.now = text;
        this.future = [];
        this.open = typedAt ?? -Infinity;
        let characters = this.past.reduce((sum, one) => sum + one.text.length, 0);
        while (this.past.length > kMost || (characters > kMostCharacters && this.past.length > 1)) characters -= this.past.shift().text.length;
    }

    /** What stands beside the text is another: a step of its own. */
    recordBeside(beside) {
        this.past.push({ text: this.now, beside: this.beside });
        if (this.past.length > kMost) this.past.shift();
        this.beside = beside;
        this.future = [];
        this.open = -Infinity;
    }

    /** Makes one step of all since there were `depth`. */
    joinSince(depth) { this.past.length = Math.min(this.past.length, depth + 1); }

    undo() { return this.step(this.past, this.future); }
    redo() { return this.step(this.future, this.past); }

    step(from, to) {
        if (from.length === 0) return null;
        to.push({ text: this.now, beside: this.beside });
        ({ text: this.now, beside: this.beside } = from.pop());
        this.open = -Infinity;
        return this.now;
    }
}

/** Where a change ends, for the caret: before what both texts end with. */
export function endOfChange(before, after) {
    let same = 0;
    while (same < Math.min(before.length, after.length) && before.at(-1 - same) === after.at(-1 - same)) ++same;
    return after.length - same;
}
