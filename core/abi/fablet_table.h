/* Copyright 2026 The OpenFab Authors
 * SPDX-License-Identifier: Apache-2.0 */
#pragma once

/* The contract between generated code and the runtime, in plain C.
 *
 * `openflc` compiles each fablet to a few kernels (surface, surface_bounds, slab, volume_bounds,
 * volume_demand, derived, those of a shape) and a constant `openfab_fablet` that describes them; a
 * print binary exports the list of its fablets as `openfab_fablet_list`. The runtime knows no fablet: it reads a
 * kernel's argument list and passes what is asked for.
 *
 * Kernels follow Halide's argv convention: `args[i]` points to a `halide_buffer_t` for a buffer and
 * to the 32-bit value for a scalar (OPENFAB_ARG_NEAREST_SOURCE: a pointer); the result is 0 or a Halide error code. A bool is passed as
 * int32 (0 or 1).
 *
 * A block is 8 x 8 x 8 voxels and has 64 columns of 8 voxels along z; voxel (z, x, y) of block n
 * is number z of column 64 n + 8 y + x. Buffer shapes, innermost dimension first; n is the number
 * of blocks (slab, volume_demand), patches (surface_bounds) or micro-vertices (surface), and m that
 * of the columns that a call lists (OPENFAB_ARG_GROUPS):
 *
 *   states, and inputs of segments of the volume stage (512 n), column after column
 *   outputs of slab, volume_demand                   (z 8, m)
 *   volume_bounds, surface_bounds, surface buffers   (n)
 *   buffers of a shape, of n points or boxes         (n)
 *   blocks                                           (3, n) int32
 *
 * All lengths are millimetres. Part-local space is part space relative to the centre of the part's
 * base box, which keeps float coordinates small; the frame holds that centre.
 */

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define OPENFAB_ABI_VERSION 14

/* The columns that a slab kernel's list has, or any multiple. */
#define OPENFAB_LISTED_COLUMNS 64

/* The most columns, and the most vertices, patches, blocks or groups, of one call of a kernel. */
#define OPENFAB_MOST_COLUMNS 1024
#define OPENFAB_MOST_PLACES 16384

typedef int (*openfab_kernel_fn)(void** args);

/* Instruction sets a kernel is compiled for; each machine that has one has those before it. All give
 * the same bits; the runtime takes the best that the machine has and the kernel was compiled for.
 * AVX-512 is that of Skylake servers and Zen 4: F, CD, BW, DQ and VL. */
enum openfab_isa {
    OPENFAB_ISA_SSE41 = 0,
    OPENFAB_ISA_AVX2 = 1,
    OPENFAB_ISA_AVX512 = 2,
    OPENFAB_ISA_COUNT = 3
};

enum openfab_scalar_type {
    OPENFAB_BOOL = 0,
    OPENFAB_INT = 1,
    OPENFAB_UINT = 2,
    OPENFAB_FLOAT = 3,
};

enum openfab_uniform_kind {
    OPENFAB_UNIFORM_VALUE = 0, /* bool/int/uint/float, 1 to 16 components */
    OPENFAB_UNIFORM_TEXTURE2D = 1,
    OPENFAB_UNIFORM_MATERIAL = 2,
    OPENFAB_UNIFORM_TEXTURE3D = 3,    /* counted with the 2-D textures */
    OPENFAB_UNIFORM_OBJECT = 4,       /* another object of the world, for distance_to */
    OPENFAB_UNIFORM_CURVE = 5,        /* floats, as abi/curve_table.h lays them out */
    OPENFAB_UNIFORM_CURVE_CHANGE = 6, /* of derivatives: floats, as there; nobody binds it */
};

/* One `@uniform` declaration. `first_index` is, by kind: the index of component 0 in the object's
 * array of 32-bit uniform values; the first texture index; the first material slot; the first
 * object. An array of length L takes L times as many slots. */
