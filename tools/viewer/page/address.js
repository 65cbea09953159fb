// The address holds what is shown, behind the token: a reload, a bookmark or a second window comes back to it.

const kSettleMs = 150;

/** The values behind the token, by name. */
export function readAddress() {
    const rest = location.hash.slice(1).split("&").slice(1);
    return Object.fromEntries(rest.map((one) => {
        const equals = one.indexOf("=");
        try {
            return [one.slice(0, equals), decodeURIComponent(one.slice(equals + 1))];
        } catch {
            return ["", ""];  // typed by hand
        }
    }));
}

/** Numbers separated by commas, or null where it is anything else. */
export function numbersIn(text, many) {
    const numbers = (text ?? "").split(",").map(Number);
    return text && numbers.length === many && numbers.every(Number.isFinite) ? numbers : null;
}

export class Address {
    /** `read` returns the values to keep, undefined where one is as it would be anyway; `apply` takes those of an address. */
    constructor(read, apply) {
        this.read = read;
        this.token = location.hash.slice(1).split("&")[0];
        addEventListener("hashchange", () => {
            if (location.hash.slice(1).split("&")[0] !== this.token) location.reload();
            else apply(readAddress());
        });
    }

    /** Something is shown in another way: the address follows once that settles. */
    changed() {
        clearTimeout(this.settling);
        this.settling = setTimeout(() => {
            const values = Object.entries(this.read()).filter(([, value]) => value !== undefined && value !== "");
            const text = values.map(([name, value]) => `&${name}=${encodeURIComponent(value).replaceAll("%2C", ",").replaceAll("%3A", ":")}`).join("");
            // No entry of its own in the history: Back leaves the page.
            history.replaceState(null, "", `#${this.token}${text}`);
        }, kSettleMs);
    }
}
