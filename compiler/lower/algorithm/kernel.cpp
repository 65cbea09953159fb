// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/lower/algorithm/kernel.h"

#include <fmt/format.h>

#include <memory>
#include <optional>

#include "compiler/lower/algorithm/kernel_inputs.h"
#include "compiler/lower/algorithm/normalise.h"
#include "compiler/lower/algorithm/sample_parts.h"
#include "compiler/lower/algorithm/value_lowering.h"

namespace openfab::lower {

namespace {

using Halide::Expr;
using Halide::Var;

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
          inputs_(stage.kind,
                  is_slab() && !inside.after_segments ? collect_fields(stage)
                                                      : std::vector<openfab_arg>(),
                  lane_, group_) {
        context_.isa = isa;
    }

    Kernel run() {
        context_.funcs = &sample_funcs_;
        context_.vars = {lane_, group_};
        for (const openfab_arg& arg : args_.inputs)
            inputs_.add(arg, &context_, deferred_.get());
        if (is_slab()) define_nearest();
        values_.run();
        Kernel kernel;
        kernel.arguments = inputs_.arguments();
        kernel.deferred = deferred_;
        define_outputs(&kernel);
        return kernel;
    }

  private:
    bool is_slab() const { return kind_ == ir::StageKind::kVolume; }
    bool has_list() const { return lists_groups(kind_); }

    ValueLowering lowering(const ir::Stage& stage, const char* name) {
        return {stage, name, inputs_, &context_, deferred_.get()};
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
            const Expr result = to_storage(values_.value(output.value));
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
        result(vars) = values_.one_of(ids, output_);
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
        if (inputs_.fields().empty()) return;
        Expr wanted = Halide::cast<uint8_t>(1);
        if (demand_ != nullptr) {
            ValueLowering condition = lowering(*demand_, "condition");
            condition.run();
            wanted = Halide::cast<uint8_t>(to_storage(condition.value(demand_->outputs[0].value)));
        }
        const Halide::Func demand = new_func(&context_, "demand", context_.vars).func;
        demand(context_.vars) = wanted;
        const Var field("field");
        const std::vector<Var> vars = {lane_, field, group_};
        Halide::Func nearest = new_func(&context_, "nearest", vars).func;
        nearest.define_extern("openfab_nearest", {demand, Expr(inputs_.nearest_source())},
                              Halide::Float(32), vars, Halide::NameMangling::C);
        // As of all extern stages and what they read, see lower_sample.
        for (Halide::Func f : {demand, nearest})
            f.bound(lane_, 0, kLanes).compute_root();
        nearest.bound(field, 0, static_cast<int>(inputs_.fields().size()));
        inputs_.set_nearest(nearest);
    }

    /// Makes codes and fractions of the stage's amounts.
    void define_slab(Halide::Func weights, size_t slots, Kernel* kernel) {
        weights.compute_root();
        Halide::ImageParam channels = inputs_.channels();
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
        inputs_.set_normalised(&normalised);
        context_.funcs = funcs;
        ValueLowering rule = lowering(*dither_, "choice");
        rule.run();
        const Expr number = to_storage(rule.value(dither_->outputs[0].value));
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
        inputs_.set_normalised(nullptr);
        return choice(lane_, group_);
    }

    const ir::StageKind kind_;
    const ir::Stage* const stage_;
    const ir::Stage* const demand_;  ///< of a slab kernel; may be null
    const ir::Stage* const dither_;  ///< likewise
    const KernelArgs args_;
    const StageNames names_;
    const Var n_{"n"}, output_{"output"}, lane_, group_;
    LoweringContext context_;
    std::vector<NamedFunc> sample_funcs_;  ///< producers first
    const std::shared_ptr<Deferred> deferred_ = std::make_shared<Deferred>();
    KernelInputs inputs_;
    ValueLowering values_ = lowering(*stage_, "values");
};

}  // namespace

const char* kernel_name(ir::StageKind kind) {
    return names_of(kind).kernel;
}

Kernel make_kernel(const ir::Stage& stage, const SlabStages& inside, openfab_isa isa) {
    return StageLowering(stage, inside, isa).run();
}

}  // namespace openfab::lower
