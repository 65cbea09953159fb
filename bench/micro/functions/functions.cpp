// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Measures the cost of functions in a volume kernel: a marble of four octaves of noise and a sine
// against the same arithmetic written by hand in Halide, in interleaved rounds; then each function
// alone. One thread, AVX2; minimum over all rounds.

#include <Halide.h>
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <functional>
#include <limits>
#include <numeric>

#include "abi/kernel_call.h"
#include "bench/micro/functions/by_hand.h"
#include "bench/micro/load_fablet.h"
#include "compiler/functions/perlin.h"
#include "compiler/functions/trigonometry.h"
#include "compiler/lower/algorithm/args.h"
#include "compiler/lower/code/compile.h"
#include "compiler/lower/code/load_code.h"
#include "compiler/passes/pipeline.h"

namespace openfab::bench {

namespace {

using Halide::Expr;
using Halide::Func;
using Halide::Var;

constexpr int32_t kBlocks = 512;
constexpr int32_t kVoxels = kBlocks * 512;
constexpr int kRounds = 40;

/// Steps of 0.05 mm along the axes; blocks in a cube.
struct Places {
    Places() : blocks(3 * kBlocks), frame(OPENFAB_FRAME_COUNT, 0.0f) {
        for (int32_t n = 0; n < kBlocks; ++n) {
            blocks[static_cast<size_t>(3 * n)] = 8 * (n % 8);
            blocks[static_cast<size_t>(3 * n + 1)] = 8 * (n / 8 % 8);
            blocks[static_cast<size_t>(3 * n + 2)] = 8 * (n / 64);
        }
        frame[OPENFAB_FRAME_STEP_I] = 0.05f;
        frame[OPENFAB_FRAME_STEP_J + 1] = 0.05f;
        frame[OPENFAB_FRAME_STEP_K + 2] = 0.05f;
    }
    std::vector<int32_t> blocks;
    std::vector<float> frame;
};

double seconds(const std::function<void()>& work) {
    const auto begin = std::chrono::steady_clock::now();
    work();
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

/// The amounts of a volume stage from source, ready to run: as the one segment of a stage that is
/// cut, whose kernel does not normalise them.
class Compiled {
  public:
    Compiled(const std::string& declarations, const std::string& value, const Places& places) {
        const std::string text = fmt::format(
            "fablet A {{ @uniform {{ Material a, b; }} {}\n"
            "@Volume(@varying {{ VolumeAttributes attr }}) {{ float3 p = attr.voxelCenter; "
            "float v = {}; MaterialComposition mc; mc.Set(a, v); mc.Set(b, 1 - v); return mc; }} "
            "}}",
            declarations, value);
        const passes::PipelineResult made = passes::run_pipeline(load_module(text).fablets[0], {});
        const passes::SegmentedStage cut = passes::cut_segments(made.stages.volume);
        lower::KernelRequest request;
        request.stage = &cut.kernels[0];
        request.function = "amounts";
        request.isa = OPENFAB_ISA_AVX2;
        const auto object = lower::compile_object(request);
        if (std::holds_alternative<lower::Fault>(object)) std::exit(4);
        auto loaded = lower::load_code(std::get<lower::CompiledKernel>(object).code,
                                       request.function + "_argv");
        if (std::holds_alternative<std::string>(loaded)) std::exit(4);
        code_ = std::get<lower::LoadedKernel>(std::move(loaded));
        args_ = lower::collect_args(cut.kernels[0]).all();
        const openfab_kernel kernel{
            {nullptr, code_.function}, static_cast<int32_t>(args_.size()), args_.data()};
        columns_.resize(kVoxels / 8);
        std::iota(columns_.begin(), columns_.end(), 0);
        call_.emplace(kernel, OPENFAB_ISA_AVX2);
        for (int32_t k = 0; k < kernel.arg_count; ++k) {
            const openfab_arg& arg = kernel.args[k];
            if (arg.kind == OPENFAB_ARG_FRAME) {
                call_->set(k, &places.frame[arg.a]);
            } else if (arg.kind == OPENFAB_ARG_BLOCKS) {
                blocks_.set_dense(abi::halide_type(arg), places.blocks.data(), {3, kBlocks});
                call_->set(k, blocks_.raw());
            } else if (arg.kind == OPENFAB_ARG_GROUPS) {
                groups_.set_dense(abi::halide_type(arg), columns_.data(), {kVoxels / 8});
                call_->set(k, groups_.raw());
            } else {
                const auto slot = static_cast<size_t>(arg.a);
                weights_[slot].resize(kVoxels);
                outputs_[slot].set_columns(abi::halide_type(arg), weights_[slot].data(),
                                           kVoxels / 8);
                call_->set(k, outputs_[slot].raw());
            }
        }
    }
    double run() {
        return seconds([&] {
            if (!call_->run().ok()) std::exit(4);
        });
    }
    const std::vector<float>& weights() const { return weights_[0]; }

  private:
    lower::LoadedKernel code_;
    std::vector<openfab_arg> args_;
    std::vector<int32_t> columns_;
    std::optional<abi::KernelCall> call_;
    abi::KernelBuffer blocks_, groups_;
    std::array<abi::KernelBuffer, 2> outputs_;
    std::array<std::vector<float>, 2> weights_;
};

/// The marble below, written in Halide: a Func for each octave, all for one column of voxels.
class HandWritten {
  public:
    HandWritten(const Places& places, bool strict) : weights_{buffer(), buffer()} {
        Halide::Buffer<int32_t> blocks(const_cast<int32_t*>(places.blocks.data()), 3, kBlocks);
        const Halide::Target target =
            strict ? target_.with_feature(Halide::Target::StrictFloat) : target_;
        const std::vector<Var> vars = {z_, x_, y_, n_};
        const auto frame = [&](int32_t k) {
            Halide::Param<float> param;
            param.set(places.frame[k]);
            return Expr(param);
        };
        Func point("point");
        std::vector<Expr> p;
        const std::array<Var, 3> axes = {x_, y_, z_};
        std::array<Expr, 3> index;
        for (int32_t k = 0; k < 3; ++k) {
            index[k] = Halide::cast<float>(blocks(k, n_) + axes[k]) + 0.5f;
        }
        for (int32_t k = 0; k < 3; ++k) {
            p.push_back(frame(OPENFAB_FRAME_CENTER + k) +
                        (frame(OPENFAB_FRAME_ORIGIN + k) +
                         frame(OPENFAB_FRAME_STEP_I + k) * index[0] +
                         frame(OPENFAB_FRAME_STEP_J + k) * index[1] +
                         frame(OPENFAB_FRAME_STEP_K + k) * index[2]));
        }
        point(vars) = Halide::Tuple(p);
        const std::vector<Expr> here(vars.begin(), vars.end());
        std::vector<Func> octaves;
        ByHand::F sum{Expr(0.0f)};
        float scale = 1.0f;
        for (uint32_t k = 0; k < 4; ++k, scale *= 2.0f) {
            std::array<functions::Cell<ByHand>, 3> cells;
            for (size_t axis = 0; axis < 3; ++axis) {
                const ByHand::F x{point(here)[static_cast<int>(axis)]};
                cells[axis] = functions::cell_of<ByHand>(x * 0.8f * scale);
            }
            Func octave(fmt::format("octave_{}", k));
            const uint32_t seed = functions::seed_key<functions::Plain>(k * 0x9e3779b9u);
            octave(vars) = functions::PerlinNoise<ByHand, 3>::keyed(cells, {literal(seed)}, 0).e;
            octaves.push_back(octave);
            sum = sum + ByHand::F{octave(here)} * (1.0f / scale);
        }
        const ByHand::F wave =
            functions::sin<ByHand>(ByHand::F{point(here)[0]} * 3.0f + sum * 4.0f);
        const Expr v = wave.e * 0.5f + 0.5f;
        Func result("marble");
        result(vars) = Halide::Tuple(v, 1.0f - v);
        result.bound(z_, 0, 8).bound(x_, 0, 8).bound(y_, 0, 8).vectorize(z_);
        for (auto& out : result.output_buffers()) {
            out.dim(1).set_stride(8);
            out.dim(2).set_stride(64);
        }
        point.compute_at(result, x_).vectorize(z_);
        for (Func& octave : octaves)
            octave.compute_at(result, x_).vectorize(z_);
        result.compile_jit(target);
        result_ = result;
    }
    double run() {
        return seconds([&] { result_.realize({weights_[0], weights_[1]}); });
    }
    const float* weights() const { return weights_[0].data(); }

  private:
    static Halide::Buffer<float> buffer() { return Halide::Buffer<float>(8, 8, 8, kBlocks); }

    const Halide::Target target_{Halide::Target::Linux,
                                 Halide::Target::X86,
                                 64,
                                 {Halide::Target::SSE41, Halide::Target::AVX, Halide::Target::AVX2,
                                  Halide::Target::NoAsserts, Halide::Target::NoBoundsQuery}};
    Var z_{"z"}, x_{"x"}, y_{"y"}, n_{"n"};
    Func result_;
    std::array<Halide::Buffer<float>, 2> weights_;
};

void marble(const Places& places) {
    Compiled compiled("", "sin(p.x * 3 + fbm(p * 0.8, 4) * 4) * 0.5 + 0.5", places);
    HandWritten strict(places, true);
    HandWritten loose(places, false);
    std::array<double, 3> least;
    least.fill(std::numeric_limits<double>::max());
    for (int round = 0; round < kRounds; ++round) {
        least[0] = std::min(least[0], compiled.run());
        least[1] = std::min(least[1], strict.run());
        least[2] = std::min(least[2], loose.run());
    }
    int64_t differ = 0;
    for (size_t k = 0; k < kVoxels; ++k)
        differ += compiled.weights()[k] != strict.weights()[k] ? 1 : 0;
    const auto ns = [](double time) { return time / kVoxels * 1e9; };
    fmt::print("marble, 4 octaves of noise and a sine, ns a voxel (AVX2, one thread)\n");
    fmt::print("  compiled from OpenFL             {:7.2f}\n", ns(least[0]));
    fmt::print(
        "  by hand, strict_float            {:7.2f}   ratio {:.3f}, {} of {} voxels differ\n",
        ns(least[1]), least[0] / least[1], differ, kVoxels);
    fmt::print("  by hand, without                 {:7.2f}   ratio {:.3f}\n", ns(least[2]),
               least[0] / least[2]);
}

void each_function(const Places& places) {
    const std::array<const char*, 30> values = {"p.x",
                                                "sin(p.x)",
                                                "cos(p.x)",
                                                "tan(p.x)",
                                                "asin(p.x)",
                                                "acos(p.x)",
                                                "atan(p.x)",
                                                "atan2(p.x, p.y)",
                                                "sinh(p.x)",
                                                "cosh(p.x)",
                                                "tanh(p.x)",
                                                "exp(p.x)",
                                                "exp2(p.x)",
                                                "log(p.x)",
                                                "log2(p.x)",
                                                "log10(p.x)",
                                                "pow(p.x, p.y)",
                                                "cbrt(p.x)",
                                                "hash(p)",
                                                "noise(p.x)",
                                                "noise(p.xy)",
                                                "noise(p)",
                                                "noise(float4(p, p.x))",
                                                "pnoise(p, int3(4, 4, 4))",
                                                "simplex(p.xy)",
                                                "simplex(p)",
                                                "simplex(float4(p, p.x))",
                                                "cellular(p.xy).x",
                                                "cellular(p).x",
                                                "dot(noise_gradient(p), p)"};
    fmt::print("\neach function, ns a voxel beyond a voxel without; compile time of the fablet\n");
    double base = 0;
    for (const char* value : values) {
        std::unique_ptr<Compiled> compiled;
        const double build =
            seconds([&] { compiled = std::make_unique<Compiled>("", value, places); });
        double least = std::numeric_limits<double>::max();
        for (int round = 0; round < kRounds; ++round)
            least = std::min(least, compiled->run());
        const double ns = least / kVoxels * 1e9;
        if (base == 0) base = ns;
        fmt::print("  {:28} {:7.2f}   {:5.2f} s\n", value, ns - base, build);
    }
}

}  // namespace

}  // namespace openfab::bench

int main(int argc, char** argv) {
    const openfab::bench::Places places;
    openfab::bench::marble(places);
    if (argc > 1 && std::string(argv[1]) == "--marble") return 0;
    openfab::bench::each_function(places);
    return 0;
}