struct openfab_uniform {
    const char* name;
    const char* type_name; /* as in OpenFL; then a line "name\tvalue\tlabel" per named value */
    enum openfab_uniform_kind kind;
    enum openfab_scalar_type scalar;
    int32_t components;
    int32_t array_length; /* 1 unless an array */
    int32_t first_index;
    const uint32_t*
        default_bits; /* components * array_length values, or NULL where the world must bind it */
    const double* limits; /* minimum and maximum of each component, or NULL without limits */
};

/* A varying: an input or output of the surface stage, or a @nearest input of the volume stage. */
struct openfab_varying {
    const char* name;
    const char* type_name;
    enum openfab_scalar_type scalar;
    int32_t components;
    /* Surface output: the surface input it is a plain copy of, else -1.
     * Nearest input: the surface output it reads, or -1 for the mesh attribute of its name. */
    int32_t source;
    const uint32_t*
        default_bits; /* surface input: constant default where the mesh lacks it, else NULL */
};

/* Values of the frame: scalars that belong to a part and its grid (kind OPENFAB_ARG_FRAME, a =
 * index). The centre of the voxel with part-relative index (i, j, k) is, in part-local space and in
 * exactly this order,
 *   ((x * STEP_I + y * STEP_J) + z * STEP_K) + ORIGIN
 *   with x = float(i) + 0.5f, y = float(j) + 0.5f, z = float(k) + 0.5f
 * for each of the three components; attr.voxelCenter is that plus CENTER.
 *   attr.buildPosition = BUILD_ORIGIN + (x, y, z) * VOXEL_SIZE */
enum openfab_frame_value {
    OPENFAB_FRAME_STEP_I = 0,            /* 3 components */
    OPENFAB_FRAME_STEP_J = 3,            /* 3 */
    OPENFAB_FRAME_STEP_K = 6,            /* 3 */
    OPENFAB_FRAME_ORIGIN = 9,            /* 3 */
    OPENFAB_FRAME_CENTER = 12,           /* 3 */
    OPENFAB_FRAME_VOXEL_SIZE = 15,       /* 3, mm along build x, y, z */
    OPENFAB_FRAME_BUILD_ORIGIN = 18,     /* 3 */
    OPENFAB_FRAME_MAX_DISPLACEMENT = 21, /* the user's bound in mm; +inf without one */
    /* of a part whose geometry is its own fablet's shape: that stage's space is the part's times this, along each
     * axis; 0 of other parts, NaN of one that is stretched along other axes */
    OPENFAB_FRAME_SHAPE_SHRINK = 22, /* 3 */
    OPENFAB_FRAME_SHAPE_DISTANCE =
        25, /* a declared distance is the value times this; 0: it is searched for */
    OPENFAB_FRAME_COUNT = 26,
};

/* The built-in attributes of the surface stage (kind OPENFAB_ARG_SURFACE_ATTR, a = this, b =
 * component). */
enum openfab_surface_attr {
    OPENFAB_SURFACE_P =
        0, /* float3, part-local: the fablet's attr.p is this plus the frame's CENTER */
    OPENFAB_SURFACE_N = 1,  /* float3, unit */
    OPENFAB_SURFACE_NG = 2, /* float3, unit */
    OPENFAB_SURFACE_UV = 3, /* float2 */
    OPENFAB_SURFACE_DPDU = 4,
    OPENFAB_SURFACE_DPDV = 5,
};

/* The buffers of a texture (kind OPENFAB_ARG_TEXTURE, b). Layouts: texture/pyramid.h. */
enum openfab_texture_buffer {
    OPENFAB_TEXTURE_TEXELS = 0, /* float, 1-D */
    OPENFAB_TEXTURE_INFO = 1,   /* int32, 1-D */
    OPENFAB_TEXTURE_MINMAX = 2, /* float, 1-D: bounds pyramid */
};

/* What a dither rule knows of the print (kind OPENFAB_ARG_GRID, a = index). */
enum openfab_grid_value {
    OPENFAB_GRID_BASE = 0, /* int32, 3: the print's index of the part's voxel (0, 0, 0) */
    OPENFAB_GRID_SEED = 3, /* uint32: fold_seed of abi/voxel_hash.h */
};

