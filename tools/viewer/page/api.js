// Requests to the server that this page comes from. The token that it wants is the page's fragment, which browsers
// do not send.

const token = location.hash.slice(1);

export class ApiError extends Error {
    constructor(status, message) {
        super(message);
        this.status = status;
    }
}

async function request(path, options = {}) {
    const response = await fetch(path, { ...options, headers: { "X-OpenFab-Token": token, ...options.headers } });
    if (response.ok) return response;
    let message = `the server answers ${response.status}`;
    try {
        message = (await response.json()).error;
    } catch { /* not one of our own answers */ }
    throw new ApiError(response.status, message);
}

export function query(values) {
    return new URLSearchParams(values).toString();
}

export async function getJson(path, signal) {
    return (await request(path, { signal })).json();
}

/** A picture, ready to be drawn. */
export async function getPicture(path) {
    return createImageBitmap(await (await request(path)).blob());
}

/** The bytes, or null where the server has nothing new. */
export async function getBytes(path) {
    const response = await request(path);
    return response.status === 204 ? null : { bytes: new Uint8Array(await response.arrayBuffer()), step: Number(response.headers.get("X-OpenFab-Step")) };
}

export async function postJson(path, value) {
    const response = await request(path, { method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(value) });
    return response.json();
}
