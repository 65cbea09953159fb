// Changes of a world as the panel "Part" makes them. Nothing here touches the page.

/** Materials to add: a name, how it looks, and its key colour in slices. */
export const kStock = [
    ["white", "#f4f2ec", "#ffffff"], ["black", "#161616", "#000000"], ["clear", "#e8eef020", "#c8d8e0"], ["cyan", "#0098dc", "#00a0e0"], ["magenta", "#d0207c", "#e0007a"],
    ["yellow", "#f2d40c", "#ffe000"], ["red", "#c8281e", "#e01010"], ["green", "#2c9a40", "#10a030"], ["blue", "#2850b4", "#1040c0"], ["orange", "#ee7c12", "#ff8000"], ["grey", "#8c8c8a", "#808080"],
];

export const editsOf = (path, value) => [value === undefined ? { path } : { path, value }];

/** The scale with which a side of `now` mm becomes `wanted`. */
export function scaleFor(scale, now, wanted) {
    const by = wanted / now;
    const times = (v) => Number((v * by).toPrecision(9));
    return Array.isArray(scale) ? scale.map(times) : times(scale ?? 1);
}

/** A material under a name and with a key that the world has not. */
export function materialFor(materials, name) {
    const [, preview, wanted] = kStock.find(([one]) => one === name);
    let free = name;
    for (let n = 2; free in materials; ++n) free = `${name}_${n}`;
    const keys = new Set(Object.values(materials).map((one) => one.key.toLowerCase()));
    let key = wanted;
    while (keys.has(key)) key = `#${((parseInt(key.slice(1), 16) + 0x040810) & 0xffffff).toString(16).padStart(6, "0")}`;
    return { name: free, value: { key, preview } };
}

/** The uniforms of objects that have a material, as people say them. */
export function usesOf({ objects }, material) {
    return Object.entries(objects ?? {}).flatMap(([object, { uniforms }]) => Object.entries(uniforms ?? {})
        .filter(([, value]) => value === material || (Array.isArray(value) && value.includes(material))).map(([name]) => `${name} of ${object}`));
}

/** Edits that give each of two materials the other's places. */
export function swapped({ objects }, a, b) {
    const other = (value) => (value === a ? b : value === b ? a : value);
    return Object.entries(objects ?? {}).flatMap(([object, { uniforms }]) => Object.entries(uniforms ?? {}).flatMap(([name, value]) => {
        const made = Array.isArray(value) ? value.map(other) : other(value);
        return JSON.stringify(made) === JSON.stringify(value) ? [] : [{ path: ["objects", object, "uniforms", name], value: made }];
    }));
}
