// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Texture look-ups of the volume stage: the skin of a sphere of 50 mm under a 4k picture, and of a
// card that one covers, in voxels of a J750. Coordinates and footprints are those that the queries
// would give. One thread, AVX2; batches of 16 blocks as in a print, each of which finds its inputs
// in the cache; the median of all rounds counts.

#include <fmt/format.h>

#include <time.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <numbers>
#include <numeric>
#include <random>

#include "abi/nearest_stage.h"
#include "abi/stages.h"
#include "bench/micro/load_fablet.h"
#include "texture/pyramid.h"

namespace openfab::bench {

namespace {

constexpr int32_t kBatch = 16;  // blocks in a call
constexpr int32_t kCalls = 48;  // of a round
constexpr int kRounds = 15;
constexpr int32_t kSide = 4096;  // of the picture, texels
constexpr size_t kVoxels = size_t{kBatch} * 512;
constexpr std::array<double, 3> kPitch = {25.4 / 600, 25.4 / 300, 0.027};
constexpr double kRadius = 25;  // of the sphere, mm
constexpr double kCard = 100;   // edge of the card, mm

enum Component { kU, kV, kDu, kDv = kDu + 3, kComponents = kDv + 3 };
/// uv and its changes along the voxel's axes, [component][block][512].
using Batch = std::vector<float>;

/// Longitude and latitude of a voxel's center, and their derivatives along the axes.
void on_sphere(const std::array<double, 3>& p, std::array<double, kComponents>* out) {
    const double ring2 = p[0] * p[0] + p[1] * p[1], all2 = ring2 + p[2] * p[2];
    const double ring = std::sqrt(ring2);
    (*out)[kU] = std::atan2(p[1], p[0]) / (2 * std::numbers::pi) + 0.5;
    (*out)[kV] = std::atan2(p[2], ring) / std::numbers::pi + 0.5;
    const std::array<double, 3> du = {-p[1] / ring2, p[0] / ring2, 0};
    const std::array<double, 3> dv = {-p[0] * p[2] / (ring * all2), -p[1] * p[2] / (ring * all2),
                                      ring / all2};
    for (size_t k = 0; k < 3; ++k) {
        (*out)[kDu + k] = du[k] * kPitch[k] / (2 * std::numbers::pi);
        (*out)[kDv + k] = dv[k] * kPitch[k] / std::numbers::pi;
    }
}

void on_card(const std::array<double, 3>& p, std::array<double, kComponents>* out) {
    out->fill(0);
    (*out)[kU] = p[0] / kCard;
    (*out)[kV] = p[1] / kCard;
    (*out)[kDu] = kPitch[0] / kCard;
    (*out)[kDv + 1] = kPitch[1] / kCard;
}

/// Rows of blocks along x, as they are printed: over the card, or around slices of the sphere.
std::vector<Batch> make_batches(bool sphere) {
    std::vector<Batch> batches;
    std::mt19937 random(7);
    for (int32_t call = 0; call < kCalls; ++call) {
        Batch batch(kComponents * kVoxels);
        const double z = sphere ? (call - kCalls / 2 + 0.5) / kCalls * 1.9 * kRadius : 0;
        const double ring = std::sqrt(kRadius * kRadius - z * z);
        const double turn = static_cast<double>(random() % 6283) * 1e-3;
        for (int32_t b = 0; b < kBatch; ++b) {
            // Along the ring, or along x.
            const double along = b * 8 * kPitch[0];
            const std::array<double, 3> corner = {
                sphere ? ring * std::cos(turn + along / ring) : along + 3,
                sphere ? ring * std::sin(turn + along / ring) : 2 + 0.9 * kCard * call / kCalls, z};
            for (size_t v = 0; v < 512; ++v) {
                const std::array<double, 3> p = {
                    corner[0] + kPitch[0] * static_cast<double>(v / 8 % 8),
                    corner[1] + kPitch[1] * static_cast<double>(v / 64),
                    corner[2] + kPitch[2] * static_cast<double>(v % 8)};
                std::array<double, kComponents> values;
                if (sphere) {
                    on_sphere(p, &values);
                } else {
                    on_card(p, &values);
                }
                for (size_t c = 0; c < kComponents; ++c)
                    batch[c * kVoxels + static_cast<size_t>(b) * 512 + v] =
                        static_cast<float>(values[c]);
            }
        }
        batches.push_back(std::move(batch));
    }
    return batches;
}

std::shared_ptr<const texture::Pyramid> make_picture(int32_t channels, int32_t filter) {
    std::mt19937 random(1);
    std::vector<float> texels(static_cast<size_t>(kSide) * kSide * static_cast<size_t>(channels));
    for (float& t : texels)
        t = static_cast<float>(random() >> 8) * 0x1p-24f;
    return texture::Pyramid::from_texels(kSide, kSide, channels, texels, 1, filter);
}

/// Processor time of this thread.
double processor_seconds() {
    timespec t{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) + static_cast<double>(t.tv_nsec) * 1e-9;
}

/// A volume stage whose weights are sampled from a picture.
class Compiled {
  public:
    explicit Compiled(const std::string& body) : inputs_(kComponents * kVoxels) {
        const std::string text = fmt::format(
            "fablet A {{ @uniform {{ Material a, b, c; ImageTexture2D picture; }}\n"
            "@Surface(@varying {{ SurfaceAttributes attr, float2 uv, out float2 at }})\n"
            "{{ at = uv; return 0; }}\n"
            "@Volume(@varying {{ VolumeAttributes attr, @nearest float2 at }})\n"
            "{{ MaterialComposition mc; {} return mc; }} }}",
            body);
        program_ = load_fablet(text);
        kernel_ = &program_->fablets().fablets[0]->slab;
        call_.emplace(*kernel_, OPENFAB_ISA_AVX2);
        buffers_ = std::make_unique<abi::KernelBuffer[]>(static_cast<size_t>(kernel_->arg_count));
        corners_.resize(3 * kBatch);
        codes_.resize(kVoxels);
        counts_.resize(kVoxels);
        fractions_.resize(kChannels * kVoxels);
        columns_.resize(kVoxels / 8);
        std::iota(columns_.begin(), columns_.end(), 0);
        for (int32_t k = 0; k < kernel_->arg_count; ++k)
            bind(k);
    }
    void set_picture(const texture::Pyramid& picture) {
        for (int32_t k = 0; k < kernel_->arg_count; ++k) {
            const openfab_arg& arg = kernel_->args[k];
            if (arg.kind != OPENFAB_ARG_TEXTURE) continue;
            const bool texels = arg.b == OPENFAB_TEXTURE_TEXELS;
            abi::KernelBuffer& buffer = buffers_[k];
            if (texels) {
                buffer.set_dense(abi::halide_type(OPENFAB_FLOAT), picture.texels().data(),
                                 {static_cast<int32_t>(picture.texels().size())});
            } else {
                buffer.set_dense(abi::halide_type(OPENFAB_INT), picture.info().data(),
                                 {static_cast<int32_t>(picture.info().size())});
            }
            call_->set(k, buffer.raw());
        }
    }
    /// Returns the seconds that one call takes.
    double run(const Batch& batch) {
        std::memcpy(inputs_.data(), batch.data(), batch.size() * sizeof(float));
        const double begin = processor_seconds();
        if (!call_->run().ok()) std::exit(4);
        return processor_seconds() - begin;
    }

