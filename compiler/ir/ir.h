// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The typed IR: per stage one list of scalar instructions in SSA form, each using earlier ones
// only. Translation splits vectors into components and turns structured control flow into selects;
// an instruction that must not run where its branch is not taken (texture lookups) carries a guard,
// the condition under which its path is reached. The interpreter walks this form, passes rewrite
// it, and compiler/lower turns it into one Halide pipeline per stage.

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "abi/fablet_table.h"
#include "compiler/ir/ops.h"
#include "compiler/source/span.h"

namespace openfab::ir {

using ValueId = uint32_t;
constexpr ValueId kNoValue = ~ValueId{0};
/// Index of the first LoopVar's next value among a LoopEnd's arguments.
constexpr size_t kLoopEndNext = 2;
/// The channel of a Sample of a picture that is alpha, and what is added to those before it.
constexpr int32_t kAlphaChannel = 3;
constexpr int32_t kOwnColor = 128;

/// One instruction; the id of its result is its index in Stage::instrs.
///   Const   `bits` is the 32-bit pattern (bool 0 or 1)
///   Input   `kind`, `a`, `b` name a kernel argument as in abi/fablet_table.h. AttrP
///           (OPENFAB_ARG_SURFACE_ATTR, OPENFAB_SURFACE_P) is part-local: the AST translation adds
///           the frame's CENTER. The voxel centre is OPENFAB_ARG_FRAME-based: see VoxelCoord below.
///   Sample  `a` texture index, `b` channel, or of a picture kOwnColor + channel: the colour itself
///           where channels are as they look on white (compiler/interp/sample.h); args: guard, u, v, width, then, once
///           `attach_footprints` has run, du and dv along the three axes:
///           guard, u, v, width, du0, du1, du2, dv0, dv1, dv2
///           In a volume: guard, x, y, z, width, then the changes of x, of y and of z along the
///           three axes: 5 or 14 arguments tell the two apart
///   SampleBound  interval form of Sample, `a`, `b` as there, bits 0 for the lower and 1 for the
///           upper end; args: guard (may be taken), u lo, u hi, v lo, v hi, width hi, then |du| and
///           |dv| upper ends along the three axes (6); in a volume: guard, x lo, x hi, y lo, y hi,
///           z lo, z hi, width hi, then |dx|, |dy| and |dz| upper ends along the three axes (9)
///   BitCast args {value}: its 32 bits as another type; never to or from bool
///   Pick    args {index, element 0, …}: the element that an int or a uint names, the nearest one
///           where it names none. After expand_picks all elements are values of uniforms, more than
///           a few; form_tables makes these Tables
///   Table   a = which of the object's values (OPENFAB_ARG_UNIFORM) is element 0, b = how many of
///           them an element is from the next, bits = how many elements; args {index}, as of Pick
///   Sin … Cellular are functions (compiler/functions): one operation to passes and the
///           interpreter; expand_functions expands them before lowering
///   Hash    a = which result; args {1 or more uints}. A uint
///   Noise, Simplex, Cellular
///           a = which result (compiler/functions/functions.h), of a periodic Noise 8 more; args
///           {1 to 4 float coordinates, of a periodic Noise as many int periods, uint seed}
///   Derivative  a = axis; args {float}: its change per step along the lattice of a base triangle,
///           until attach_footprints expands it
///
/// Loops and queries cut a stage into segments (abi/fablet_table.h). A loop is the stretch of
/// instructions from a Loop to its LoopEnd; loops nest. Instructions inside may use earlier ones;
/// instructions after it use its LoopResults only.
///   Loop    args {guard}. The stretch runs once where the guard holds, then again as long as the
///           LoopEnd's condition holds: voxel by voxel. Guards inside are about a trip that runs.
///   LoopVar a = its number, counted from 0; args {loop, first value}: its value in this trip. All
///           come right after the Loop.
///   LoopEnd args {loop, again, next value of each LoopVar in order}
///   LoopResult a = number of the LoopVar; args {loop end}: the first value where no trip ran, else
///           the next value that the last trip gave
///   Query   the surface point nearest to (x, y, z), part-local mm. a = -1: the part's own
///           displaced surface; else the index among Object uniforms. args {guard, x, y, z}; of a
///           random walk that ends at the surface or the object {guard, x, y, z, stop, seed}
///   QueryResult kind = openfab_query_result, a = nearest input, b = component; args {query}; 0
///           where the guard is false
///   Printf  a = index in Stage::printfs; args {guard, then each printed value}; never used, but
///           kept
/// Loop, LoopEnd, Query and Printf have type bool and no value of their own: only LoopVar and
/// LoopEnd take a Loop, only LoopResult a LoopEnd, only QueryResult a Query.
struct Instr {
    Op op = Op::kConst;
    Type type = Type::kFloat;
    uint32_t bits = 0;
    int32_t kind = 0;  ///< Input: openfab_arg_kind, or kVoxelCoord
    int32_t a = 0;
    int32_t b = 0;
    std::vector<ValueId> args;
    source::Span span;
};

/// Returns whether a Query is a random walk.
inline bool is_walk(const Instr& query) {
    constexpr size_t kWalkArgs = 6;
    return query.args.size() == kWalkArgs;
}

/// Input kinds beyond openfab_arg_kind.
/// kVoxelCoord: a = axis; float(part-relative voxel index along axis) + 0.5f, volume stage. The
/// voxel centre is built from it and the frame in the order that openfab_frame_value states. In
/// volume_bounds it is split in kVoxelCoordLo and Hi.
constexpr int32_t kVoxelCoord = 100;
constexpr int32_t kVoxelCoordLo = 101;
constexpr int32_t kVoxelCoordHi = 102;
constexpr bool is_voxel_coord(int32_t kind) {
    return kind >= kVoxelCoord && kind <= kVoxelCoordHi;
}
/// a = axis; the voxel's index in the print, an int, in a dither rule.
constexpr int32_t kVoxelIndex = 103;

/// Flag in a Noise's `a`: it has periods.
constexpr int32_t kPeriodic = 8;

/// A named result of a stage; `kind`, `a`, `b` as in the kernel's output argument.
struct Output {
    std::string name;
    int32_t kind = 0;  ///< openfab_arg_kind: WEIGHT, DISPLACEMENT (as POSITION before the user's
                       ///< bound), SURFACE_OUT, …
    int32_t a = 0;
    int32_t b = 0;
    ValueId value = kNoValue;
};

/// A `printf` or a failed `assert` that is compiled in: its text, with one %-conversion for each
/// printed value.
struct Printf {
    std::string format;
    bool is_assert = false;  ///< args[0] holds where the assertion fails
    source::Span span;
    std::string source;  ///< file name, line and column where the span begins: set by the driver
    int32_t line = 0;
    int32_t column = 0;
};

/// The kinds from kSurfaceSegment to kVolumeDemand are made by passes: kernels of a stage that is cut into
/// segments, the kernel that computes values of uniforms only, and the kernel that tells which
/// voxels need their nearest surface point.
enum class StageKind : uint8_t {
    kSurface,
    kSurfaceBounds,
    kVolume,
    kVolumeBounds,
    kSurfaceSegment,
    kVolumeSegment,
    kDerived,
    kVolumeDemand,
    kDither,  ///< given, too
    kShape,   ///< likewise
    kShapeAttributes,
    kShapeBounds,
    kShapeSegment,
};

struct Stage {
    StageKind kind = StageKind::kVolume;
    std::vector<Instr> instrs;
    std::vector<Output> outputs;
    std::vector<Printf> printfs;
};

struct Uniform {
    std::string name;
    std::string type_name;
    openfab_uniform_kind kind = OPENFAB_UNIFORM_VALUE;
    Type type = Type::kFloat;
    int32_t components = 1;
    int32_t array_length = 1;
    int32_t first_index = 0;
    std::vector<uint32_t> default_bits;  ///< empty without a default
    std::vector<std::pair<std::string, std::string>>
        annotations;  ///< `[[ float min = 0 ]]` as name and text
    source::Span span;
};

/// Returns the limits of each component, or of a curve's values, that the annotations `min` and `max` give, the most
/// extreme double where one is missing; nothing without either.
std::optional<std::array<double, 2>> limits(const Uniform& uniform);

struct Varying {
    std::string name;
    std::string type_name;
    Type type = Type::kFloat;
    int32_t components = 1;
    int32_t source = -1;  ///< as openfab_varying::source
    std::vector<uint32_t> default_bits;
    source::Span span;
};

struct Fablet {
    std::string name;
    source::Span span;
    std::vector<Uniform> uniforms;
    int32_t uniform_value_count = 0;
    int32_t texture_count = 0;
    int32_t object_count = 0;  ///< Object uniforms; first_index of each is its index among them
    int32_t slot_count = 0;
    int32_t void_slot = -1;
    bool has_surface = false;
    bool has_dither = false;
    bool has_shape = false;
    bool shape_is_distance = false;  ///< declared `[[ distance ]]`
    source::Span claim_span;         ///< of that
    std::vector<Varying> shape_outputs;
    std::vector<Varying> surface_inputs;
    std::vector<Varying> surface_outputs;
    std::vector<Varying> nearest;
    /// has_surface only. Outputs: displacement x, y, z (OPENFAB_ARG_POSITION, b = axis, the
    /// fablet's returned vector, not yet added or clamped), then surface outputs by component.
    Stage surface;
    Stage volume;  ///< outputs: OPENFAB_ARG_WEIGHT, one per slot in order
    /// has_dither only. Output: OPENFAB_ARG_CHOICE, the number of a fraction (OPENFAB_ARG_FRACTION),
    /// which may be anything: see compiler/lower/choose.h.
    Stage dither;
    /// has_shape only. Outputs: OPENFAB_ARG_SHAPE_VALUE, then OPENFAB_ARG_SHAPE_OUT by component.
    Stage shape;
};

struct Module {
    std::vector<Fablet> fablets;
};

#define OPENFAB_IR_COUNT(...) +1
constexpr size_t kOpCount = 0 OPENFAB_IR_OPS(OPENFAB_IR_COUNT);
#undef OPENFAB_IR_COUNT

/// What an operation's arguments are, all of one type, and its result: the columns of
/// compiler/ir/ops.h, which says what they mean.
enum class Operands : uint8_t { kAny, kNumbers, kIntegers, kFloats, kBools, kOwn };
enum class Result : uint8_t { kSame, kBool, kOwn };
struct Traits {
    const char* spelling;
    int arity;  ///< -1: any number
    Operands operands;
    Result result;
};
const Traits& traits(Op op);

enum class Family : uint8_t {
    kLeaf,
    kArithmetic,
    kBits,
    kLogic,
    kEquality,
    kOrder,
    kChoice,
    kExtreme,
    kFloatPart,
    kLookup,
    kControl,
    kElementary,
    kHash,
    kNoise,
    kDerivative,
};
constexpr Family family(Op op) {
    switch (op) {
        OPENFAB_IR_CASES(LEAVES)
        return Family::kLeaf;
        OPENFAB_IR_CASES(ARITHMETIC)
        return Family::kArithmetic;
        OPENFAB_IR_CASES(BITS)
        return Family::kBits;
        OPENFAB_IR_CASES(LOGIC)
        return Family::kLogic;
        OPENFAB_IR_CASES(EQUALITIES)
        return Family::kEquality;
        OPENFAB_IR_CASES(ORDERS)
        return Family::kOrder;
        OPENFAB_IR_CASES(CHOICES)
        return Family::kChoice;
        OPENFAB_IR_CASES(EXTREMES)
        return Family::kExtreme;
        OPENFAB_IR_CASES(FLOAT_PARTS)
        return Family::kFloatPart;
        OPENFAB_IR_CASES(LOOKUPS)
        return Family::kLookup;
        OPENFAB_IR_CASES(CONTROL)
        return Family::kControl;
        OPENFAB_IR_CASES(ELEMENTARY)
        return Family::kElementary;
        OPENFAB_IR_CASES(HASHES)
        return Family::kHash;
        OPENFAB_IR_CASES(NOISES)
        return Family::kNoise;
        OPENFAB_IR_CASES(DERIVATIVES)
        return Family::kDerivative;
    }
    return Family::kLeaf;
}

/// True for Sin to Cellular.
constexpr bool is_function(Op op) {
    const Family of = family(op);
    return of == Family::kElementary || of == Family::kHash || of == Family::kNoise;
}
constexpr bool is_bitwise(Op op) {
    return family(op) == Family::kBits;
}
/// True for less, at most, greater and at least.
constexpr bool is_order(Op op) {
    return family(op) == Family::kOrder;
}
constexpr bool is_comparison(Op op) {
    return family(op) == Family::kEquality || is_order(op);
}
/// True for loops, queries, printfs and their parts: they keep their order and are not pure
/// functions of their arguments.
constexpr bool is_effectful(Op op) {
    return family(op) == Family::kControl;
}

/// Returns the spelling of an operation in dumps.
const char* spelling(Op op);
/// Returns the fixed number of arguments, or -1.
int arity(Op op);
const char* spelling(Type type);

/// Text of a fablet, one instruction a line. It holds all but spans.
std::string dump(const Fablet& fablet);
std::string dump(const Stage& stage);

/// Returns "" if the stage is well formed, else its first fault: a bad type, an argument that comes
/// later or is inside a loop that has ended, a wrong arity.
std::string verify(const Stage& stage);

/// Returns which values the outputs and printfs need, by id. A live loop keeps only the variables
/// whose value or result is live.
std::vector<bool> live_values(const Stage& stage);

/// Drops dead values and renumbers the rest, variables of loops included.
void drop_dead_values(Stage* stage);

/// Returns the LoopEnd of each Loop, by the Loop's id; kNoValue elsewhere.
std::vector<ValueId> loop_ends(const Stage& stage);

/// Appends instructions to a stage. The front end's Emitter (compiler/translate) derives from it
/// and folds constants and common values.
class Builder {
  public:
    explicit Builder(Stage* stage) : stage_(stage) {}
    virtual ~Builder() = default;