enum openfab_arg_kind {
    OPENFAB_ARG_UNIFORM = 0,  /* scalar; a = index in the array of 32-bit uniform values */
    OPENFAB_ARG_TEXTURE = 1,  /* buffer; a = texture index, b = openfab_texture_buffer */
    OPENFAB_ARG_FRAME = 2,    /* scalar float; a = openfab_frame_value + component */
    OPENFAB_ARG_INSTANCE = 3, /* scalar int32 */
    OPENFAB_ARG_BLOCKS =
        4, /* int32 (3, n): part-relative voxel index of each block's lowest corner */
    OPENFAB_ARG_BLOCK_SIZE = 5, /* scalar int32: voxels a side (volume_bounds: 4, 8, 16, 32, 64) */
    /* kernels of segments of the volume stage, and the slab kernel after them; what another slab
     * kernel asks its extern stage for */
    OPENFAB_ARG_NEAREST = 6, /* a = nearest input, b = component */
    OPENFAB_ARG_NEAREST_GRAD =
        7, /* a = nearest input, b = component * 3 + axis: change per voxel step along i, j, k */
    OPENFAB_ARG_DISTANCE = 8, /* signed distance at the voxel centre */
    OPENFAB_ARG_WEIGHT = 9,   /* what a volume stage gives, in the compiler only; a = slot */
    /* volume_bounds: every buffer is a pair */
    OPENFAB_ARG_NEAREST_LO = 10,
    OPENFAB_ARG_NEAREST_HI = 11,
    OPENFAB_ARG_DISTANCE_LO = 12,
    OPENFAB_ARG_DISTANCE_HI = 13,
    OPENFAB_ARG_WEIGHT_LO = 14, /* out; a = slot. NaN where nothing is known */
    OPENFAB_ARG_WEIGHT_HI = 15,
    /* surface: one value per micro-vertex */
    OPENFAB_ARG_SURFACE_IN = 16, /* a = surface input, b = component */
    OPENFAB_ARG_SURFACE_IN_GRAD =
        17, /* a = surface input, b = component * 2 + axis: change per lattice step */
    OPENFAB_ARG_SURFACE_ATTR = 18,      /* a = openfab_surface_attr, b = component */
    OPENFAB_ARG_SURFACE_ATTR_GRAD = 19, /* b = component * 2 + axis */
    OPENFAB_ARG_POSITION = 20,          /* out; b = axis: displaced position, part-local */
    OPENFAB_ARG_SURFACE_OUT = 21,       /* out; a = output, b = component */
    OPENFAB_ARG_SURFACE_STATUS =
        22, /* out int32: 0 fine, 1 displacement was not finite, 2 cut to the user's bound */
    /* surface_bounds: one value per patch, in pairs */
    OPENFAB_ARG_SURFACE_IN_LO = 23,
    OPENFAB_ARG_SURFACE_IN_HI = 24,
    OPENFAB_ARG_SURFACE_IN_GRAD_LO = 25,
    OPENFAB_ARG_SURFACE_IN_GRAD_HI = 26,
    OPENFAB_ARG_SURFACE_ATTR_LO = 27,
    OPENFAB_ARG_SURFACE_ATTR_HI = 28,
    OPENFAB_ARG_SURFACE_ATTR_GRAD_LO = 29,
    OPENFAB_ARG_SURFACE_ATTR_GRAD_HI = 30,
    OPENFAB_ARG_DISPLACEMENT_LO = 31, /* out; b = axis; before the cut to the user's bound */
    OPENFAB_ARG_DISPLACEMENT_HI = 32,
    OPENFAB_ARG_SURFACE_OUT_LO = 33, /* out */
    OPENFAB_ARG_SURFACE_OUT_HI = 34,
    /* kernels of segments, see openfab_segments */
    /* slab and volume_demand too, where a group is a column. A slab kernel takes a multiple of
     * OPENFAB_LISTED_COLUMNS: lists are filled up with their last column */
    OPENFAB_ARG_GROUPS = 35, /* int32 (m): the groups of 8 lanes that this call evaluates */
    OPENFAB_ARG_STATE = 36,  /* a = state; read at 8 * group + lane. Of the slab kernel after
                                segments, too */
    OPENFAB_ARG_STATE_OUT =
        37, /* out, a = state; written at 8 * i + lane for the i-th listed group */
    /* kernel `derived` */
    OPENFAB_ARG_DERIVED = 38, /* out (1); a = its index behind the uniform values */
    /* volume_demand */
    OPENFAB_ARG_DEMAND = 39, /* out (z, m), 8 bits: whether the voxel reads a NEAREST,
                                NEAREST_GRAD or DISTANCE input */
    /* slab, which normalises the slots' amounts (abi/stage_table.h) */
    OPENFAB_ARG_CHANNELS = 40, /* int32 (3, channel) */
    OPENFAB_ARG_CODE = 41,     /* out, 8 bits of a uint */
    OPENFAB_ARG_UNUSABLE = 42, /* out, 16 bits */
    OPENFAB_ARG_FRACTION = 43, /* out, 16 bits, columns any number of values apart; a = channel, of
                                  which there are one more than slots */
    OPENFAB_ARG_NEAREST_SOURCE = 44, /* an openfab_nearest_source (abi/nearest_stage.h) */
    /* slab of a fablet with a dither rule. The rule reads FRACTION values as int32. */
    OPENFAB_ARG_GRID = 45,       /* scalar; a = openfab_grid_value */
    OPENFAB_ARG_CHOICE = 46,     /* out, 8 bits of a uint: the code that the rule chooses */
    OPENFAB_ARG_BLUE_NOISE = 47, /* 16 bits (8, pixel), a mask of abi/blue_noise.h; a = 0: inside a
                                    region, 1: of its sides. The rule reads thresholds as int32, with
                                    a = openfab::abi::BlueNoiseFace */
    OPENFAB_ARG_VALUES = 48,     /* 32 bits (n): all values of the object, see table_values; read at
                                    indices that vary */
    /* kernels of a shape: one value per point or box, coordinates part-local */
    OPENFAB_ARG_SHAPE_POINT = 49, /* a = axis */
    OPENFAB_ARG_SHAPE_POINT_LO =
        50, /* a = axis; of a box, whose points may be any floats between */
    OPENFAB_ARG_SHAPE_POINT_HI = 51,
    OPENFAB_ARG_SHAPE_VALUE = 52, /* out; negative inside. May be NaN or infinite */
    OPENFAB_ARG_SHAPE_VALUE_LO =
        53, /* out; NaN, both, where the value is not known or may be NaN */
    OPENFAB_ARG_SHAPE_VALUE_HI = 54,
    OPENFAB_ARG_SHAPE_OUT = 55, /* out; a = output, b = component */
};