  private:
    /// Answers from inputs_.
    struct Source : openfab_nearest_source {
        explicit Source(const Compiled& of)
            : openfab_nearest_source{answer_request}, compiled(of) {}
        static int answer_request(openfab_nearest_source* source,
                                  const openfab_nearest_request* request) {
            const Compiled& of = static_cast<Source*>(source)->compiled;
            const openfab_fablet& fablet = *of.program_->fablets().fablets[0];
            for (int32_t f = 0; f < fablet.field_count; ++f) {
                const openfab_arg& arg = fablet.fields[f];
                const int32_t c = arg.kind == OPENFAB_ARG_NEAREST ? arg.b : kDu + arg.b;
                const float* from = &of.inputs_[static_cast<size_t>(c) * kVoxels] +
                                    static_cast<ptrdiff_t>(8 * request->first);
                float* to = request->results + f * request->field_stride;
                const auto columns =
                    std::min(request->count, static_cast<int32_t>(kVoxels / 8) - request->first);
                for (int32_t i = 0; i < columns; ++i)
                    std::copy_n(from + 8 * i, 8, to + i * request->column_stride);
            }
            return 0;
        }
        const Compiled& compiled;
    };

    void bind(int32_t k) {
        const openfab_arg& arg = kernel_->args[k];
        abi::KernelBuffer& buffer = buffers_[k];
        const halide_type_t type = abi::halide_type(arg);
        switch (arg.kind) {
            case OPENFAB_ARG_BLOCKS:
                buffer.set_dense(type, corners_.data(), {3, kBatch});
                break;
            case OPENFAB_ARG_NEAREST_SOURCE:
                call_->set(k, &source_address_);
                return;
            case OPENFAB_ARG_GROUPS:
                buffer.set_dense(type, columns_.data(), {static_cast<int32_t>(kVoxels / 8)});
                break;
            case OPENFAB_ARG_CHANNELS:
                buffer.set_dense(type, channels_.table(), {OPENFAB_CHANNEL_ROWS, kChannels});
                break;
            case OPENFAB_ARG_CODE:
                buffer.set_columns(type, codes_.data(), static_cast<int32_t>(kVoxels / 8));
                break;
            case OPENFAB_ARG_UNUSABLE:
                buffer.set_columns(type, counts_.data(), static_cast<int32_t>(kVoxels / 8));
                break;
            case OPENFAB_ARG_FRACTION:
                buffer.set_columns(type, &fractions_[static_cast<size_t>(arg.a) * kVoxels],
                                   static_cast<int32_t>(kVoxels / 8));
                break;
            default:
                return;
        }
        call_->set(k, buffer.raw());
    }

