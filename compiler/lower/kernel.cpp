// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/lower/kernel.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>

#include "compiler/lower/blue_noise.h"
#include "compiler/lower/normalise.h"
#include "compiler/lower/sample_parts.h"
#include "texture/sample.h"

namespace openfab::lower {

namespace {

using Halide::Expr;
using Halide::Var;
using ir::Op;
using ir::Type;

constexpr int32_t kSide = 8;
// More values than these are stored before a lookup, rather than computed before and after it.
constexpr size_t kMostComputedTwice = 6;

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
            return {"slab", "weights"};
        case ir::StageKind::kVolumeBounds:
            return {"volume_bounds", "bounds"};
        case ir::StageKind::kSurfaceSegment:
            return {"surface_segment", "segment"};
        case ir::StageKind::kVolumeSegment:
            return {"volume_segment", "segment"};
        case ir::StageKind::kVolumeDemand:
            return {"volume_demand", "demand"};
        case ir::StageKind::kShape:
            return {"shape", "points"};
        case ir::StageKind::kShapeAttributes:
            return {"shape_attributes", "points"};
        case ir::StageKind::kShapeBounds:
            return {"shape_bounds", "boxes"};
        case ir::StageKind::kShapeSegment:
            return {"shape_segment", "segment"};
        case ir::StageKind::kDither:  // inside the slab kernel
        case ir::StageKind::kDerived:
            break;
    }
    return {"derived", "derived"};
}

/// True for kernels whose groups of lanes are columns of voxels.
bool of_columns(ir::StageKind kind) {
    return kind == ir::StageKind::kVolume || kind == ir::StageKind::kVolumeDemand;
}

class StageLowering {
  public:
    StageLowering(const ir::Stage& stage, const SlabStages& inside, openfab_isa isa)
        : kind_(stage.kind),
          stage_(&stage),
          demand_(inside.demand),
          dither_(inside.dither),
          args_(collect_args(stage, inside)),
          names_(names_of(stage.kind)),
          lane_(of_columns(stage.kind) ? "z" : "lane"),
          group_(of_columns(stage.kind) ? "column" : "group"),
          fields_(is_slab() && !inside.after_segments ? collect_fields(stage)
                                                      : std::vector<openfab_arg>()) {
        context_.isa = isa;
    }

    Kernel run() {
        context_.funcs = &sample_funcs_;
        context_.vars = {lane_, group_};
        for (const openfab_arg& arg : args_.inputs)
            add_input(arg);
        if (is_slab()) define_nearest();
        lower_values("values");
        Kernel kernel;
        kernel.arguments = std::move(arguments_);
        kernel.deferred = deferred_;
        define_outputs(&kernel);
        return kernel;
    }

  private:
    using Key = std::array<int32_t, 3>;

    bool is_slab() const { return kind_ == ir::StageKind::kVolume; }
    bool has_list() const { return lists_groups(kind_); }

    void add_input(const openfab_arg& arg) {
        const std::string name = arg_name(arg);
        if (arg.kind == OPENFAB_ARG_NEAREST_SOURCE) {
            source_ = Halide::Param<void*>(name);
            arguments_.push_back(source_);
            return;
        }
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
        const bool channels = arg.kind == OPENFAB_ARG_CHANNELS;
        const bool mask = arg.kind == OPENFAB_ARG_BLUE_NOISE;
        const int dimensions = blocks || channels || mask ? 2 : 1;
        Halide::ImageParam image(mask ? Halide::UInt(16) : type, dimensions, name);
        for (int d = 0; d < dimensions; ++d)
            image.dim(d).set_min(0);
        if (blocks) image.dim(0).set_extent(3);
        if (mask) shape_blue_noise(&image);
        arguments_.push_back(image);
        if (arg.kind == OPENFAB_ARG_VALUES) deferred_->set_values(image);
        if (texture) {
            context_.textures.emplace(std::pair(arg.a, arg.b), image);
        } else {
            buffers_.emplace(key, image);
        }
    }