struct openfab_arg {
    enum openfab_arg_kind kind;
    enum openfab_scalar_type
        scalar; /* element type of the buffer or the scalar; a bool is an int32 */
    int32_t a;
    int32_t b;
};

/* A kernel lists only the arguments that it uses. `fn[isa]` is NULL where it was not compiled for
 * that set. */
struct openfab_kernel {
    openfab_kernel_fn fn[OPENFAB_ISA_COUNT];
    int32_t arg_count;
    const struct openfab_arg* args;
    /* 1: the outputs, which come last, are one argument, in the place of the first of them: a buffer
     * of 32-bit uints (8, output, m) of a kernel that lists groups, (n, output) of others. What a
     * compiler does with a buffer for each takes a time that grows with the square of how many. */
    int32_t packed;
};

/* The results of a query (openfab_query). */
enum openfab_query_result {
    OPENFAB_QUERY_DISTANCE = 0,  /* signed, mm */
    OPENFAB_QUERY_POSITION = 1,  /* b = axis, part-local mm */
    OPENFAB_QUERY_NORMAL = 2,    /* b = axis; unit, outward, of the winning micropolygon */
    OPENFAB_QUERY_ATTRIBUTE = 3, /* a = nearest input, b = component */
    OPENFAB_QUERY_END = 4,       /* of a walk: b = axis, where it ends, part-local mm */
    OPENFAB_QUERY_END_ON = 5,    /* of a walk: int, 1 if it ends on the object */
};