    std::unique_ptr<lower::LoadedProgram> program_;
    const openfab_kernel* kernel_ = nullptr;
    std::optional<abi::KernelCall> call_;
    std::unique_ptr<abi::KernelBuffer[]> buffers_;
    static constexpr int32_t kChannels = 4;
    const abi::Channels channels_{std::array<int32_t, 3>{1, 2, 3}};
    std::vector<int32_t> corners_, columns_;
    std::vector<float> inputs_;
    Source source_{*this};
    openfab_nearest_source* const source_address_ = &source_;
    std::vector<uint8_t> codes_;
    std::vector<uint16_t> counts_, fractions_;
};

double median(std::vector<double> values) {
    std::nth_element(values.begin(), values.begin() + values.size() / 2, values.end());
    return values[values.size() / 2];
}

void measure() {
    struct Kernel {
        const char* name;
        Compiled compiled;
        int32_t channels;
    };
    Kernel kernels[] = {
        {"no look-up", Compiled("mc.Set(a, at.x * at.y);"), 1},
        {"one channel", Compiled("mc.Set(a, picture.Sample1(at, 0));"), 1},
        {"three channels",
         Compiled("float3 l = picture.Sample3(at, 0); mc.Set(a, l.r); mc.Set(b, l.g); "
                  "mc.Set(c, l.b);"),
         3},
    };
    fmt::print("4k picture, look-ups of the volume kernel, M/s (AVX2, one thread)\n");
    fmt::print("{:10} {:12} {:16} {:>8}\n", "places", "filter", "kernel", "M/s");
    const std::array<const char*, 3> filters = {"trilinear", "anisotropic", "nearest"};
    for (const int32_t channels : {1, 3}) {
        for (const int32_t filter : {1, 0, 2}) {
            const auto picture = make_picture(channels, filter);
            for (const bool sphere : {true, false}) {
                const std::vector<Batch> batches = make_batches(sphere);
                for (Kernel& kernel : kernels) {
                    if (kernel.channels != channels) continue;
                    kernel.compiled.set_picture(*picture);
                    std::vector<double> rounds;
                    for (int round = 0; round < kRounds; ++round) {
                        double sum = 0;
                        for (const Batch& batch : batches)
                            sum += kernel.compiled.run(batch);
                        rounds.push_back(sum);
                    }
                    fmt::print("{:10} {:12} {:16} {:8.1f}\n", sphere ? "sphere" : "card",
                               filters[filter], kernel.name,
                               static_cast<double>(kVoxels) * kCalls / median(rounds) * 1e-6);
                }
            }
        }
    }
}

}  // namespace

}  // namespace openfab::bench

int main() {
    openfab::bench::measure();
    return 0;
}