    /// Returns the index of this lane along n; lanes past the end repeat the last one, so that no
    /// read is out of bounds.
    Expr index_along(const Halide::ImageParam& image, int dimension) const {
        if (has_list()) {
            return Halide::unsafe_promise_clamped(listed_group() / (kSide * kSide), 0,
                                                  image.dim(dimension).extent() - 1);
        }
        return Halide::min(group_ * kLanes + lane_, image.dim(dimension).extent() - 1);
    }

    /// Returns the group at this index of the list.
    Expr listed_group() const {
        const Halide::ImageParam& groups = buffers_.at({OPENFAB_ARG_GROUPS, 0, 0});
        return groups(group_);
    }

    Value load(const Key& key, Type type) const {
        if (!fields_.empty() && is_field(key[0])) {
            const auto same = [&](const openfab_arg& arg) {
                return Key{arg.kind, arg.a, arg.b} == key;
            };
            const auto field = std::ranges::find_if(fields_, same) - fields_.begin();
            const Expr bits = nearest_(lane_, static_cast<int>(field), group_);
            return from_storage(type, Halide::reinterpret(storage_type(type), bits));
        }
        if (key[0] == OPENFAB_ARG_FRACTION)
            return convert({Type::kInt, Halide::cast<int32_t>(normalised_->fraction(key[1]))},
                           type);
        if (auto scalar = scalars_.find(key); scalar != scalars_.end()) {
            return from_storage(type, scalar->second);
        }
        const Halide::ImageParam& image = buffers_.at(key);
        if (has_list()) {
            // The list names groups that the buffers hold.
            const Expr group = Halide::unsafe_promise_clamped(listed_group(), 0,
                                                              image.dim(0).extent() / kLanes - 1);
            return from_storage(type, image(group * kLanes + lane_));
        }
        return from_storage(type, image(index_along(image, 0)));
    }

    /// Returns the part-relative index of the voxel along an axis.
    Value voxel_index(int32_t axis) const {
        const Halide::ImageParam& blocks = buffers_.at({OPENFAB_ARG_BLOCKS, 0, 0});
        const std::array<Expr, 3> axes = {listed_group() % kSide, listed_group() / kSide % kSide,
                                          lane_};
        return Value{Type::kInt, blocks(axis, index_along(blocks, 1))} +
               Value{Type::kInt, axes[axis]};
    }

    /// Returns float(index) + 0.5 of the voxel, or of the first or last voxel of the block.
    Value voxel_coord(const ir::Instr& instr) const {
        const Halide::ImageParam& blocks = buffers_.at({OPENFAB_ARG_BLOCKS, 0, 0});
        Value index{Type::kInt, blocks(instr.a, index_along(blocks, 1))};
        if (instr.kind == ir::kVoxelCoord) {
            index = voxel_index(instr.a);
        } else if (instr.kind == ir::kVoxelCoordHi) {
            const Value size{Type::kInt, scalars_.at({OPENFAB_ARG_BLOCK_SIZE, 0, 0})};
            index = index + (size - constant(1));
        }
        return convert(index, Type::kFloat) + constant(0.5f);
    }

    /// Returns the threshold that the mask of a face has at the voxel. Its column is a row of the
    /// mask's table, from the pixel of the column's lowest voxel on.
    Value blue_noise(int32_t face) const {
        const Halide::ImageParam& blocks = buffers_.at({OPENFAB_ARG_BLOCKS, 0, 0});
        std::array<Expr, 3> lowest;
        for (int32_t axis = 0; axis < 3; ++axis) {
            const Value in_part = axis == 2
                                      ? Value{Type::kInt, blocks(axis, index_along(blocks, 1))}
                                      : voxel_index(axis);
            lowest.at(static_cast<size_t>(axis)) =
                (in_part + Value{Type::kInt, scalars_.at({OPENFAB_ARG_GRID, axis, 0})}).expr;
        }
        return {Type::kInt,
                blue_noise_threshold(buffers_.at({OPENFAB_ARG_BLUE_NOISE, face == 0 ? 0 : 1, 0}),
                                     face, scalars_.at({OPENFAB_ARG_GRID, OPENFAB_GRID_SEED, 0}),
                                     lowest, lane_)};
    }