struct openfab_query_output {
    enum openfab_query_result kind;
    int32_t a;
    int32_t b;
    int32_t state;
};

/* A nearest-surface query at any point, or a random walk from it (rule 24). Where the guard is 0 there is no query and
 * every output is 0. */
struct openfab_query {
    int32_t object;   /* -1: the part's own surface; else the index among OPENFAB_UNIFORM_OBJECTs,
                         where a walk ends, too */
    int32_t guard;    /* state, int32 0 or 1 */
    int32_t point[3]; /* states, part-local mm of the querying part */
    int32_t stop;     /* of a walk: state, a float, mm; -1: no walk */
    int32_t seed;     /* of a walk: state, an int */
    int32_t output_count;
    const struct openfab_query_output* outputs;
};

/* A printf, or a failed assert. */
struct openfab_printf {
    const char* format; /* one conversion for each value */
    int32_t is_assert;
    const char* source; /* file name */
    int32_t line, column;
    int32_t guard; /* state */
    int32_t value_count;
    const int32_t* values; /* states */
};

enum openfab_step_kind {
    OPENFAB_STEP_KERNEL = 0,   /* a = kernel: runs on the groups of the current list */
    OPENFAB_STEP_LOOP = 1,     /* a = state `active`, b = step after the loop. Narrows the list to
                                  groups with an active lane */
    OPENFAB_STEP_LOOP_END = 2, /* a = state `active`, b = the loop's first inner step. Like LOOP;
                                  repeats while any is left, else restores the previous list */
    OPENFAB_STEP_QUERY = 3,    /* a = query */
    OPENFAB_STEP_PRINTF = 4,   /* a = printf */
    OPENFAB_STEP_ELEMENTS = 5, /* a = elements */
};

enum openfab_elements_kind {
    OPENFAB_ELEMENTS_LOAD = 0,  /* `value` gets the element that `index` names */
    OPENFAB_ELEMENTS_STORE = 1, /* that gets `value` */
    OPENFAB_ELEMENTS_FILL = 2,  /* all get it */
    OPENFAB_ELEMENTS_COPY = 3,  /* element k gets state value + k * value_apart */
};

/* What is done to the elements of an array: `count` states, `apart` numbers from one to the next. */
struct openfab_elements {
    enum openfab_elements_kind kind;
    int32_t first;
    int32_t apart;
    int32_t count;
    int32_t index; /* state, an int, which is clamped to 0 .. count - 1; -1 of FILL and COPY */
    int32_t value; /* state */
    int32_t value_apart;
    int32_t guard; /* state: lanes where it is 0 stay as they are. -1: none stays */
};

struct openfab_step {
    enum openfab_step_kind kind;
    int32_t a;
    int32_t b;
};

/* A stage with loops whose trips depend on the lane, or with queries at other points than the
 * voxel's centre: a program over lists of groups of 8 lanes (columns of 8 voxels along z: group
 * (block * 8 + y) * 8 + x; or 8 micro-vertices). State is one array of 32-bit values for each state
 * number, 8 per group. Kernels take the buffers of the stage as flat arrays that are read at
 * 8 * group + lane; they write STATE_OUT, POSITION, … at 8 * i + lane, from where the
 * runtime scatters it. The kernels themselves track which lanes of a group are active.
 *
 * State 0 is the runtime's: a bool, 1 for lanes to evaluate. Loops, queries and printfs do nothing
 * for the others; the first list is the groups that have such a lane. */
struct openfab_segments {
    int32_t step_count; /* 0: the stage is a single kernel */
    const struct openfab_step* steps;
    int32_t kernel_count;
    const struct openfab_kernel* kernels;
    int32_t query_count;
    const struct openfab_query* queries;
    int32_t printf_count;
    const struct openfab_printf* printfs;
    int32_t state_count;
    const enum openfab_scalar_type* states; /* type of each */
    int32_t elements_count;
    const struct openfab_elements* elements;
};

/* A value that a table of an object holds: a copy of value `from`, a uniform's or a derived one; or,
 * where that is -1, these bits. */
