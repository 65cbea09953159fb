// Numbers and elements for people.

export const axisNames = ["x", "y", "z"];

export function millimetres(mm) {
    return `${mm.toFixed(3)} mm`;
}

/** 1-2-5 lengths for a scale bar: the largest of at most `most` mm. */
export function roundLength(most) {
    const power = 10 ** Math.floor(Math.log10(most));
    const digit = most / power;
    return (digit >= 5 ? 5 : digit >= 2 ? 2 : 1) * power;
}

export function lengthText(mm) {
    return mm < 0.9995 ? `${Number((mm * 1000).toPrecision(3))} µm` : `${Number(mm.toPrecision(4))} mm`;
}

export function count(n) {
    if (n >= 1e9) return `${(n / 1e9).toFixed(2)} G`;
    if (n >= 1e6) return `${(n / 1e6).toFixed(2)} M`;
    return n.toLocaleString("en").replaceAll(",", "\u2009");
}

export function volume(ml) {
    return ml >= 0.1 ? `${ml.toFixed(2)} ml` : `${(ml * 1000).toFixed(2)} µl`;
}

export function share(part, whole) {
    return whole > 0 ? `${(100 * part / whole).toFixed(1)} %` : "–";
}

/** An element; strings among `children` become text, never markup. */
export function element(name, attributes = {}, ...children) {
    const made = document.createElement(name);
    for (const [key, value] of Object.entries(attributes)) {
        if (key.startsWith("on")) made.addEventListener(key.slice(2), value);
        else if (value === true) made.setAttribute(key, "");
        else if (value !== false && value != null) made.setAttribute(key, value);
    }
    made.append(...children);
    return made;
}

export function describe(list, rows) {
    list.replaceChildren();
    for (const [name, value, wide] of rows) {
        list.append(element("dt", wide ? { class: "wide" } : {}, name));
        list.append(element("dd", wide ? { class: "wide" } : {}, ...(Array.isArray(value) ? value : [String(value)])));
    }
}