    Value input(const ir::Instr& instr) const {
        if (instr.kind == OPENFAB_ARG_BLUE_NOISE) return blue_noise(instr.a);
        if (instr.kind == ir::kVoxelIndex) {
            return voxel_index(instr.a) +
                   Value{Type::kInt, scalars_.at({OPENFAB_ARG_GRID, instr.a, 0})};
        }
        if (instr.kind >= ir::kVoxelCoord) return voxel_coord(instr);
        return load({instr.kind, instr.a, instr.b}, instr.type);
    }

    /// Computes all values of the stage. `name`: of the Funcs that they are stored in.
    void lower_values(const char* name) {
        values_name_ = name;
        chunk_.clear();
        values_.clear();
        chunks_ = 0;
        const std::vector<bool> live = ir::live_values(*stage_);
        const std::vector<size_t> last_use = last_uses(live);
        const size_t last_picture = last_picture_sample(live);
        values_.resize(stage_->instrs.size());
        for (size_t id = 0; id < stage_->instrs.size(); ++id) {
            const Op op = stage_->instrs[id].op;
            if (!live[id] || values_[id].expr.defined()) continue;
            const bool is_sample = op == Op::kSample || op == Op::kSampleBound;
            context_.feeds_sample = id <= last_picture;
            if (is_sample && chunk_.size() >= kMostComputedTwice) store_chunk(id, last_use);
            if (op == Op::kInput) {
                values_[id] = input(stage_->instrs[id]);
            } else if (op == Op::kSample) {
                lower_sample_group(id, live);
            } else if (op == Op::kSampleBound) {
                lower_bound_pair(id, live);
            } else if (op != Op::kConst) {
                chunk_.push_back(id);
            }
        }
    }

    /// Returns the last lookup in a picture; 0 (never a lookup) if there is none.
    size_t last_picture_sample(const std::vector<bool>& live) const {
        size_t out = 0;
        for (size_t id = 0; id < stage_->instrs.size(); ++id) {
            const ir::Instr& instr = stage_->instrs[id];
            if (live[id] && instr.op == Op::kSample && !is_volume_sample(instr.args.size()))
                out = id;
        }
        return out;
    }

    /// Finds the last instruction that uses each value; past the end for outputs.
    std::vector<size_t> last_uses(const std::vector<bool>& live) const {
        std::vector<size_t> out(stage_->instrs.size(), 0);
        for (size_t id = 0; id < stage_->instrs.size(); ++id) {
            if (!live[id]) continue;
            for (const ir::ValueId arg : stage_->instrs[id].args)
                out[arg] = id;
        }
        for (const ir::Output& output : stage_->outputs)
            out[output.value] = stage_->instrs.size();
        return out;
    }

    /// values_k: what the chunk computes and instructions from `next` on still need.
    void store_chunk(size_t next, const std::vector<size_t>& last_use) {
        std::vector<size_t> kept;
        std::vector<Expr> stored;
        for (const size_t id : chunk_) {
            if (last_use[id] < next) continue;
            kept.push_back(id);
            stored.push_back(to_storage(value(id)));
        }
        chunk_.clear();
        if (kept.empty()) return;
        const std::string name = func_name(context_, values_name_, chunks_++);
        const Halide::Func func = new_func(&context_, name, context_.vars).func;
        func(context_.vars) = Halide::Tuple(stored);
        const std::vector<Expr> here(context_.vars.begin(), context_.vars.end());
        for (size_t k = 0; k < kept.size(); ++k) {
            const Expr loaded =
                kept.size() == 1 ? Expr(func(here)) : func(here)[static_cast<int>(k)];
            values_[kept[k]] = from_storage(stage_->instrs[kept[k]].type, loaded);
        }
    }

    std::vector<Value> arguments(const ir::Instr& instr) {
        std::vector<Value> out;
        for (ir::ValueId arg : instr.args)
            out.push_back(value(arg));
        return out;
    }

    /// Returns what a Func stores that needs the value.
    Value value(size_t id) {
        return deferred_->value(*stage_, values_name_, static_cast<ir::ValueId>(id), values_);
    }

