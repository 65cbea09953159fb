// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/lower/kernel.h"

#include <fmt/format.h>

#include <array>
#include <optional>

#include "compiler/lower/sample_parts.h"
#include "texture/sample.h"

namespace openfab::lower {

namespace {

using Halide::Expr;
using Halide::Var;
using ir::Op;
using ir::Type;

constexpr int32_t kSide = 8;
// Values are cut into Funcs of kChunk operations; LLVM keeps them in registers all the same.
// Several of Halide's passes visit the whole kernel once per value that a Func stores, and all of
// them visit expressions as trees, in which shared subexpressions are repeated: on the gallery, 24
// operations a Func take up to twice the time of 128, and 256 a little more.
constexpr size_t kChunk = 128;
constexpr size_t kChunkBeforeSample = 6;

struct StageNames {
    const char* kernel;
    const char* result;
};

StageNames names_of(ir::StageKind kind) {
    switch (kind) {
        case ir::StageKind::kSurface:
            return {"surface", "vertices"};
        case ir::StageKind::kSurfaceBounds:
            return {"surface_bounds", "patches"};
        case ir::StageKind::kVolume:
            return {"volume", "weights"};
        case ir::StageKind::kVolumeBounds:
            return {"volume_bounds", "bounds"};
        case ir::StageKind::kSurfaceSegment:
            return {"surface_segment", "segment"};
        case ir::StageKind::kVolumeSegment:
            return {"volume_segment", "segment"};
        case ir::StageKind::kVolumeDemand:
            return {"volume_demand", "demand"};
        case ir::StageKind::kDerived:
            break;
    }
    return {"derived", "derived"};
}

class StageLowering {
  public:
    StageLowering(const ir::Stage& stage, openfab_isa isa)
        : stage_(stage), args_(collect_args(stage)), names_(names_of(stage.kind)) {
        context_.isa = isa;
    }

    Kernel run() {
        context_.funcs = &sample_funcs_;
        if (volume()) {
            context_.vars = {z_, x_, y_, n_};
        } else {
            context_.vars = {lane_, group_};
        }
        for (const openfab_arg& arg : args_.inputs)
            add_input(arg);
        lower_values();
        Kernel kernel;
        kernel.arguments = std::move(arguments_);
        define_outputs(&kernel);
        return kernel;
    }

  private:
    using Key = std::array<int32_t, 3>;

    bool volume() const {
        return stage_.kind == ir::StageKind::kVolume || stage_.kind == ir::StageKind::kVolumeDemand;
    }
    bool is_segment() const {
        return stage_.kind == ir::StageKind::kSurfaceSegment ||
               stage_.kind == ir::StageKind::kVolumeSegment;
    }

    void add_input(const openfab_arg& arg) {
        const std::string name = arg_name(arg);
        const Key key = {arg.kind, arg.a, arg.b};
        const Halide::Type type = storage_type(ir_type(arg.scalar));
        if (is_scalar(arg.kind)) {
            const Halide::Param<> param(type, name);
            scalars_.emplace(key, param);
            arguments_.push_back(param);
            return;
        }
        const bool texture = arg.kind == OPENFAB_ARG_TEXTURE;
        const bool blocks = arg.kind == OPENFAB_ARG_BLOCKS;
        const int dimensions = texture ? 1 : blocks ? 2 : volume() ? 4 : 1;
        Halide::ImageParam image(type, dimensions, name);
        if (dimensions == 4) {
            shape_blocks(&image);
        } else {
            for (int d = 0; d < dimensions; ++d)
                image.dim(d).set_min(0);
            if (blocks) image.dim(0).set_extent(3);
        }
        arguments_.push_back(image);
        if (texture) {
            context_.textures.emplace(std::pair(arg.a, arg.b), image);
        } else {
            buffers_.emplace(key, image);
        }
    }

    /// (z 8, x 8, y 8, n), dense inside a block. Halide takes the extents of all outputs from the
    /// first.
    template <typename Buffer>
    static void shape_blocks(Buffer* buffer, bool extents = true) {
        int32_t stride = 1;
        for (int d = 0; d < 3; ++d) {
            buffer->dim(d).set_stride(stride);
            if (extents) buffer->dim(d).set_bounds(0, kSide);
            stride *= kSide;
        }
        if (extents) buffer->dim(3).set_min(0);
    }

    /// Returns the index of this lane along n; lanes past the end repeat the last one, so that no
    /// read is out of bounds.
    Expr index_along(const Halide::ImageParam& image, int dimension) const {
        if (volume()) return n_;
        if (is_segment()) {
            return Halide::unsafe_promise_clamped(listed_group() / (kSide * kSide), 0,
                                                  image.dim(dimension).extent() - 1);
        }
        return Halide::min(group_ * kLanes + lane_, image.dim(dimension).extent() - 1);
    }

    /// Returns the group at this index of a segment's list.
    Expr listed_group() const {
        const Halide::ImageParam& groups = buffers_.at({OPENFAB_ARG_GROUPS, 0, 0});
        return groups(group_);
    }

