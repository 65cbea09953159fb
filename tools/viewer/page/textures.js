// Small pictures of the world's textures. Each is asked for once, until the world changes.

import { getUrl, query } from "./api.js";

let known = new Map();  // by name and kind: a promise of a URL, or of an empty text where there is no picture

export function textureUrl(name, isVolume) {
    const key = query({ name, volume: isVolume ? 1 : 0 });
    if (!known.has(key)) known.set(key, getUrl(`api/texture?${key}`).catch(() => ""));
    return known.get(key);
}

export function forgetTextures() {
    const old = known;
    known = new Map();
    for (const one of old.values()) one.then((url) => url && URL.revokeObjectURL(url));
}