    /// Lowers channels read at one coordinate together: they share footprint, taps and addresses.
    void lower_sample_group(size_t id, const std::vector<bool>& live) {
        const ir::Instr& instr = stage_->instrs[id];
        std::vector<size_t> members;
        std::vector<int32_t> channels;
        for (size_t other = id;
             other < stage_->instrs.size() && members.size() < texture::kMaxSampleResults;
             ++other) {
            const ir::Instr& candidate = stage_->instrs[other];
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
        const ir::Instr& instr = stage_->instrs[id];
        const std::array<Value, 2> ends =
            lower_sample_bound(&context_, instr.a, instr.b, arguments(instr));
        for (size_t other = id; other < stage_->instrs.size(); ++other) {
            const ir::Instr& candidate = stage_->instrs[other];
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

    /// Lanes in order, and as many groups as are listed.
    static void shape_columns(const std::vector<Halide::OutputImageParam>& buffers) {
        for (Halide::OutputImageParam buffer : buffers)
            buffer.dim(0).set_stride(1);
        // Halide takes the extents of all outputs from the first.
        Halide::OutputImageParam first = buffers[0];
        first.dim(0).set_bounds(0, kLanes);
        first.dim(1).set_min(0);
    }

    void define_outputs(Kernel* kernel) {
        if (args_.packed) return define_packed(kernel);
        std::vector<Expr> results;
        for (const ir::Output& output : stage_->outputs) {
            const Expr result = to_storage(value(output.value));
            results.push_back(kind_ == ir::StageKind::kVolumeDemand ? Halide::cast<uint8_t>(result)
                                                                    : result);
        }
        Halide::Func result(names_.result);
        result(context_.vars) = Halide::Tuple(results);
        const NamedFunc result_named = named(names_.result, result, context_.vars);
        result.bound(lane_, 0, kLanes);
        if (is_slab()) {
            define_slab(result, results.size(), kernel);
        } else if (has_list()) {
            kernel->output = result;
            shape_columns(result.output_buffers());
            for (auto& buffer : result.output_buffers())
                buffer.dim(1).set_stride(kLanes);
        } else {
            Halide::Func store("store");
            std::vector<Expr> copies;
            const std::vector<Expr> from = {n_ % kLanes, n_ / kLanes};
            for (size_t k = 0; k < results.size(); ++k)
                copies.push_back(element(result, from, k));
            store(n_) = Halide::Tuple(copies);
            // The lanes are always computed together: they share the loop over taps.
            store.output_buffers()[0].dim(0).set_min(0);
            kernel->output = store;
            kernel->funcs.push_back(named("store", store, {n_}));
        }
        kernel->funcs.push_back(result_named);
        kernel->funcs.insert(kernel->funcs.end(), sample_funcs_.rbegin(), sample_funcs_.rend());
    }

    /// Stores all results in one buffer, by number.
    void define_packed(Kernel* kernel) {
        const auto count = static_cast<int>(stage_->outputs.size());
        std::vector<ir::ValueId> ids;
        for (const ir::Output& output : stage_->outputs)
            ids.push_back(output.value);
        Halide::Func result(names_.result);
        const std::vector<Var> vars = {lane_, output_, group_};
        result(vars) = deferred_->one_of(*stage_, values_name_, ids, values_, output_);
        result.bound(lane_, 0, kLanes).bound(output_, 0, count);
        const NamedFunc result_named = named(names_.result, result, vars);
        if (is_slab()) {
            define_slab(result, static_cast<size_t>(count), kernel);
        } else if (has_list()) {
            kernel->output = result;
            shape_packed(result.output_buffer(), count);
        } else {
            Halide::Func store("store");
            store(n_, output_) = result(n_ % kLanes, output_, n_ / kLanes);
            // All results of a group are there before the first is stored.
            store.bound(output_, 0, count).reorder(output_, n_);
            store.output_buffer().dim(0).set_min(0);
            store.output_buffer().dim(1).set_bounds(0, count);
            kernel->output = store;
            kernel->funcs.push_back(named("store", store, {n_, output_}));
        }
        kernel->funcs.push_back(result_named);
        kernel->funcs.insert(kernel->funcs.end(), sample_funcs_.rbegin(), sample_funcs_.rend());
    }

    /// Lanes in order, every result of as many groups as are listed.
    static void shape_packed(Halide::OutputImageParam buffer, int count) {
        buffer.dim(0).set_stride(1).set_bounds(0, kLanes);
        buffer.dim(1).set_bounds(0, count);
        buffer.dim(2).set_min(0);
    }

    /// Asks for what the stage reads of the nearest surface point, where the stage of demand says.
    void define_nearest() {
        if (fields_.empty()) return;
        Expr wanted = Halide::cast<uint8_t>(1);
        if (demand_ != nullptr) {
            std::swap(stage_, demand_);
            lower_values("condition");
            wanted = Halide::cast<uint8_t>(to_storage(value(stage_->outputs[0].value)));
            std::swap(stage_, demand_);
        }
        const Halide::Func demand = new_func(&context_, "demand", context_.vars).func;
        demand(context_.vars) = wanted;
        const Var field("field");
        const std::vector<Var> vars = {lane_, field, group_};
        nearest_ = new_func(&context_, "nearest", vars).func;
        nearest_.define_extern("openfab_nearest", {demand, Expr(source_)}, Halide::Float(32), vars,
                               Halide::NameMangling::C);
        // As of all extern stages and what they read, see lower_sample.
        for (Halide::Func f : {demand, nearest_})
            f.bound(lane_, 0, kLanes).compute_root();
        nearest_.bound(field, 0, static_cast<int>(fields_.size()));
    }

    /// Makes codes and fractions of the stage's amounts.
    void define_slab(Halide::Func weights, size_t slots, Kernel* kernel) {
        weights.compute_root();
        Halide::ImageParam channels = buffers_.at({OPENFAB_ARG_CHANNELS, 0, 0});
        const Expr count = static_cast<int>(slots);
        shape_channels(&channels, count);
        const Var slot("slot");
        Halide::Func amounts("amounts");
        if (args_.packed) {
            const Expr bits = weights(lane_, slot, group_);
            amounts(lane_, slot, group_) = Halide::reinterpret(Halide::Float(32), bits);
            amounts.bound(slot, 0, count);
        } else {
            Expr amount = element(weights, {lane_, group_}, slots - 1);
            for (size_t k = slots - 1; k-- > 0;) {
                amount = Halide::select(slot == static_cast<int>(k),
                                        element(weights, {lane_, group_}, k), amount);
            }
            amounts(lane_, slot, group_) = amount;
            amounts.bound(slot, 0, count).unroll(slot);
        }
        amounts.compute_root().store_in(Halide::MemoryType::Stack);
        const Normalised normalised = normalise(amounts, count, channels, lane_, group_);
        std::vector<NamedFunc> rule;
        const std::optional<Expr> choice = define_choice(normalised, slots, &rule);
        Halide::Func slab("slab");
        if (args_.packed) {
            define_packed_slab(normalised, choice, static_cast<int>(slots), slab);
        } else {
            std::vector<Expr> results = {normalised.code, normalised.unusable};
            for (size_t channel = 0; channel <= slots; ++channel)
                results.push_back(normalised.fraction(static_cast<int>(channel)));
            if (choice) results.push_back(*choice);
            slab(lane_, group_) = Halide::Tuple(results);
        }
        slab.bound(lane_, 0, kLanes);
        // A split by a factor of this needs no tail; for one, Halide makes the code of a batch twice,
        // which takes twice as long to compile.
        slab.align_extent(group_, OPENFAB_LISTED_COLUMNS);
        std::vector<Halide::OutputImageParam> buffers = slab.output_buffers();
        kernel->output = slab;
        if (args_.packed) {
            shape_packed(buffers[0], static_cast<int>(args_.outputs.size()));
            kernel->funcs.push_back(named("slab", slab, {lane_, output_, group_}));
        } else {
            shape_columns(buffers);
            // Fractions go where the runtime keeps those of all materials.
            for (size_t k = 0; k < 2; ++k)
                buffers[k].dim(1).set_stride(kLanes);
            kernel->funcs.push_back(named("slab", slab, context_.vars));
        }
        kernel->funcs.insert(kernel->funcs.end(), rule.rbegin(), rule.rend());
        kernel->funcs.insert(kernel->funcs.end(), normalised.funcs.begin(), normalised.funcs.end());
        kernel->funcs.push_back(named("amounts", amounts, {lane_, slot, group_}));
    }

    /// Results in the order of the arguments, of 16 bits each.
    void define_packed_slab(const Normalised& normalised, const std::optional<Expr>& choice,
                            int slots, Halide::Func slab) const {
        constexpr int kBefore = 2;
        const int channels = slots + 1, results = kBefore + channels + (choice ? 1 : 0);
        const Expr channel = Halide::clamp(output_ - kBefore, 0, slots);
        const auto bits = [](const Expr& e) { return Halide::cast<uint16_t>(e); };
        Expr value = bits(normalised.fraction(channel));
        if (choice)
            value =
                Halide::select(Halide::likely(output_ < kBefore + channels), value, bits(*choice));
        value = Halide::select(
            Halide::likely(output_ >= kBefore), value,
            Halide::select(output_ == 0, bits(normalised.code), bits(normalised.unusable)));
        slab(lane_, output_, group_) = value;
        slab.bound(output_, 0, results);
    }

    /// Defines the code that the dither rule chooses, if there is one: that of the fraction which
    /// it names, where that is above 0, else of the largest. So a fraction of 0 is never chosen.
    std::optional<Expr> define_choice(const Normalised& normalised, size_t slots,
                                      std::vector<NamedFunc>* funcs) {
        if (dither_ == nullptr) return std::nullopt;
        normalised_ = &normalised;
        context_.funcs = funcs;
        std::swap(stage_, dither_);
        lower_values("choice");
        const Expr number = to_storage(value(stage_->outputs[0].value));
        std::swap(stage_, dither_);
        Expr code = normalised.largest();
        if (args_.packed) {
            const Expr channel = Halide::clamp(number, 0, static_cast<int>(slots));
            const Expr present = normalised.fraction(channel) > Halide::cast<uint16_t>(0);
            code = Halide::select(number == channel && present, normalised.material(channel), code);
        } else {
            for (int channel = 0; channel <= static_cast<int>(slots); ++channel) {
                const Expr present = normalised.fraction(channel) > Halide::cast<uint16_t>(0);
                code = Halide::select(number == channel && present, normalised.material(channel),
                                      code);
            }
        }
        const Halide::Func choice = new_func(&context_, "choice", context_.vars).func;
        context_.funcs = &sample_funcs_;
        choice(context_.vars) = Halide::cast<uint8_t>(code);
        normalised_ = nullptr;
        return choice(lane_, group_);
    }

    const ir::StageKind kind_;
    const ir::Stage* stage_;                  ///< that is lowered
    const ir::Stage* demand_;                 ///< of a slab kernel; may be null
    const ir::Stage* dither_;                 ///< likewise
    const Normalised* normalised_ = nullptr;  ///< while the rule is lowered
    const KernelArgs args_;
    const StageNames names_;
    const Var n_{"n"}, output_{"output"}, lane_, group_;
    LoweringContext context_;
    std::vector<NamedFunc> sample_funcs_;  ///< producers first
    const std::vector<openfab_arg> fields_;
    Halide::Func nearest_;         ///< of a slab kernel with fields
    Halide::Param<void*> source_;  ///< likewise
    std::map<Key, Halide::Param<>> scalars_;
    std::map<Key, Halide::ImageParam> buffers_;
    std::vector<Halide::Argument> arguments_;
    const char* values_name_ = nullptr;
    std::vector<Value> values_;  ///< what Halide sees; undefined: deferred
    const std::shared_ptr<Deferred> deferred_ = std::make_shared<Deferred>();
    std::vector<size_t> chunk_;  ///< values not stored in a Func yet
    int32_t chunks_ = 0;
};

}  // namespace

const char* kernel_name(ir::StageKind kind) {
    return names_of(kind).kernel;
}

Kernel make_kernel(const ir::Stage& stage, const SlabStages& inside, openfab_isa isa) {
    return StageLowering(stage, inside, isa).run();
}

}  // namespace openfab::lower
