// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/color/chart.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>

#include "backends/common/output_file.h"
#include "backends/ofr/ofr_reader.h"
#include "base/check.h"
#include "base/input_file.h"
#include "base/text.h"
#include "tools/color/chart_texts.h"
#include "tools/color/messages.h"
#include "tools/color/nrrd_write.h"
#include "tools/color/picture.h"
#include "tools/color/print_inks.h"

namespace openfab::color {

namespace {

namespace fs = std::filesystem;

constexpr int kColumns = 20;
constexpr int kPatchMm = 4;

void add(SampleTable* chart, const Inks& inks) {
    Sample sample;
    sample.id = std::to_string(chart->samples.size() + 1);
    sample.inks = inks;
    // As the table's text has them.
    for (double& ink : sample.inks)
        ink = std::round(ink * 1e5) / 1e5;
    chart->samples.push_back(std::move(sample));
}

void add(SampleTable* chart, const Rgb& rgb) {
    Sample sample;
    sample.id = std::to_string(chart->samples.size() + 1);
    sample.rgb = rgb;
    chart->samples.push_back(std::move(sample));
}

/// The radical inverse of `index` in `base` (Halton, 1960).
double radical_inverse(int index, int base) {
    double out = 0, place = 1;
    for (; index > 0; index /= base) {
        place /= base;
        out += place * (index % base);
    }
    return out;
}

std::string_view chart_text(std::string_view name) {
    const auto* const found = std::ranges::find(kChartTexts, name, &EmbeddedText::name);
    OPENFAB_CHECK(found != std::end(kChartTexts));  // tools/color/CMakeLists.txt has all names
    return found->text;
}

void replace_all(std::string* text, std::string_view from, const std::string& to) {
    for (size_t at = 0; (at = text->find(from, at)) != std::string::npos; at += to.size())
        text->replace(at, from.size(), to);
}

int rows_of(const SampleTable& chart) {
    const auto columns = static_cast<size_t>(chart.columns);
    return static_cast<int>((chart.samples.size() + columns - 1) / columns);
}

Result<void> is_chart(const SampleTable& chart) {
    if (chart.columns > 0) return {};
    return user_error(messages::kPatchLayoutUnknown, messages::kPatchLayoutUnknownHelp);
}

/// Of a patch, what is measured: the borders mix with their neighbours.
constexpr double kMargin = 0.25;

}  // namespace

SampleTable ink_chart() {
    constexpr size_t kPatches = size_t{kColumns} * 18;
    SampleTable chart;
    chart.has_inks = true;
    chart.columns = kColumns;
    add(&chart, Inks{});
    for (size_t i = 0; i < 4; ++i) {
        for (const double amount : {0.01, 0.03, 0.07, 0.15, 0.3, 0.5, 0.75, 1.0}) {
            Inks inks{};
            inks[i] = amount;
            add(&chart, inks);
        }
    }
    for (size_t i = 0; i < 4; ++i) {
        for (size_t j = i + 1; j < 4; ++j) {
            for (const double sum : {0.1, 0.4, 1.0}) {
                for (const double share : {0.1, 0.5, 0.9}) {
                    Inks inks{};
                    inks[i] = sum * share;
                    inks[j] = sum * (1 - share);
                    add(&chart, inks);
                }
            }
        }
    }
    // Corners of paper show light that falls off across a photograph, and instruments that drift.
    constexpr size_t kWhiteEvery = 60;
    for (int k = 1; chart.samples.size() < kPatches; ++k) {
        if (chart.samples.size() % kWhiteEvery == kWhiteEvery - 1) {
            add(&chart, Inks{});
            continue;
        }
        Inks inks{radical_inverse(k, 2), radical_inverse(k, 3), radical_inverse(k, 5),
                  radical_inverse(k, 7)};
        double sum = 0;
        for (double& ink : inks) {
            ink *= ink;
            sum += ink;
        }
        for (double& ink : inks)
            ink /= std::max(sum, 1.0);
        add(&chart, inks);
    }
    return chart;
}

SampleTable color_chart() {
    constexpr int kSteps = 6, kGreys = 24;
    SampleTable chart;
    chart.has_rgb = true;
    chart.columns = kColumns;
    for (int r = 0; r < kSteps; ++r) {
        for (int g = 0; g < kSteps; ++g) {
            for (int b = 0; b < kSteps; ++b)
                add(&chart, Rgb{r / (kSteps - 1.0), g / (kSteps - 1.0), b / (kSteps - 1.0)});
        }
    }
    for (int i = 0; i < kGreys; ++i) {
        const double grey = i / (kGreys - 1.0);
        add(&chart, Rgb{grey, grey, grey});
    }
    return chart;
}

Result<void> write_chart(const fs::path& folder, const SampleTable& chart,
                         const fs::path& ink_table) {
    const int columns = chart.columns, rows = rows_of(chart);
    const int channels = chart.has_inks ? 4 : 3;
    std::vector<uint16_t> values(static_cast<size_t>(columns * rows * channels));
    for (size_t k = 0; k < chart.samples.size(); ++k) {
        const int x = static_cast<int>(k) % columns, y = rows - 1 - static_cast<int>(k) / columns;
        for (int c = 0; c < channels; ++c) {
            const auto channel = static_cast<size_t>(c);
            const double value =
                chart.has_inks ? chart.samples[k].inks[channel] : chart.samples[k].rgb[channel];
            values[static_cast<size_t>((y * columns + x) * channels + c)] =
                static_cast<uint16_t>(std::lround(value * 65535));
        }
    }
    std::error_code failed;
    // A chart's world may have been edited.
    if (fs::exists(folder / "chart.fab.json", failed)) {
        return user_error(
            fmt::format(messages::kFolderExists, (folder / "chart.fab.json").string()));
    }
    fs::create_directories(folder, failed);
    if (failed) {
        return outside_error(
            fmt::format(messages::kCannotMakeFolder, folder.string(), failed.message()));
    }
    const char* const source = chart.has_inks ? "ink_chart.fl" : "color_chart.fl";
    std::string world(chart_text("chart.fab.json"));
    std::string textures = "        \"patches\": {\"file\": \"patches.nrrd\"}";
    if (!chart.has_inks) textures += ",\n        \"inks\": {\"file\": \"inks.nrrd\"}";
    replace_all(&world, "SOURCE", source);
    replace_all(&world, "FABLET", chart.has_inks ? "InkChart" : "ColorChart");
    replace_all(&world, "TEXTURES", textures);
    replace_all(&world, "BOUND",
                chart.has_inks ? "\"amounts\": \"patches\""
                               : "\"colours\": \"patches\", \"profile\": \"inks\"");
    replace_all(&world, "WIDTH", std::to_string(columns * kPatchMm));
    replace_all(&world, "HEIGHT", std::to_string(rows * kPatchMm));
    replace_all(&world, "COLUMNS", std::to_string(columns));
    replace_all(&world, "ROWS", std::to_string(rows));
    const auto write = [&](const char* name, const std::string& text) {
        return backends::write_whole_file(folder / name, text);
    };
    Result<void> done = write("chart.fab.json", world);
    if (done) done = write(source, std::string(chart_text(source)));
    if (done)
        done = write("patches.nrrd", nrrd_of({columns, rows, 1}, channels, values,
                                             "the patches of a chart, first row at the top"));
    if (done)
        done = write("chart.txt", format_samples(chart, chart.has_inks ? "a chart of inks"
                                                                       : "a chart of colours"));
    if (!done || chart.has_inks) return done;
    const Result<InputFile> table = InputFile::open(ink_table);
    if (!table)
        return with_context(table.error(),
                            fmt::format(messages::kCannotReadBefore, ink_table.string()));
    constexpr int64_t kLargestTable = 16 << 20;
    const Result<std::string> bytes = table->read_all(kLargestTable);
    if (!bytes)
        return with_context(bytes.error(),
                            fmt::format(messages::kCannotReadBefore, ink_table.string()));
    return write("inks.nrrd", *bytes);
}

namespace {

/// A projective map of the unit square, y down, to four corners (Heckbert, "Fundamentals of texture
/// mapping and image warping", 1989).
class Square2Quad {
  public:
    explicit Square2Quad(const std::array<std::array<double, 2>, 4>& c) {
        const double sx = c[0][0] - c[1][0] + c[2][0] - c[3][0];
        const double sy = c[0][1] - c[1][1] + c[2][1] - c[3][1];
        const double x1 = c[1][0] - c[2][0], x2 = c[3][0] - c[2][0];
        const double y1 = c[1][1] - c[2][1], y2 = c[3][1] - c[2][1];
        const double det = x1 * y2 - x2 * y1;
        fine = std::abs(det) > 1e-9;
        if (!fine) return;
        g_ = (sx * y2 - x2 * sy) / det;
        h_ = (x1 * sy - sx * y1) / det;
        a_ = c[1][0] - c[0][0] + g_ * c[1][0];
        b_ = c[3][0] - c[0][0] + h_ * c[3][0];
        d_ = c[1][1] - c[0][1] + g_ * c[1][1];
        e_ = c[3][1] - c[0][1] + h_ * c[3][1];
        c_ = c[0][0];
        f_ = c[0][1];
    }
    std::array<double, 2> at(double u, double v) const {
        const double w = g_ * u + h_ * v + 1;
        return {(a_ * u + b_ * v + c_) / w, (d_ * u + e_ * v + f_) / w};
    }
    bool fine = false;

