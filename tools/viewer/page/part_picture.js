// A picture on a side of the part: what the panel "Part" asks for becomes a node of the fablet, with uniforms for its
// picture and its ink that the world binds.

import { postJson } from "./api.js";

export const kSides = [["4", "the top"], ["0", "the front"], ["1", "the right"], ["2", "the back"], ["3", "the left"], ["5", "the bottom"]];
const kName = "mix_picture_on", kModule = "mix";

const text = (v) => String(Number(v.toPrecision(6)));

/** The call with all that a user chose, in place of one that the compiler has made with what there was. */
export function callOf(made, { body, ink, picture, side, size, middle, depth }) {
    const place = made.slice(made.lastIndexOf(",") + 1, -1).trim();  // what the compiler found for the point
    return `${kName}(${body}, ${ink}, ${picture}, ${place}, ${side}, float2(${size.map(text).join(", ")}), float3(${middle.map(text).join(", ")}), ${text(depth)})`;
}

/** Puts a texture on; `uniforms` are those of the object, {name, kind, value}. Returns the text and what the world must bind. */
export async function withPicture({ fablet, text: before, fabletName, uniforms, texture, material, ...how }) {
    let now = before;
    let graph = await postJson("api/graph", { fablet, text: now });
    const act = async (action) => ({ text: now, graph } = await postJson("api/edit", { fablet, text: now, action }));
    const index = [...new Set(graph.tabs.map((tab) => tab.fablet).filter(Boolean))].indexOf(fabletName);
    const bound = {};
    const uniform = async (type, name, value) => {
        const known = new Set(graph.uniforms.filter((one) => one.fablet === fabletName).map((one) => one.name));
        await act({ do: "add_uniform", fablet: index, type, text: name });
        const made = graph.uniforms.find((one) => one.fablet === fabletName && !known.has(one.name)).name;
        bound[made] = value;
        return made;
    };
    const picture = await uniform("ImageTexture2D", "picture", texture);
    const ink = uniforms.find((one) => one.kind === "material" && one.value?.[0] === material)?.name ?? await uniform("Material", "ink", material);
    const tab = graph.tabs.findIndex((one) => one.name === "@Volume" && one.fablet === fabletName);
    const resultOf = () => graph.tabs[tab].nodes.findLast((node) => node.kind === "result");
    const body = resultOf().ports[0].text;
    const entry = (await postJson("api/palette", { fablet, text: now })).find((one) => one.name === kName && one.module === kModule);
    await act({ do: "insert", tab, node: resultOf().id, port: 0, signature: entry.signature, module: kModule });
    await act({ do: "set", tab, node: resultOf().id, port: 0, text: callOf(resultOf().ports[0].text, { body, ink, picture, ...how }) });
    return { text: now, bound };
}
