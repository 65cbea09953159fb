// Requests to the server that this page comes from. The token that it wants begins the page's fragment, which browsers
// do not send.

import { inPageWords } from "./page_words.js";

// Tests of modules that need no page have none.
const token = globalThis.location?.hash.slice(1).split("&")[0] ?? "";

/** `status` is that of the answer, 0 where there was none. */
export class ApiError extends Error {
    constructor(status, message) {
        super(message);
        this.status = status;
    }
}

/** What an answer says, in the page's words. */
async function jsonOf(response) {
    const text = await response.text();
    return /--[a-z]|openf|scripts\//.test(text) ? JSON.parse(text, inPageWords) : JSON.parse(text);
}

async function request(path, options = {}) {
    let response;
    try {
        response = await fetch(path, { ...options, headers: { "X-OpenFab-Token": token, ...options.headers } });
    } catch {
        throw new ApiError(0, "the server does not answer");
    }
    if (response.ok) return response;
    let message = `the server answers ${response.status}`;
    try {
        message = (await jsonOf(response)).error;
    } catch { /* not one of our own answers */ }
    throw new ApiError(response.status, message);
}

export function query(values) {
    return new URLSearchParams(values).toString();
}

export async function getJson(path, signal) {
    return jsonOf(await request(path, { signal }));
}

/** A picture, ready to be drawn. */
export async function getPicture(path) {
    return createImageBitmap(await (await request(path)).blob());
}

/** A picture as the URL of a blob, which the caller revokes. */
export async function getUrl(path) {
    return URL.createObjectURL(await (await request(path)).blob());
}

/** The bytes, or null where the server has nothing new. */
export async function getBytes(path) {
    const response = await request(path);
    return response.status === 204 ? null : { bytes: new Uint8Array(await response.arrayBuffer()), step: Number(response.headers.get("X-OpenFab-Step")) };
}

export async function postBytes(path, bytes) {
    const response = await request(path, { method: "POST", headers: { "Content-Type": "application/octet-stream" }, body: bytes });
    return jsonOf(response);
}

export async function postJson(path, value) {
    const response = await request(path, { method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(value) });
    return jsonOf(response);
}
