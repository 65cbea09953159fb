// What the list of nodes says in plain words: categories, a line for each of the functions that most look for, and other
// words by which they are found. What is not named here is said by its own help. Nothing here touches the page.

/** By name; modules are the library's, `holds` finds others. `shows` is what its picture is of. */
export const kCategories = [
    { name: "Materials", about: "two or more in one part", shows: "color_ramp", modules: ["mix", "property"], holds: (e) => e.result === "MaterialComposition" },
    { name: "Patterns", about: "stripes, checks, dots", shows: "checks", modules: ["pattern", "halftone"] },
    { name: "Lattices", about: "gyroids, struts, foams", shows: "gyroid", modules: ["lattice", "struts", "foam", "voronoi", "conformal"] },
    { name: "Depth and height", about: "skins, layers, gradients", shows: "grade_depth", modules: ["shell", "grade"], holds: (e) => /^distance/.test(e.name) || e.name === "nearest" },
    { name: "Colours", about: "ramps, inks, colour spaces", shows: "color_rainbow", modules: ["color"] },
    { name: "Pictures", about: "photos and logos on the part", shows: "map_weights", modules: ["mapping"], holds: (e) => /^Sample/.test(e.name) },
    { name: "Noise and nature", about: "wood, marble, clouds", shows: "marble", modules: ["wood", "marble"], holds: (e) => /noise|simplex|cellular|fbm|turbulence|curl|^hash/.test(e.name) },
    { name: "Shapes", about: "balls, boxes, pipes", shows: "solid_torus", modules: ["solids", "sweeps"] },
    { name: "Move and bend", about: "turn, repeat, twist", shows: "deform_twist_stretch", modules: ["deform"] },
    { name: "Fields", about: "flows, heat, harmonics", shows: "curl", modules: ["harmonic", "streams"] },
    { name: "Optics", about: "lenses and their arrays", shows: "lens_array_hex", modules: ["lens"] },
    { name: "Dither", about: "which voxel gets which", shows: "halftone_dots", modules: ["dither"] },
    { name: "This fablet", about: "functions of your own", holds: (e) => e.kind === "own" },
    { name: "Mathematics", about: "+, sin, clamp", shows: "sin", holds: () => true },
];

