// What a hand that drags sends: the last value once the preview has shown the one before, so that it follows the hand.

const kPatienceMs = 600;

export class Paced {
    /** `send` gets the values by their keys, and returns the server's count of changes in whose preview they are seen. */
    constructor(send) {
        this.send = send;
        this.wanted = new Map();
        this.awaited = null;
    }

    has(key) { return this.wanted.has(key); }

    put(key, value) {
        this.wanted.set(key, value);
        if (this.awaited === null) this.go();
    }

    /** Forgets what is not sent. */
    drop() { this.wanted.clear(); }

    /** What the loop says. */
    showState(live) {
        if (this.awaited !== null && live.change >= this.awaited && !["checking", "printing"].includes(live.phase)) this.go();
    }

    async go() {
        clearTimeout(this.patience);
        this.awaited = null;
        if (!this.wanted.size) return;
        const values = new Map(this.wanted);
        this.wanted.clear();
        this.awaited = Infinity;
        // A print that takes longer gives way to the next value.
        this.patience = setTimeout(() => this.go(), kPatienceMs);
        this.awaited = (await this.send(values)) ?? Infinity;
    }
}