  private:
    double a_ = 0, b_ = 0, c_ = 0, d_ = 0, e_ = 0, f_ = 0, g_ = 0, h_ = 0;
};

using Quad = std::array<std::array<double, 2>, 4>;

/// Fails for corners that no photograph of a chart can have: its sides do not cross, it is seen from the
/// front, and no three of its corners lie on a line.
Result<void> check_corners(const Quad& quad) {
    constexpr double kFlattest = 0.01;  // the sine of an angle
    int left = 0, right = 0;
    bool flat = false;
    for (size_t k = 0; k < 4; ++k) {
        const auto& a = quad[k];
        const auto& b = quad[(k + 1) % 4];
        const auto& c = quad[(k + 2) % 4];
        for (size_t other = k + 1; other < 4; ++other) {
            if (std::hypot(quad[other][0] - a[0], quad[other][1] - a[1]) < 1)
                return user_error(fmt::format(messages::kCornersEqual, k + 1, other + 1),
                                  messages::kCornersHelp);
        }
        const double ux = b[0] - a[0], uy = b[1] - a[1], vx = c[0] - b[0], vy = c[1] - b[1];
        const double sine = (ux * vy - uy * vx) / (std::hypot(ux, uy) * std::hypot(vx, vy));
        flat = flat || !(std::abs(sine) >= kFlattest);
        ++(sine > 0 ? right : left);
    }
    if (flat) return user_error(messages::kCornersOnLine, messages::kCornersHelp);
    if (left == 4) return user_error(messages::kCornersMirrored, messages::kCornersHelp);
    if (left == 2) return user_error(messages::kCornersCross, messages::kCornersHelp);
    if (left > 0) return user_error(messages::kCornerWithin, messages::kCornersHelp);
    return {};
}

}  // namespace

Result<SampleTable> read_photograph(const Picture& picture, const SampleTable& chart,
                                    const PhotographOptions& options) {
    if (Result<void> fine = is_chart(chart); !fine) return fine.error();
    const double w = picture.width(), h = picture.height();
    Quad quad = {{{0, 0}, {w, 0}, {w, h}, {0, h}}};
    for (size_t i = 0; i < options.corners.size(); ++i) {
        quad[i / 2][i % 2] = options.corners[i];
        if (!(options.corners[i] >= 0 && options.corners[i] <= (i % 2 == 0 ? w : h))) {
            return user_error(fmt::format(messages::kCornerOutside, i / 2 + 1, w, h),
                              messages::kCornerOutsideHelp);
        }
    }
    if (!options.corners.empty())
        if (Result<void> fine = check_corners(quad); !fine) return fine.error();
    const Square2Quad map(quad);
    if (!map.fine) return user_error(messages::kCornersOnLine, messages::kCornersHelp);
    const int columns = chart.columns, rows = rows_of(chart);
    const auto side = [&](size_t a, size_t b) {
        return std::hypot(quad[b][0] - quad[a][0], quad[b][1] - quad[a][1]);
    };
    const double across = std::min(
        {side(0, 1) / columns, side(3, 2) / columns, side(0, 3) / rows, side(1, 2) / rows});
    constexpr double kFewestPixels = 4;
    if (across < kFewestPixels) {
        return user_error(
            fmt::format(messages::kPatchesTooSmall, picture.name(), across, kFewestPixels),
            messages::kPatchesTooSmallHelp);
    }
    SampleTable out = chart;
    out.has_lab = true;
    constexpr int kAlong = 24;
    for (size_t k = 0; k < out.samples.size(); ++k) {
        const int column = static_cast<int>(k) % columns, row = static_cast<int>(k) / columns;
        Rgb sum{};
        for (int j = 0; j < kAlong; ++j) {
            for (int i = 0; i < kAlong; ++i) {
                const auto inner = [](int n) {
                    return kMargin + (1 - 2 * kMargin) * (n + 0.5) / kAlong;
                };
                const std::array<double, 2> at =
                    map.at((column + inner(i)) / columns, (row + inner(j)) / rows);
                const Rgb& pixel = picture.at(static_cast<int>(at[0]), static_cast<int>(at[1]));
                for (size_t c = 0; c < 3; ++c)
                    sum[c] += pixel[c];
            }
        }
        for (double& channel : sum)
            channel /= kAlong * kAlong;
        Xyz xyz = xyz_of_linear(sum);
        if (options.white) {
            xyz.x *= options.white->x / kD50.x;
            xyz.y *= options.white->y / kD50.y;
            xyz.z *= options.white->z / kD50.z;
        }
        out.samples[k].lab = to_lab(xyz);
    }
    return out;
}

Result<PrintedChart> read_print(const std::string& file, const SampleTable& chart, double skin_mm) {
    if (Result<void> fine = is_chart(chart); !fine) return fine.error();
    const Result<std::unique_ptr<ofr::OfrReader>> opened = ofr::OfrReader::open(file);
    if (!opened) return opened.error();
    ofr::OfrReader& print = **opened;
    const pipeline::PrintInfo& info = print.info();
    const Result<std::vector<int>> ink_of_code = inks_of_codes(info, file);
    if (!ink_of_code) return ink_of_code.error();
    const int columns = chart.columns, rows = rows_of(chart);
    const double patch_x = info.size.x * info.pitch_mm.x / columns;
    const double patch_y = info.size.y * info.pitch_mm.y / rows;
    // Patches are squares.
    if (std::abs(patch_x / patch_y - 1) > 0.02) {
        return user_error(
            fmt::format(messages::kNotPrintOfChart, file, columns, rows, patch_x, patch_y));
    }
    const auto patch_of = [](int32_t voxel, int32_t size, int patches) {
        const double place = (voxel + 0.5) / size * patches;
        const double within = place - std::floor(place);
        return within < kMargin || within > 1 - kMargin ? -1 : static_cast<int>(place);
    };
    std::vector<int> column_of, row_of;
    for (int32_t x = 0; x < info.size.x; ++x)
        column_of.push_back(patch_of(x, info.size.x, columns));
    for (int32_t y = 0; y < info.size.y; ++y) {
        const int up = patch_of(y, info.size.y, rows);
        row_of.push_back(up < 0 ? -1 : rows - 1 - up);
    }
    std::vector<std::array<int64_t, 5>> counts(static_cast<size_t>(columns) *
                                               static_cast<size_t>(rows));
    // Voxels whose centres are in the skin, but for the one at its lower side.
    const int32_t lowest = info.size.z - static_cast<int32_t>(skin_mm / info.pitch_mm.z + 0.5) + 1;
    for (;;) {
        const Result<bool> more = print.next();
        if (!more) return more.error();
        if (!*more) break;
        const pipeline::SliceView& slice = print.slice();
        if (slice.z < std::min(lowest, info.size.z - 1)) continue;
        for (int32_t y = 0; y < slice.height; ++y) {
            if (row_of[static_cast<size_t>(y)] < 0) continue;
            for (int32_t x = 0; x < slice.width; ++x) {
                if (column_of[static_cast<size_t>(x)] < 0) continue;
                const uint8_t code = slice.code(x, y, info.bits);
                if (code == 0 || code >= ink_of_code->size()) continue;
                const int patch =
                    row_of[static_cast<size_t>(y)] * columns + column_of[static_cast<size_t>(x)];
                const int ink = (*ink_of_code)[code];
                ++counts[static_cast<size_t>(patch)][static_cast<size_t>(ink < 0 ? 4 : ink)];
            }
        }
    }
    PrintedChart out;
    out.voxels = std::numeric_limits<int64_t>::max();
    for (size_t k = 0; k < chart.samples.size(); ++k) {
        int64_t all = 0;
        for (const int64_t count : counts[k])
            all += count;
        if (all == 0) {
            return user_error(fmt::format(messages::kPatchMissing, chart.samples[k].id, file),
                              messages::kPatchMissingHelp);
        }
        out.voxels = std::min(out.voxels, all);
        Inks inks;
        for (size_t i = 0; i < inks.size(); ++i)
            inks[i] = static_cast<double>(counts[k][i]) / static_cast<double>(all);
        out.patches.push_back(inks);
    }
    return out;
}

}  // namespace openfab::color