struct openfab_table_value {
    int32_t from;
    uint32_t bits;
};

/* The @Shape stage: a solid as a function of a point. It stands where a mesh does, and its outputs
 * where the mesh's attributes do: @nearest inputs and inputs of @Surface read them by name. It reads
 * uniforms, derived and table values, textures (always their finest level) and the frame's CENTER,
 * nothing else of the frame: it is the same for all placements and grids. */
struct openfab_shape {
    int32_t is_distance; /* 1: declared a distance to the surface, signed, in mm */
    int32_t output_count;
    const struct openfab_varying* outputs; /* source is -1 */

    struct openfab_kernel values;     /* SHAPE_POINT to SHAPE_VALUE */
    struct openfab_kernel attributes; /* SHAPE_POINT to SHAPE_OUT; no arguments without outputs */
    /* SHAPE_POINT_LO, HI to SHAPE_VALUE_LO, HI. No arguments: nothing is known of any box. */
    struct openfab_kernel bounds;

    /* If one has steps, `values` or `attributes` is no single kernel, and its arguments are the
     * buffers of the batch that the segments read and write, as of a surface stage: groups of 8
     * points, in order. There are no queries. */
    struct openfab_segments value_segments;
    struct openfab_segments attribute_segments;
};

struct openfab_fablet {
    int32_t abi_version;
    const char* name;
    const char* source_name; /* file name of the OpenFL source, for messages */
    uint64_t hash;           /* of the stages before any pass: what they mean, not how they run */

    int32_t uniform_count;
    const struct openfab_uniform* uniforms;
    int32_t uniform_value_count; /* 32-bit values */
    int32_t texture_count;
    int32_t object_count;
    int32_t slot_count; /* material slots, VOID included where the fablet names it */
    int32_t void_slot;  /* the slot of the built-in VOID, or -1 */

    int32_t has_dither;  /* 1: the slab kernel has a CHOICE, by the fablet's @Dither */
    int32_t has_surface; /* 0: no @Surface stage; the base mesh is the surface */
    int32_t surface_input_count;
    const struct openfab_varying* surface_inputs;
    int32_t surface_output_count;
    const struct openfab_varying* surface_outputs;
    int32_t nearest_count;
    const struct openfab_varying* nearest;

    struct openfab_kernel surface; /* no arguments where has_surface is 0 */
    struct openfab_kernel surface_bounds;
    struct openfab_kernel slab;
    struct openfab_kernel volume_bounds;

    /* If one has steps, the stage is no single kernel. The arguments of surface are then the buffers
     * of the batch that the segments read and write. The last segment of a volume is in the slab
     * kernel, which reads the others' states and the fields that they were given, for columns of the
     * same blocks; if that has no arguments, amounts are in states: of slot k in state k + 1. */
    struct openfab_segments surface_segments;
    struct openfab_segments volume_segments;

    /* 32-bit values that follow the uniform values (OPENFAB_ARG_UNIFORM with a from
     * uniform_value_count on) and the kernel that computes them from those, once per object. */
    int32_t derived_count;
    struct openfab_kernel derived;

    /* 32-bit values that follow those. */
    int32_t table_value_count;
    const struct openfab_table_value* table_values;

    /* What the volume stage reads of the nearest surface point of each voxel: arguments of kind
     * NEAREST, NEAREST_GRAD or DISTANCE. */
    int32_t field_count;
    const struct openfab_arg* fields;

    /* Of a volume stage of segments: computes which voxels need their nearest surface point; the
     * fields of others are undefined. Without arguments all voxels need it. (A slab kernel has this
     * inside.) */
    struct openfab_kernel volume_demand;

    /* What a call of any of these kernels stores between its stages, at most, in each thread that
     * works on it. Schedules decide it. */
    int64_t stored_bytes;

    const struct openfab_shape* shape; /* NULL without a @Shape stage */
};

struct openfab_fablet_list {
    int32_t count;
    const struct openfab_fablet* const* fablets;
};

/* Defined by every print binary. */
extern const struct openfab_fablet_list openfab_fablets;

#ifdef __cplusplus
}
#endif
