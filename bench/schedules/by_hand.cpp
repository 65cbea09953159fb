// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "bench/schedules/by_hand.h"

#include <Halide.h>
#include <fmt/format.h>

#include <array>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <utility>

#include "abi/stage_table.h"
#include "base/own_folder.h"
#include "bench/schedules/halide_machine.h"
#include "compiler/functions/perlin.h"
#include "compiler/functions/trigonometry.h"

namespace openfab::by_hand {

namespace {

using Halide::cast;
using Halide::Expr;
using Halide::Func;
using Halide::ImageParam;
using Halide::Param;
using Halide::Tuple;
using Halide::Var;

using M = Machine;
using Point = std::array<Real, 3>;

Real saturate(const Real& x) {
    return M::min(M::max(x, 0.0f), 1.0f);
}

Real dot(const Point& a, const Point& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/// A kernel under construction: its arguments, in the order of the ABI, and its Funcs.
class Writer {
  public:
    explicit Writer(int32_t uniforms) {
        for (int32_t k = 0; k < uniforms; ++k)
            uniforms_.push_back(add<float>(OPENFAB_ARG_UNIFORM, k));
        for (int32_t k = 0; k < OPENFAB_FRAME_VOXEL_SIZE; ++k)
            frame_.push_back(add<float>(OPENFAB_ARG_FRAME, k));
        for (const auto& [image, kind] :
             {std::pair(&blocks_, OPENFAB_ARG_BLOCKS), std::pair(&groups_, OPENFAB_ARG_GROUPS),
              std::pair(&channels_, OPENFAB_ARG_CHANNELS)}) {
            args_.push_back({kind, OPENFAB_INT, 0, 0});
            arguments_.push_back(*image);
            for (int d = 0; d < image->dimensions(); ++d)
                image->dim(d).set_min(0);
        }
        blocks_.dim(0).set_extent(3);
    }

    Real uniform(size_t k) const { return Real(uniforms_[k]); }

    /// Stores values of a voxel while its column is computed, and returns them.
    std::vector<Real> keep(const std::string& name, const std::vector<Real>& values) {
        std::vector<Expr> exprs;
        for (const Real& value : values)
            exprs.push_back(value.expr);
        Func func(name);
        func(z, column) = Tuple(exprs);
        kept_.push_back(func);
        std::vector<Real> out;
        for (size_t k = 0; k < values.size(); ++k)
            out.emplace_back(values.size() == 1 ? Expr(func(z, column))
                                                : Expr(func(z, column)[static_cast<int>(k)]));
        return out;
    }

    /// Returns the voxel's centre in the part, mm.
    Point center() {
        const Expr group = groups_(column);
        const Expr block =
            Halide::unsafe_promise_clamped(group / 64, 0, blocks_.dim(1).extent() - 1);
        const std::array<Expr, 3> in_block = {group % 8, group / 8 % 8, z};
        std::array<Real, 3> at;
        for (int axis = 0; axis < 3; ++axis)
            at[axis] = Real(cast<float>(blocks_(axis, block) + in_block[axis])) + 0.5f;
        Point p;
        for (size_t axis = 0; axis < 3; ++axis) {
            const auto of = [&](size_t value) { return Real(Expr(frame_[value + axis])); };
            p[axis] = at[0] * of(OPENFAB_FRAME_STEP_I) + at[1] * of(OPENFAB_FRAME_STEP_J) +
                      at[2] * of(OPENFAB_FRAME_STEP_K) + of(OPENFAB_FRAME_ORIGIN) +
                      of(OPENFAB_FRAME_CENTER);
        }
        const std::vector<Real> kept = keep("center", {p[0], p[1], p[2]});
        return {kept[0], kept[1], kept[2]};
    }

    /// Makes codes and fractions of the amounts, and the kernel of all that.
    Result<HandKernel> finish(const std::vector<Real>& amounts, openfab_isa isa);

    const Var z{"z"}, column{"column"};

  private:
    template <typename T>
    Expr add(openfab_arg_kind kind, int32_t a) {
        const Param<T> param(fmt::format("argument_{}_{}", static_cast<int>(kind), a));
        args_.push_back({kind, OPENFAB_FLOAT, a, 0});
        arguments_.push_back(param);
        return param;
    }

    ImageParam blocks_{Halide::Int(32), 2, "blocks"}, groups_{Halide::Int(32), 1, "groups"},
        channels_{Halide::Int(32), 2, "channels"};
    std::vector<Expr> uniforms_, frame_;
    std::vector<openfab_arg> args_;
    std::vector<Halide::Argument> arguments_;
    std::vector<Func> kept_;
};

Halide::Target target_of(openfab_isa isa) {
    using Halide::Target;
    Target target(Target::Linux, Target::X86, 64,
                  {Target::SSE41, Target::StrictFloat, Target::NoRuntime, Target::NoBoundsQuery,
                   Target::NoAsserts});
    if (isa >= OPENFAB_ISA_AVX2) target.set_features({Target::AVX, Target::AVX2});
    if (isa == OPENFAB_ISA_AVX512) target.set_features({Target::AVX512, Target::AVX512_Skylake});
    return target;
}

/// The amounts of a column as fractions of 65535: written out for a number of slots that is known.
struct Mix {
    Expr code, unusable;
    std::vector<Expr> fractions;
};

Mix normalise(const std::vector<Expr>& given, const ImageParam& channels) {
    const auto count = static_cast<int>(given.size());
    const Expr infinity = std::numeric_limits<float>::infinity();
    const auto exactly = [](const Expr& comparison) { return Halide::strict_float(comparison); };
    std::vector<Expr> amounts;
    Expr total = 0.0f, unusable = cast<uint16_t>(0);
    for (const Expr& amount : given) {
        amounts.push_back(Halide::select(exactly(amount > 0.0f), amount, 0.0f));
        total = total + amounts.back();
        unusable = unusable + cast<uint16_t>(!exactly(amounts.back() == amount));
    }
    // So that no sum overflows, and that an infinite amount outweighs every finite one.
    const Expr scale = Halide::select(exactly(total > 0x1p127f), 0x1p-64f, 1.0f);
    for (Expr& amount : amounts)
        amount = Halide::select(exactly(amount == infinity), 0x1p100f, amount * scale);
    std::vector<Expr> sums = {0.0f};
    Expr whole = 0.0f;
    const auto material = [&](int c) -> Expr { return channels(OPENFAB_CHANNEL_MATERIAL, c); };
    for (int c = 1; c <= count; ++c) {
        Expr own = amounts.back();
        for (int slot = count - 1; slot-- > 0;)
            own = Halide::select(channels(OPENFAB_CHANNEL_SLOT, c) == slot, amounts[slot], own);
        sums.push_back(Halide::select(channels(OPENFAB_CHANNEL_JOINS, c) != 0, sums.back(), 0.0f) +
                       own);
        whole = whole + Halide::select(material(c) >= 0, sums.back(), 0.0f);
    }
    const Expr solid = exactly(whole > 0.0f);
    std::vector<Expr> rounded;
    Expr rest = 65535, most = -1, largest = 0;
    for (int c = 0; c <= count; ++c) {
        const Expr share =
            c == 0
                ? Expr(0)
                : cast<int32_t>(
                      65535.0f * (Halide::select(material(c) >= 0, sums[c], 0.0f) / whole) + 0.5f);
        rounded.push_back(Halide::select(solid, share, Halide::select(material(c) == 0, 65535, 0)));
        rest = rest - rounded.back();
        largest = Halide::select(rounded.back() > most, material(c), largest);
        most = Halide::max(rounded.back(), most);
    }
    Mix out;
    out.code = cast<uint8_t>(Halide::select(rest + most == 65535, largest, OPENFAB_CODE_MIXED));
    out.unusable = unusable;
    for (int c = 0; c <= count; ++c) {
        out.fractions.push_back(
            cast<uint16_t>(Halide::select(material(c) == largest, rest + most, rounded[c])));
    }
    return out;
}

Result<HandKernel> Writer::finish(const std::vector<Real>& amounts, openfab_isa isa) {
    Func weights("weights"), slab("slab");
    std::vector<Expr> exprs, given;
    for (const Real& amount : amounts)
        exprs.push_back(amount.expr);
    weights(z, column) = Tuple(exprs);
    for (size_t k = 0; k < amounts.size(); ++k)
        given.push_back(weights(z, column)[static_cast<int>(k)]);
    const auto count = static_cast<int32_t>(amounts.size());
    channels_.dim(0).set_bounds(0, OPENFAB_CHANNEL_ROWS).set_stride(1);
    channels_.dim(1).set_bounds(0, count + 1).set_stride(OPENFAB_CHANNEL_ROWS);
    Mix mix = normalise(given, channels_);
    std::vector<Expr> results = {mix.code, mix.unusable};
    results.insert(results.end(), mix.fractions.begin(), mix.fractions.end());
    slab(z, column) = Tuple(results);
    args_.push_back({OPENFAB_ARG_CODE, OPENFAB_UINT, 0, 0});
    args_.push_back({OPENFAB_ARG_UNUSABLE, OPENFAB_UINT, 0, 0});
    for (int32_t channel = 0; channel <= count; ++channel)
        args_.push_back({OPENFAB_ARG_FRACTION, OPENFAB_UINT, channel, 0});

    std::vector<Halide::OutputImageParam> buffers = slab.output_buffers();
    for (size_t k = 0; k < buffers.size(); ++k) {
        buffers[k].dim(0).set_stride(1);
        if (k < 2) buffers[k].dim(1).set_stride(8);
    }
    // Halide takes the extents of all outputs from the first.
    buffers[0].dim(0).set_bounds(0, 8);
    buffers[0].dim(1).set_min(0);
    // A vector is a column. Amounts and codes in loops of their own over a batch, which stays in the
    // first cache; amounts of two columns at a time, codes of four.
    const Var batch("batch"), member("member");
    slab.bound(z, 0, 8).align_bounds(column, OPENFAB_LISTED_COLUMNS);
    slab.split(column, batch, member, OPENFAB_LISTED_COLUMNS, Halide::TailStrategy::GuardWithIf)
        .vectorize(z)
        .unroll(member, 4);
    weights.bound(z, 0, 8).compute_at(slab, batch).vectorize(z).unroll(column, 2);
    for (Func& func : kept_)
        func.bound(z, 0, 8).compute_at(weights, column).vectorize(z);

    const auto folder = TemporaryFolder::create();
    if (!folder) return folder.error();
    const std::string object = ((*folder)->path() / "by_hand.o").string();
    try {
        Halide::Module module = Halide::Pipeline(slab).compile_to_module(
            arguments_, "by_hand", target_of(isa), Halide::LinkageType::ExternalPlusArgv);
        module.compile({{Halide::OutputFileType::object, object}});
    } catch (const Halide::Error& error) {
        return internal_error(error.what());
    }
    std::ifstream file(object, std::ios::binary);
    const std::string code((std::istreambuf_iterator<char>(file)),
                           std::istreambuf_iterator<char>());
    auto loaded = lower::load_code(code, "by_hand_argv");
    if (const auto* fault = std::get_if<std::string>(&loaded)) return internal_error(*fault);
    return HandKernel{args_, std::get<lower::LoadedKernel>(std::move(loaded))};
}

/// Perlin's noise of one octave, whose cells and corners are kept.
Real noise(Writer* writer, const Point& p, uint32_t seed, const std::string& name) {
    using functions::Cell;
    std::array<Cell<M>, 3> cells;
    std::vector<Real> parts;
    for (size_t axis = 0; axis < 3; ++axis) {
        const Cell<M> cell = functions::cell_of<M>(p[axis]);
        parts.push_back(M::from_bits(cell.corner[0]));
        parts.push_back(cell.t);
    }
    parts = writer->keep(name + "_cells", parts);
    for (size_t axis = 0; axis < 3; ++axis) {
        const M::U key = M::bits(parts[2 * axis]);
        cells[axis] = {{key, key + 1u}, parts[2 * axis + 1]};
    }
    const uint32_t key = functions::seed_key<functions::Plain>(seed);
    return writer->keep(name, {functions::PerlinNoise<M, 3>::keyed(cells, key, 0)})[0];
}

// gallery/marble_table/marble_table.fl.
Result<HandKernel> marble_table(openfab_isa isa) {
    constexpr uint32_t kSeedStep = 0x9e3779b9u;
    Writer writer(3);
    const Real vein = writer.uniform(0), push = writer.uniform(1), grain = writer.uniform(2);
    const Point p = writer.center();
    Point q = {p[0] / grain, p[1] / grain, p[2] / grain};
    Real turbulence = 0.0f;
    float weight = 1;
    for (uint32_t octave = 0; octave < 4; ++octave) {
        const Real value = noise(&writer, q, octave * kSeedStep, fmt::format("noise_{}", octave));
        turbulence = turbulence + M::abs(value) * weight;
        weight *= 0.5f;
        for (Real& x : q)
            x = x * 2.0f;
    }
    const Real swirl = writer.keep("swirl", {push * turbulence})[0];
    const Real bands = dot(p, {0.927f, 0.325f, 0.185f}) / vein + swirl;
    const Real band = writer.keep(
        "band", {Real(0.5f) +
                 Real(0.5f) * functions::sin<M>(writer.keep("phase", {bands * 6.2831853f})[0])})[0];
    const Real lines = writer.keep("lines", {dot(p, {-0.36f, 0.93f, 0.07f}) / vein + swirl})[0];
    const Real off = M::abs(lines - M::floor(lines) - 0.5f);
    const Real t = saturate(Real(1.0f) - off / 0.05f);
    const Real dark = Real(1.0f) - band;
    const Real grey =
        writer.keep("grey", {saturate(Real(0.6f) * dark * dark * dark + Real(0.75f) * (t * t))})[0];
    return writer.finish({Real(1.0f) - grey, grey}, isa);
}

/// 0 at `from`, 1 at `to`.
Real grade(const Real& x, const Real& from, const Real& to) {
    return M::select(from == to, M::select(x < from, Real(0.0f), Real(1.0f)),
                     saturate((x - from) / (to - from)));
}

// gallery/foam/soft_toy.fl.
Result<HandKernel> soft_toy(openfab_isa isa) {
    Writer writer(5);
    const Real cell = writer.uniform(0), smallest = writer.uniform(1), largest = writer.uniform(2),
               low = writer.uniform(3), high = writer.uniform(4);
    const Point p = writer.center();
    const Real up = writer.keep("up", {grade(p[2], low, high)})[0];
    Point a, b;
    for (size_t axis = 0; axis < 3; ++axis) {
        const Real q = p[axis] / cell;
        a[axis] = (q - M::floor(q) - 0.5f) * cell;
    }
    const std::vector<Real> kept = writer.keep("from_center", {a[0], a[1], a[2]});
    for (size_t axis = 0; axis < 3; ++axis) {
        a[axis] = kept[axis];
        b[axis] = M::abs(a[axis]) - cell / 2.0f;
    }
    const Real radius = smallest + up * (largest - smallest);
    const M::B hollow = M::sqrt(M::min(dot(a, a), dot(b, b))) - radius < 0.0f;
    const Real t = writer.keep("t", {grade(p[2] + Real(0.4f) * p[0], low, high)})[0];
    const Real hue = t * t * (Real(3.0f) - Real(2.0f) * t);
    const Real soft = grade(up, 0.0f, 0.6f);
    const float pigment = 0.4f, resin = 1 - pigment;
    std::vector<Real> amounts = {Real(resin) * soft, Real(resin) * (Real(1.0f) - soft),
                                 Real(pigment) * hue, Real(pigment) * (Real(1.0f) - hue)};
    for (Real& amount : amounts)
        amount = M::select(hollow, 0.0f, amount);
    return writer.finish(amounts, isa);
}

}  // namespace

Result<HandKernel> compile(std::string_view fablet, openfab_isa isa) {
    if (fablet == "MarbleTable") return marble_table(isa);
    if (fablet == "SoftToy") return soft_toy(isa);
    return user_error(
        fmt::format("`{}` is not written by hand: MarbleTable and SoftToy are", fablet));
}

}  // namespace openfab::by_hand
