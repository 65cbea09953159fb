// Rays through a texture of cells: the shader that draws them, and the same walk on the processor for one ray, which
// finds the place that is pointed at.

export const kVertex = `#version 300 es
void main() {
    vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 4.0 - 1.0;
    gl_Position = vec4(corner, 0.0, 1.0);
}`;

// Alpha of a cell is how much a millimetre hides: s = a / (1 - a) per mm, as in the previews' model view.
export const kFragment = `#version 300 es
precision highp float;
precision highp sampler3D;
uniform sampler3D cells;
uniform vec3 size_mm, right, up, towards, low, high;
uniform vec2 half_mm, pixels, middle_mm;
uniform float step_mm;
uniform vec3 cell_mm;
out vec4 result;
vec4 at(vec3 p) { return textureLod(cells, p / size_mm + 0.5, 0.0); }
/** How open a place is to light from all around, 0 to 1: what stands before it, seen coarser the farther it is. */
float open_to_light(vec3 p, vec3 normal) {
    float cell = max(cell_mm.x, max(cell_mm.y, cell_mm.z)), shut = 0.0, weight = 1.0;
    for (int i = 1; i <= 4; ++i) {
        float reach = exp2(float(i)) * cell;
        vec3 there = (p + normal * reach) / size_mm;
        // Beyond the print's box nothing stands; the texture would repeat its last cells there.
        if (max(max(abs(there.x), abs(there.y)), abs(there.z)) < 0.5) shut += weight * textureLod(cells, there + 0.5, float(i) - 1.0).a;
        weight *= 0.75;
    }
    return 1.0 - min(0.62 * shut, 0.85);
}
void main() {
    vec2 screen = (gl_FragCoord.xy / pixels * 2.0 - 1.0) * half_mm - middle_mm;
    vec3 from = right * screen.x + up * screen.y;
    vec3 way = -towards;
    vec3 a = (low - from) / way, b = (high - from) / way;
    vec3 near3 = min(a, b), far3 = max(a, b);
    float t0 = max(max(near3.x, near3.y), near3.z), t1 = min(min(far3.x, far3.y), far3.z);
    result = vec4(0.0);
    if (t0 >= t1) return;
    vec3 light = normalize(towards * 0.7 + up * 0.6 - right * 0.45);
    // The face through which the ray enters: of the print's box, or of a cut.
    vec3 face = near3.x == t0 ? vec3(1, 0, 0) : near3.y == t0 ? vec3(0, 1, 0) : vec3(0, 0, 1);
    float face_lit = 0.66 + 0.36 * max(dot(face * sign(towards), light), 0.0);
    float shift = fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715))));
    vec3 color = vec3(0.0);
    float through = 1.0;
    bool first = true;
    for (float t = t0 + step_mm * 0.5 * shift; t < t1 && through > 0.01; t += step_mm) {
        vec3 p = from + way * t;
        vec4 cell = at(p);
        if (cell.a < 0.004) { first = false; continue; }
        float strength = cell.a > 0.98 ? 60.0 / step_mm : cell.a / (1.0 - cell.a) + (cell.a > 0.5 ? (cell.a - 0.5) * 8.0 / step_mm : 0.0);
        float hidden = 1.0 - exp(-strength * step_mm);
        float lit = face_lit, rim = 0.05 * face_lit;
        if (!first || cell.a < 0.3) {
            vec3 d = cell_mm * 1.2;
            vec3 normal = -vec3(at(p + vec3(d.x, 0, 0)).a - at(p - vec3(d.x, 0, 0)).a,
                           at(p + vec3(0, d.y, 0)).a - at(p - vec3(0, d.y, 0)).a,
                           at(p + vec3(0, 0, d.z)).a - at(p - vec3(0, 0, d.z)).a) / d;
            float length2 = dot(normal, normal);
            normal = length2 > 1e-8 ? normal * inversesqrt(length2) : towards;
            float facing = max(dot(normal, towards), 0.0), direct = max(dot(normal, light), 0.0);
            float ambient = open_to_light(p, normal);
            // A sky above, a floor below; white stays below white, so that it has a form.
            float sky = 0.5 + 0.5 * normal.z;
            lit = ambient * (0.4 + 0.14 * sky) + 0.4 * direct * mix(0.6, 1.0, ambient) + 0.06 * facing;
            // Black has one by what it mirrors.
            vec3 mirrored = reflect(-towards, normal);
            rim = ambient * (0.04 + 0.15 * direct + 0.09 * smoothstep(-0.2, 0.9, mirrored.z) + 0.13 * pow(1.0 - facing, 3.0) + 0.1 * pow(max(dot(mirrored, light), 0.0), 12.0));
        }
        first = false;
        color += through * hidden * min(cell.rgb * lit + rim * cell.a, vec3(1.0));
        through *= 1.0 - hidden;
    }
    result = vec4(color, 1.0 - through);
}`;

/**
 * Where a ray from `from` along `way` is stopped by what it meets between the corners `low` and `high`: the place where
 * half of the light is gone, in mm from the middle of the box of `size` mm, or null. `bytes` are RGBA of `cells`.
 */
export function firstHit({ bytes, cells, size, low, high, from, way, step }) {
    let [t0, t1] = [-Infinity, Infinity];
    for (let a = 0; a < 3; ++a) {
        const direction = way[a] || 1e-6;
        const [p, q] = [(low[a] - from[a]) / direction, (high[a] - from[a]) / direction];
        t0 = Math.max(t0, Math.min(p, q));
        t1 = Math.min(t1, Math.max(p, q));
    }
    let through = 1;
    for (let t = t0 + step * 0.25; t < t1; t += step) {
        const place = from.map((v, a) => v + way[a] * t);
        const [x, y, z] = place.map((v, a) => Math.min(Math.max(Math.floor((v / size[a] + 0.5) * cells[a]), 0), cells[a] - 1));
        const alpha = bytes[((z * cells[1] + y) * cells[0] + x) * 4 + 3] / 255;
        if (alpha > 0.5) return place;
        through *= Math.exp(-alpha / (1 - alpha) * step);
        if (through < 0.5) return place;
    }
    return null;
}