    Value load(const Key& key, Type type) const {
        if (auto scalar = scalars_.find(key); scalar != scalars_.end()) {
            return from_storage(type, scalar->second);
        }
        const Halide::ImageParam& image = buffers_.at(key);
        if (volume()) return from_storage(type, image(z_, x_, y_, n_));
        if (is_segment()) {
            // The list names groups that the buffers hold.
            const Expr group = Halide::unsafe_promise_clamped(listed_group(), 0,
                                                              image.dim(0).extent() / kLanes - 1);
            return from_storage(type, image(group * kLanes + lane_));
        }
        return from_storage(type, image(index_along(image, 0)));
    }

    /// Returns float(index) + 0.5 of the voxel, or of the first or last voxel of the block.
    Value voxel_coord(const ir::Instr& instr) const {
        const Halide::ImageParam& blocks = buffers_.at({OPENFAB_ARG_BLOCKS, 0, 0});
        Value index{Type::kInt, blocks(instr.a, index_along(blocks, 1))};
        if (instr.kind == ir::kVoxelCoord) {
            std::array<Expr, 3> axes = {x_, y_, z_};
            if (is_segment()) {
                axes = {listed_group() % kSide, listed_group() / kSide % kSide, lane_};
            }
            index = index + Value{Type::kInt, axes[instr.a]};
        } else if (instr.kind == ir::kVoxelCoordHi) {
            const Value size{Type::kInt, scalars_.at({OPENFAB_ARG_BLOCK_SIZE, 0, 0})};
            index = index + (size - constant(1));
        }
        return convert(index, Type::kFloat) + constant(0.5f);
    }

    Value input(const ir::Instr& instr) const {
        if (instr.kind >= ir::kVoxelCoord) return voxel_coord(instr);
        return load({instr.kind, instr.a, instr.b}, instr.type);
    }

    void lower_values() {
        const std::vector<bool> live = ir::live_values(stage_);
        const std::vector<size_t> last_use = last_uses(live);
        const size_t last_picture = last_picture_sample(live);
        values_.resize(stage_.instrs.size());
        for (size_t id = 0; id < stage_.instrs.size(); ++id) {
            const Op op = stage_.instrs[id].op;
            if (!live[id] || values_[id].expr.defined()) continue;
            const bool is_sample = op == Op::kSample || op == Op::kSampleBound;
            context_.feeds_sample = id <= last_picture;
            if (chunk_.size() >= (is_sample ? kChunkBeforeSample : kChunk))
                store_chunk(id, last_use);
            values_[id] = lower(id, live);
            if (!is_sample && op != Op::kConst && op != Op::kInput) chunk_.push_back(id);
        }
    }

    /// Returns the last lookup in a picture; 0 (never a lookup) if there is none.
    size_t last_picture_sample(const std::vector<bool>& live) const {
        size_t out = 0;
        for (size_t id = 0; id < stage_.instrs.size(); ++id) {
            const ir::Instr& instr = stage_.instrs[id];
            if (live[id] && instr.op == Op::kSample && !is_volume_sample(instr.args.size()))
                out = id;
        }
        return out;
    }

    /// Finds the last instruction that uses each value; past the end for outputs.
    std::vector<size_t> last_uses(const std::vector<bool>& live) const {
        std::vector<size_t> out(stage_.instrs.size(), 0);
        for (size_t id = 0; id < stage_.instrs.size(); ++id) {
            if (!live[id]) continue;
            for (const ir::ValueId arg : stage_.instrs[id].args)
                out[arg] = id;
        }
        for (const ir::Output& output : stage_.outputs)
            out[output.value] = stage_.instrs.size();
        return out;
    }

    /// values_k: what the chunk computes and instructions from `next` on still need.
    void store_chunk(size_t next, const std::vector<size_t>& last_use) {
        std::vector<size_t> kept;
        std::vector<Expr> stored;
        for (const size_t id : chunk_) {
            if (last_use[id] < next) continue;
            kept.push_back(id);
            stored.push_back(to_storage(values_[id]));
        }
        chunk_.clear();
        if (kept.empty()) return;
        const std::string name = func_name(context_, "values", chunks_++);
        const Halide::Func func = new_func(&context_, name, context_.vars).func;
        func(context_.vars) = Halide::Tuple(stored);
        const std::vector<Expr> here(context_.vars.begin(), context_.vars.end());
        for (size_t k = 0; k < kept.size(); ++k) {
            const Expr loaded =
                kept.size() == 1 ? Expr(func(here)) : func(here)[static_cast<int>(k)];
            values_[kept[k]] = from_storage(values_[kept[k]].type, loaded);
        }
    }

    std::vector<Value> arguments(const ir::Instr& instr) const {
        std::vector<Value> out;
        for (ir::ValueId arg : instr.args)
            out.push_back(values_[arg]);
        return out;
    }