    /// Sets the span of the instructions that follow.
    void set_span(const source::Span& span) { span_ = span; }

    ValueId constant(Type type, uint32_t bits);
    ValueId constant(float value);
    ValueId constant(int32_t value);
    ValueId constant(uint32_t value);
    ValueId constant(bool value);
    ValueId input(Type type, int32_t kind, int32_t a, int32_t b);
    /// Emits an operation that is defined by its arguments alone. The result type is the operands',
    /// bool for comparisons.
    ValueId emit(Op op, std::vector<ValueId> args);
    ValueId unary(Op op, ValueId a) { return emit(op, {a}); }
    ValueId binary(Op op, ValueId a, ValueId b) { return emit(op, {a, b}); }
    ValueId convert(ValueId value, Type to);
    ValueId bit_cast(ValueId value, Type to);
    ValueId select(ValueId condition, ValueId if_true, ValueId if_false);
    /// Emits a Pick: `elements` of one type, at least one.
    ValueId pick(ValueId index, const std::vector<ValueId>& elements);
    /// Emits a function or a Derivative; `which` is Instr::a.
    ValueId function(Op op, int32_t which, std::vector<ValueId> args);
    /// Emits a lookup in a picture or a volume; args as for Op::kSample.
    ValueId sample(int32_t texture, int32_t channel, std::vector<ValueId> args);
    ValueId query(int32_t object, ValueId guard, const std::array<ValueId, 3>& point);
    ValueId walk(int32_t object, ValueId guard, const std::array<ValueId, 3>& point, ValueId stop,
                 ValueId seed);
    ValueId query_result(ValueId query, Type type, openfab_query_result kind, int32_t a, int32_t b);

    /// Loops and printfs, which are never merged with equal ones.
    ValueId loop(ValueId guard);
    ValueId loop_var(ValueId loop, int32_t number, ValueId first);
    /// Ends a loop; `next` holds one value for each of its variables.
    virtual ValueId loop_end(ValueId loop, ValueId again, const std::vector<ValueId>& next);
    ValueId loop_result(ValueId loop_end, int32_t number);
    /// `number`: index in Stage::printfs; `args` as for Op::kPrintf.
    ValueId printf(int32_t number, std::vector<ValueId> args);

    /// Appends an instruction unchanged.
    ValueId append(Instr instr);

    const Instr& instr(ValueId value) const { return stage_->instrs[value]; }
    Type type(ValueId value) const { return instr(value).type; }

  protected:
    /// Returns the value of an instruction without side effects; here, appends it.
    virtual ValueId add(Instr instr) { return append(std::move(instr)); }

    Stage* stage_;

  private:
    source::Span span_;
};

}  // namespace openfab::ir
