// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Measures the quality of each dither: `bench_dither_table [FOLDER]` writes the tables of
// bench/README to standard output, and pictures of a box's sides into the folder. Nothing is timed.

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <string>

#include "backends/raster/png_encode.h"
#include "tests/support/stages/dither_shapes.h"
#include "tests/support/stages/field_printer.h"

namespace openfab {
namespace {

using dither::DitherRule;
using reference::FractionField;

struct Rule {
    const char* name;
    DitherRule rule;
};
constexpr Rule kRules[] = {{"floyd_steinberg", DitherRule::kFloydSteinberg},
                           {"decorrelated", DitherRule::kDecorrelated},
                           {"blue_noise", DitherRule::kBlueNoise}};
constexpr double kFractions[] = {0.005, 0.01, 0.02, 0.05, 0.1, 0.25, 0.5, 0.75, 0.9};
constexpr uint64_t kSeeds = 8;

std::vector<uint8_t> print(const FractionField& field, uint64_t seed, DitherRule rule) {
    return testing::print_field(field, seed, abi::best_isa(), rule);
}

/// Deviations from the requested fractions.
struct Deviations {
    double squares = 0, worst = 0;
    int64_t count = 0;

    void add(double deviation) {
        squares += deviation * deviation;
        worst = std::max(worst, std::abs(deviation));
        ++count;
    }
    double rms() const { return std::sqrt(squares / static_cast<double>(count)); }
};

void print_head(const char* first, const std::vector<std::string>& columns) {
    std::printf("\n| %s |", first);
    for (const std::string& column : columns)
        std::printf(" %s |", column.c_str());
    std::printf("\n|");
    for (size_t i = 0; i <= columns.size(); ++i)
        std::printf(" --- |");
    std::printf("\n");
}

void print_skins() {
    std::printf(
        "\nDeviation of the share printed, points: the worst face of a box of 80 x 80 x 60\n"
        "voxels, x, y and z; the worst layer below a face; octants of the skin of a ball of\n"
        "radius 50, root mean square and worst. %d seeds.\n",
        static_cast<int>(kSeeds));
    print_head("rule, share", {"x", "y", "z", "below x, y", "octants", "worst octant", "allowed"});
    for (const Rule& rule : kRules) {
        for (double fraction : kFractions) {
            Deviations faces[3], below, octants;
            const FractionField box = testing::box({80, 80, 60}, testing::quantised({fraction}));
            const FractionField ball = testing::ball(50, testing::quantised({fraction}));
            for (uint64_t seed = 0; seed < kSeeds; ++seed) {
                const std::vector<uint8_t> codes = print(box, seed, rule.rule);
                const auto outer = testing::face_shares(box, codes, 2);
                const auto next = testing::face_shares(box, codes, 2, 1);
                for (size_t f = 0; f < 6; ++f) {
                    faces[f / 2].add(100 * (outer[f] - fraction));
                    if (f < 4) below.add(100 * (next[f] - fraction));
                }
                for (double share : testing::skin_shares(ball, print(ball, seed, rule.rule), 2))
                    octants.add(100 * (share - fraction));
            }
            std::printf("| `%s`, %g %% | %.2f | %.2f | %.2f | %.2f | %.2f | %.2f | %.2f |\n",
                        rule.name, 100 * fraction, faces[0].worst, faces[1].worst, faces[2].worst,
                        below.worst, octants.rms(), octants.worst, std::max(0.5, 5 * fraction));
        }
    }
}

Deviations of_box(const Vec3i& size, double fraction, DitherRule rule) {
    Deviations result;
    const FractionField field = testing::box(size, testing::quantised({fraction}));
    for (uint64_t seed = 0; seed < kSeeds; ++seed) {
        const double share = testing::share_of(field, print(field, seed, rule), 2,
                                               [](const Vec3i&) { return true; });
        result.add(100 * (share / fraction - 1));
    }
    return result;
}

Vec3i along(int32_t axis, int32_t length, int32_t width) {
    return {axis == 0 ? length : width, axis == 1 ? length : width, axis == 2 ? length : width};
}

std::string of_axes(int32_t length, int32_t width, double fraction, DitherRule rule) {
    Deviations all;
    for (int32_t axis = 0; axis < 3; ++axis) {
        const Deviations one = of_box(along(axis, length, width), fraction, rule);
        all.squares += one.squares;
        all.count += one.count;
    }
    char text[32];
    std::snprintf(text, sizeof(text), "%.1f", all.rms());
    return text;
}

/// A ring of this radius, 3 voxels wide, 64 slices; or a disc of one slice.
double round_rms(double radius, double hole, int32_t slices, double fraction, DitherRule rule) {
    const int32_t side = 2 * static_cast<int32_t>(radius) + 3;
    const FractionField field =
        testing::shaped({side, side, slices}, testing::quantised({fraction}), [&](const Vec3i& v) {
            const double r = std::hypot(v.x + 0.5 - side / 2.0, v.y + 0.5 - side / 2.0);
            return r < radius && r >= hole;
        });
    Deviations result;
    for (uint64_t seed = 0; seed < kSeeds; ++seed) {
        const double share = testing::share_of(field, print(field, seed, rule), 2,
                                               [](const Vec3i&) { return true; });
        result.add(100 * (share / fraction - 1));
    }
    return result.rms();
}

void print_features() {
    std::printf(
        "\nDeviation of the share printed, %% of it, root mean square over %d seeds and three\n"
        "axes: rods of N x N voxels, 64 long (and 8 x 8, 488 long); layers of N voxels, 64 x\n"
        "64; rings 3 wide of radius 20 in 64 slices; discs of radius 20 in one slice.\n",
        static_cast<int>(kSeeds));
    print_head("rule, share", {"rod 3", "4", "6", "8", "11", "16", "8, long", "layer 1", "2", "5",
                               "ring", "disc"});
    for (const Rule& rule : kRules) {
        for (double fraction : kFractions) {
            std::printf("| `%s`, %g %% |", rule.name, 100 * fraction);
            for (int32_t width : {3, 4, 6, 8, 11, 16})
                std::printf(" %s |", of_axes(64, width, fraction, rule.rule).c_str());
            std::printf(" %s |", of_axes(488, 8, fraction, rule.rule).c_str());
            for (int32_t thickness : {1, 2, 5})
                std::printf(" %s |", of_axes(thickness, 64, fraction, rule.rule).c_str());
            std::printf(" %.1f | %.1f |\n", round_rms(20, 17, 64, fraction, rule.rule),
                        round_rms(20, 0, 1, fraction, rule.rule));
        }
    }
}

constexpr int32_t kSide = 128;
using Plane = std::vector<double>;  ///< kSide x kSide: 1 where the material is, 0 elsewhere

enum class Cut { kTop, kInside, kLowX, kHighX, kLowY, kHighY, kAcross, kAlong };

/// Of a cube of kSide voxels: the top, a slice, the sides, and sections across y and x.
Plane plane_of(const std::vector<uint8_t>& codes, Cut cut, int32_t at, uint8_t code) {
    Plane plane;
    for (int32_t b = 0; b < kSide; ++b) {
        for (int32_t a = 0; a < kSide; ++a) {
            Vec3i v{a, b, at};
            if (cut == Cut::kTop) v.z = kSide - 1;
            if (cut == Cut::kLowX) v = {0, a, b};
            if (cut == Cut::kHighX) v = {kSide - 1, a, b};
            if (cut == Cut::kLowY) v = {a, 0, b};
            if (cut == Cut::kHighY) v = {a, kSide - 1, b};
            if (cut == Cut::kAcross) v = {a, at, b};
            if (cut == Cut::kAlong) v = {at, a, b};
            const auto i = (static_cast<size_t>(v.z) * kSide + v.y) * kSide + v.x;
            plane.push_back(codes[i] == code ? 1 : 0);
        }
    }
    return plane;
}

using Bins = std::array<double, 8>;

/// Power by radius, in eighths of the highest frequency of an axis, relative to white noise of the
/// same share: a discrete Fourier transform, rows and then columns.
void add_power(const Plane& plane, double fraction, Bins* bins) {
    using Complex = std::complex<double>;
    std::vector<Complex> turn, rows(plane.size()), spectrum(plane.size());
    for (int32_t k = 0; k < kSide; ++k)
        turn.push_back(std::polar(1.0, -2 * std::numbers::pi * k / kSide));
    for (int32_t y = 0; y < kSide; ++y) {
        for (int32_t k = 0; k < kSide; ++k) {
            Complex sum = 0;
            for (int32_t x = 0; x < kSide; ++x)
                sum += (plane[static_cast<size_t>(y * kSide + x)] - fraction) *
                       turn[static_cast<size_t>(x * k % kSide)];
            rows[static_cast<size_t>(y * kSide + k)] = sum;
        }
    }
    std::array<double, 8> power{}, count{};
    for (int32_t k = 0; k < kSide; ++k) {
        for (int32_t j = 0; j < kSide; ++j) {
            Complex sum = 0;
            for (int32_t y = 0; y < kSide; ++y)
                sum += rows[static_cast<size_t>(y * kSide + k)] *
                       turn[static_cast<size_t>(y * j % kSide)];
            const double radius =
                std::hypot(k < kSide / 2 ? k : k - kSide, j < kSide / 2 ? j : j - kSide);
            const auto bin = static_cast<size_t>(radius * 8 / (kSide / 2));
            if (bin >= 8 || k + j == 0) continue;
            power[bin] += std::norm(sum);
            ++count[bin];
        }
    }
    for (size_t b = 0; b < 8; ++b)
        (*bins)[b] += power[b] / count[b] / (kSide * kSide * fraction * (1 - fraction));
}

struct View {
    const char* name;
    std::vector<Cut> cuts;
};
const View kViews[] = {{"slices", {Cut::kTop, Cut::kInside}},
                       {"sides", {Cut::kLowX, Cut::kHighX, Cut::kLowY, Cut::kHighY}},
                       {"sections across y", {Cut::kAcross}},
                       {"sections across x", {Cut::kAlong}}};

/// Bins of a view, over some cuts of the print.
Bins power_of(const std::vector<uint8_t>& codes, const View& view, double fraction, uint8_t code) {
    Bins bins{};
    int32_t cuts = 0;
    for (Cut cut : view.cuts) {
        const bool within = cut == Cut::kInside || cut == Cut::kAcross || cut == Cut::kAlong;
        for (int32_t at : {30, 47, 90}) {
            if (at != 30 && !within) continue;
            add_power(plane_of(codes, cut, at, code), fraction, &bins);
            ++cuts;
        }
    }
    for (double& bin : bins)
        bin /= cuts;
    return bins;
}

void print_spectra() {
    std::printf(
        "\nPower of a cube of 128 voxels by frequency, in eighths of the highest of an axis,\n"
        "relative to white noise; the mean of material 2, or of the last three of four\n"
        "that have a quarter each.\n");
    print_head("rule, share, where", {"1", "2", "3", "4", "5", "6", "7", "8"});
    for (const Rule& rule : kRules) {
        for (double fraction : {0.02, 0.1, 0.25, 0.5}) {
            for (bool four : {false, true}) {
                if (four && fraction != 0.25) continue;
                const std::vector<double> others =
                    four ? std::vector<double>(3, 0.25) : std::vector<double>{fraction};
                const FractionField field =
                    testing::box({kSide, kSide, kSide}, testing::quantised(others));
                const std::vector<uint8_t> codes = print(field, 0, rule.rule);
                for (const View& view : kViews) {
                    Bins mean{};
                    for (size_t m = 0; m < others.size(); ++m) {
                        const Bins one =
                            power_of(codes, view, fraction, static_cast<uint8_t>(m + 2));
                        for (size_t b = 0; b < 8; ++b)
                            mean[b] += one[b] / static_cast<double>(others.size());
                    }
                    std::printf("| `%s`, %g %%%s, %s |", rule.name, 100 * fraction,
                                four ? " of four" : "", view.name);
                    for (double bin : mean)
                        std::printf(" %.2f |", bin);
                    std::printf("\n");
                }
            }
        }
    }
}

/// Two rows of six pictures, one for each of -x, +x, -y, +y, the top and a section across y, at 10
/// and 25 %; two pixels a voxel.
bool write_sides(const std::filesystem::path& file, DitherRule rule) {
    constexpr int32_t kVoxels = 64, kPixels = 2 * kVoxels, kGap = 6;
    const Cut cuts[] = {Cut::kLowX, Cut::kHighX, Cut::kLowY, Cut::kHighY, Cut::kTop, Cut::kAcross};
    const int32_t width = 6 * kPixels + 5 * kGap, height = 2 * kPixels + kGap;
    const auto row_bytes = static_cast<size_t>(width + 1);
    std::vector<uint8_t> rows(row_bytes * static_cast<size_t>(height), 128);
    for (int32_t y = 0; y < height; ++y)
        rows[static_cast<size_t>(y) * row_bytes] = 0;
    for (int32_t line = 0; line < 2; ++line) {
        const FractionField field =
            testing::box({kSide, kSide, kSide}, testing::quantised({line == 0 ? 0.1 : 0.25}));
        const std::vector<uint8_t> codes = print(field, 0, rule);
        for (int32_t c = 0; c < 6; ++c) {
            const Plane plane = plane_of(codes, cuts[c], 50, 2);
            for (int32_t y = 0; y < kPixels; ++y) {
                for (int32_t x = 0; x < kPixels; ++x) {
                    const double value = plane[static_cast<size_t>(y / 2 * kSide + x / 2)];
                    rows[static_cast<size_t>(line * (kPixels + kGap) + y) * row_bytes + 1 +
                         static_cast<size_t>(c * (kPixels + kGap) + x)] = value > 0 ? 0 : 255;
                }
            }
        }
    }
    raster::PngImage image;
    image.width = width;
    image.height = height;
    image.color = raster::PngColor::kGrey;
    image.rows = rows;
    const std::vector<uint8_t> bytes = raster::encode_png(image, 12);
    std::ofstream out(file, std::ios::binary);
    out.write(reinterpret_cast<const char*>(bytes.data()),
              static_cast<std::streamsize>(bytes.size()));
    return !bytes.empty() && out.flush().good();
}

}  // namespace
}  // namespace openfab

int main(int argc, char** argv) {
    using namespace openfab;
    if (argc > 2) {
        std::fprintf(stderr, "usage: bench_dither_table [FOLDER]\n");
        return 2;
    }
    if (argc == 2) {
        for (const Rule& rule : kRules) {
            const auto file = std::filesystem::path(argv[1]) / (std::string(rule.name) + ".png");
            if (write_sides(file, rule.rule)) continue;
            std::fprintf(stderr, "%s: cannot be written\n", file.c_str());
            return 3;
        }
    }
    print_skins();
    print_features();
    print_spectra();
}