    Value lower(size_t id, const std::vector<bool>& live) {
        const ir::Instr& instr = stage_.instrs[id];
        switch (instr.op) {
            case Op::kConst:
                return constant_bits(instr.type, instr.bits);
            case Op::kInput:
                return input(instr);
            case Op::kConvert:
                return convert(values_[instr.args[0]], instr.type);
            case Op::kBitCast:
                return bit_cast(values_[instr.args[0]], instr.type);
            case Op::kSample:
                lower_sample_group(id, live);
                return values_[id];
            case Op::kSampleBound:
                lower_bound_pair(id, live);
                return values_[id];
            default:
                return operate(instr.op, arguments(instr));
        }
    }

    /// Lowers channels read at one coordinate together: they share footprint, taps and addresses.
    void lower_sample_group(size_t id, const std::vector<bool>& live) {
        const ir::Instr& instr = stage_.instrs[id];
        std::vector<size_t> members;
        std::vector<int32_t> channels;
        for (size_t other = id;
             other < stage_.instrs.size() && members.size() < texture::kMaxSampleResults; ++other) {
            const ir::Instr& candidate = stage_.instrs[other];
            if (live[other] && candidate.op == Op::kSample && candidate.a == instr.a &&
                candidate.args == instr.args) {
                members.push_back(other);
                channels.push_back(candidate.b);
            }
        }
        const std::vector<Value> results =
            lower_sample(&context_, instr.a, channels, arguments(instr));
        for (size_t k = 0; k < members.size(); ++k)
            values_[members[k]] = results[k];
    }

    void lower_bound_pair(size_t id, const std::vector<bool>& live) {
        const ir::Instr& instr = stage_.instrs[id];
        const std::array<Value, 2> ends =
            lower_sample_bound(&context_, instr.a, instr.b, arguments(instr));
        for (size_t other = id; other < stage_.instrs.size(); ++other) {
            const ir::Instr& candidate = stage_.instrs[other];
            if (live[other] && candidate.op == Op::kSampleBound && candidate.a == instr.a &&
                candidate.b == instr.b && candidate.args == instr.args) {
                values_[other] = ends[candidate.bits & 1u];
            }
        }
    }

    static NamedFunc named(const std::string& name, const Halide::Func& func,
                           const std::vector<Var>& vars) {
        NamedFunc out{name, func, {}};
        for (const Var& var : vars)
            out.vars.emplace_back(var.name(), var);
        return out;
    }

    void define_outputs(Kernel* kernel) {
        std::vector<Expr> results;
        for (const ir::Output& output : stage_.outputs) {
            results.push_back(to_storage(values_[output.value]));
        }
        Halide::Func result(names_.result);
        result(context_.vars) = Halide::Tuple(results);
        const NamedFunc result_named = named(names_.result, result, context_.vars);
        if (volume()) {
            kernel->output = result;
            result.bound(z_, 0, kSide).bound(x_, 0, kSide).bound(y_, 0, kSide);
            bool first = true;
            for (auto& buffer : result.output_buffers()) {
                shape_blocks(&buffer, first);
                first = false;
            }
        } else if (is_segment()) {
            kernel->output = result;
            result.bound(lane_, 0, kLanes);
            bool first = true;
            for (auto& buffer : result.output_buffers()) {
                buffer.dim(0).set_stride(1);
                buffer.dim(1).set_stride(kLanes);
                if (first) buffer.dim(0).set_bounds(0, kLanes);
                if (first) buffer.dim(1).set_min(0);
                first = false;
            }
        } else {
            Halide::Func store("store");
            std::vector<Expr> copies;
            const std::vector<Expr> from = {n_ % kLanes, n_ / kLanes};
            for (size_t k = 0; k < results.size(); ++k) {
                copies.push_back(results.size() == 1 ? Expr(result(from))
                                                     : result(from)[static_cast<int>(k)]);
            }
            store(n_) = Halide::Tuple(copies);
            // The lanes are always computed together: they share the loop over taps.
            result.bound(lane_, 0, kLanes);
            store.output_buffers()[0].dim(0).set_min(0);
            kernel->output = store;
            kernel->funcs.push_back(named("store", store, {n_}));
        }
        kernel->funcs.push_back(result_named);
        kernel->funcs.insert(kernel->funcs.end(), sample_funcs_.rbegin(), sample_funcs_.rend());
    }

    const ir::Stage& stage_;
    const KernelArgs args_;
    const StageNames names_;
    const Var z_{"z"}, x_{"x"}, y_{"y"}, n_{"n"}, lane_{"lane"}, group_{"group"};
    LoweringContext context_;
    std::vector<NamedFunc> sample_funcs_;  ///< producers first
    std::map<Key, Halide::Param<>> scalars_;
    std::map<Key, Halide::ImageParam> buffers_;
    std::vector<Halide::Argument> arguments_;
    std::vector<Value> values_;
    std::vector<size_t> chunk_;  ///< values not stored in a Func yet
    int32_t chunks_ = 0;
};

}  // namespace

const char* kernel_name(ir::StageKind kind) {
    return names_of(kind).kernel;
}

Kernel make_kernel(const ir::Stage& stage, openfab_isa isa) {
    return StageLowering(stage, isa).run();
}

}  // namespace openfab::lower