/** Plain words and synonyms, by the name of a function. */
const kWords = {
    mix_pattern: ["two materials, changing by a pattern of 0 to 1", "blend two colours checker stripes alternate"],
    mix_depth: ["two materials, changing with depth under the skin", "graded gradient skin core soft inside fade"],
    mix_height: ["two materials, changing from bottom to top", "graded gradient height ombre z fade layers"],
    mix_picture_on: ["a picture on one side of the part", "photo logo image label print texture decal top"],
    mix_picture: ["two materials, by how dark a picture is", "photo logo image label print texture"],
    mix_field: ["two materials, by any field between two values", "graded gradient range remap lerp"],
    checks: ["a checkerboard of squares or cubes", "checker chess tiles squares"],
    stripes: ["stripes with hard edges", "lines bands zebra"],
    stripes_soft: ["stripes with soft edges", "lines bands zebra"],
    dots: ["round dots, or balls, in rows", "hole holes points polka perforation"],
    bricks: ["a wall of bricks", "tiles masonry"],
    grid_lines: ["a ruled grid of lines", "mesh net squares"],
    rings: ["rings around the middle", "target circles bullseye"],
    glyph: ["a letter", "text font logo type"],
    cells: ["random squares or cubes", "mosaic pixels"],
    voronoi_cell: ["random cells, as of a giraffe", "stained glass giraffe"],
    voronoi_edge: ["the borders between random cells", "cracks giraffe stained glass"],
    gyroid: ["a gyroid: a smooth endless lattice", "tpms infill minimal surface"],
    gyroid_walls: ["walls of a gyroid", "tpms infill"],
    diamond: ["a diamond lattice", "tpms infill"],
    schwarz_p: ["a lattice of tubes that cross", "tpms infill primitive"],
    honeycomb: ["honeycomb walls", "hexagon hive infill"],
    strut_octet: ["an octet truss", "truss infill"],
    grade_depth: ["from 0 to 1 with depth under the skin", "graded gradient fade soft inside"],
    grade_line: ["from 0 to 1 along a line", "graded gradient ombre fade height"],
    grade_radial: ["from 0 to 1 away from a point", "graded gradient radial fade"],
    shell: ["1 in a skin of the part, else 0", "skin coat hollow outside"],
    shell_of: ["a skin of one material over a core of another", "coat outside inside"],
    shell_hollow: ["a hollow part with walls", "hole empty inside shell"],
    shell_between: ["a layer at a depth under the skin", "layer skin"],
    shell_onion: ["layers like those of an onion", "layers skin"],
    distance: ["how far it is to the surface, negative inside", "depth skin sdf"],
    distance_to: ["how far it is to another object", "near sdf"],
    walk_end: ["where a random walk meets the surface", "harmonic diffusion"],
    map_planar: ["where a picture goes that is laid on flat", "photo logo image projection decal"],
    map_box: ["where a picture goes, from six sides", "photo logo image projection decal"],
    map_on_side: ["where a picture goes on one side", "photo logo image projection decal"],
    map_triplanar: ["a picture from three sides, blended without seams", "photo image texture"],
    map_triplanar_alpha: ["the same with the picture's transparency", "photo image texture"],
    Sample1: ["a grey of a picture", "photo logo image texture bitmap"],
    Sample3: ["the colour of a picture", "photo logo image texture bitmap"],
    Sample4: ["the colour of a picture and how much it covers", "photo logo image texture bitmap alpha"],
    skin_of: ["a picture as a coloured skin", "photo logo image full colour decal"],
    skin_color: ["a colour as a skin of inks", "paint full colour"],
    color_ramp: ["from one colour to others", "graded gradient"],
    color_blend: ["between two colours", "graded gradient mix"],
    color_rainbow: ["all colours of the rainbow", "hue spectrum"],
    srgb_to_linear: ["colours of screens as light", "gamma"],
    linear_to_srgb: ["light as colours of screens", "gamma"],
    hsv_to_rgb: ["a colour from hue, saturation and value", "hue"],
    rgb_to_hsv: ["hue, saturation and value of a colour", "hue"],
    rgb_to_xyz: ["a colour as CIE XYZ", "colorimetry"],
    xyz_to_rgb: ["a colour from CIE XYZ", "colorimetry"],
    rgb_to_lab: ["a colour as CIE Lab", "colorimetry"],
    noise: ["soft clouds without a pattern", "random perlin clouds"],
    fbm: ["clouds with fine detail", "random perlin clouds fractal"],
    turbulence: ["billows, for smoke and marble", "random smoke fractal"],
    hash: ["a random number", "random dice"],
    marble: ["veins of marble", "stone vein"],
    wood: ["rings and grain of wood", "timber tree"],
    solid_ball: ["a ball, or a round hole", "sphere hole round drill"],
    solid_box: ["a box, or a square hole", "cube block hole pocket"],
    solid_cylinder: ["a cylinder, or a drilled hole", "hole drill pipe rod bore"],
    solid_difference: ["one shape without another: a hole", "cut hole subtract boolean minus"],
    solid_union: ["two shapes together", "join add boolean plus"],
    solid_intersection: ["what two shapes share", "common boolean and"],
    solid_union_smooth: ["two shapes that melt together", "join blend fillet boolean"],
    solid_intersection_smooth: ["what two shapes share, with soft edges", "common fillet boolean"],
    solid_difference_smooth: ["one shape without another, with soft edges", "cut hole fillet boolean"],
    solid_union_chamfer: ["two shapes together, their seam cut flat", "join bevel boolean"],
    solid_intersection_chamfer: ["what two shapes share, edges cut flat", "bevel boolean"],
    solid_difference_chamfer: ["one shape without another, edges cut flat", "cut hole bevel boolean"],
    polygon: ["a flat outline of corners, to begin with", "shape outline"],
    polygon_edge: ["a flat outline, and one edge more", "shape outline"],
    polygon_distance: ["how far it is to a flat outline", "shape outline"],
    sweep_bezier: ["a pipe along a curve", "tube wire channel"],
    deform_twist: ["turned more and more along z", "screw spiral"],
    deform_repeat: ["again and again in rows", "array copies tile pattern"],
    deform_mirror: ["one half, and its image", "symmetry reflect"],
    deform_turn: ["turned about an axis", "rotate"],
    smoothstep: ["from 0 to 1 between two values, softly", "graded gradient ramp fade"],
    step: ["0 below a value, 1 from it on", "threshold cut"],
    saturate: ["kept between 0 and 1", "clamp limit"],
    clamp: ["kept between two values", "limit"],
    lerp: ["between two values", "mix blend graded gradient"],
    "+": ["the sum", "add plus"], "-": ["the difference", "subtract minus"], "*": ["the product", "multiply times"], "/": ["the quotient", "divide"],
    Set: ["puts an amount of a material into the mixture", "material ink color"],
    Add: ["adds an amount of a material to the mixture", "material ink color"],
};

export function categoryOf(entry) {
    return kCategories.find((one) => one.modules?.includes(entry.module) || (entry.kind !== "library" && one.holds?.(entry)) || (one.name === "Materials" && one.holds(entry))) ?? kCategories.at(-1);
}

/** One line on an entry, without code around it. */
export function plainWords(entry) {
    const own = kWords[entry.name]?.[0];
    if (own && entry.kind !== "own") return own;
    const first = entry.help.replace(/```[^`]*```/g, "").replace(/\s+/g, " ").trim().split(/(?<=[^.\d])[.:;](?= |$)/)[0];
    if (first && !/^The same/.test(first)) return first.replaceAll("`", "");
    return entry.name.replace(/^(color|deform|solid|map|strut|cells|dither|grade|shell)_/, "").replaceAll("_", " ");
}

export function synonymsOf(entry) { return entry.kind === "own" ? "" : kWords[entry.name]?.[1] ?? ""; }

/** How well an entry fits words that are searched for, the less the better; -1 if it does not. */
export function rate(entry, words) {
    if (words.length === 0) return 0;
    const name = entry.name.toLowerCase();
    const synonyms = synonymsOf(entry).split(" ");
    const all = `${name} ${synonymsOf(entry)} ${plainWords(entry)} ${categoryOf(entry).name} ${entry.module} ${entry.signature} ${entry.help}`.toLowerCase();
    if (!words.every((word) => all.includes(word))) return -1;
    const word = words[0];
    if (name === word) return 0;
    if (name.startsWith(word)) return 1;
    if (synonyms.includes(word)) return 2;
    if (name.includes(word)) return 3;
    if (plainWords(entry).toLowerCase().includes(word)) return 4;
    return entry.module.includes(word) ? 5 : 6;
}
