// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/openfab/export_stack.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <span>
#include <string_view>

#include "backends/raster/npy.h"
#include "backends/raster/npy_sink.h"
#include "backends/raster/png_encode.h"
#include "base/input_file.h"
#include "base/json.h"
#include "base/start_program.h"
#include "client/child.h"
#include "tools/openfab/messages.h"

namespace openfab::tools {

namespace {

constexpr size_t kLargestNote = 16'000'000;
constexpr float kWhite = 65535;

Result<Vec3d> vector_of(const JsonValue& root, const char* name) {
    const JsonMember* member = root.find(name);
    if (member == nullptr || member->value.items.size() != 3)
        return internal_error(fmt::format(messages::kPrintDoesNotSay, name));
    const std::vector<JsonValue>& items = member->value.items;
    return Vec3d{items[0].number, items[1].number, items[2].number};
}

/// Calls visit(z, values of the slice); false where the file ends before that.
template <typename Visit>
Result<void> each_slice(const FractionStack& stack, const Visit& visit) {
    const size_t count = static_cast<size_t>(stack.size[0]) * static_cast<size_t>(stack.size[1]) *
                         stack.materials.size();
    std::ifstream in(stack.file, std::ios::binary);
    in.seekg(stack.data_at);
    std::vector<float> values(count);
    for (int32_t z = 0; z < stack.size[2]; ++z) {
        in.read(reinterpret_cast<char*>(values.data()),
                static_cast<std::streamsize>(count * sizeof(float)));
        if (!in) return outside_error(fmt::format(messages::kEndedEarly, stack.file.string()));
        if (Result<void> done = visit(z, std::span<const float>(values)); !done) return done;
    }
    return {};
}

}  // namespace

Result<FractionStack> print_fractions(const FractionPrint& print,
                                      const std::filesystem::path& folder) {
    const Result<std::filesystem::path> ours = program_folder();
    if (!ours) return ours.error();
    FractionStack stack;
    stack.file = folder / "fractions.npy";
    std::vector<std::string> argv{(*ours / "openfab").string(),
                                  "print",
                                  as_argument(print.world),
                                  "-o",
                                  (folder / "codes.npy").string(),
                                  "--fractions",
                                  stack.file.string(),
                                  "--voxel",
                                  print.voxel,
                                  "--support",
                                  "off",
                                  "--sampling",
                                  "centre",
                                  "--progress",
                                  "none"};
    if (print.programs) argv.emplace_back("--allow-programs");
    for (const std::string& one : print.settings)
        argv.push_back("--set=" + one);
    const std::filesystem::path err = folder / "print.err";
    if (const Result<void> done = client::run(argv, folder / "print.out", folder / "print.err");
        !done)
        return done.error();
    const Result<std::string> note =
        read_text_file(raster::array_json_path(stack.file), kLargestNote);
    if (!note) return note.error();
    const Result<JsonValue> root = parse_json(*note, "fractions.npy.json");
    if (!root) return root.error();
    const Result<Vec3d> pitch = vector_of(*root, "pitch_mm");
    if (!pitch) return pitch.error();
    const Result<Vec3d> origin = vector_of(*root, "origin_mm");
    if (!origin) return origin.error();
    stack.pitch_mm = *pitch;
    stack.origin_mm = *origin;
    if (const JsonMember* materials = root->find("materials"); materials != nullptr) {
        for (const JsonValue& one : materials->value.items) {
            const JsonMember* name = one.find("name");
            stack.materials.push_back(name == nullptr ? "" : name->value.text);
        }
    }
    // `{'descr': '<f4', 'fortran_order': False, 'shape': (Z, Y, X, M), }`, behind ten bytes.
    std::ifstream in(stack.file, std::ios::binary);
    std::string text(raster::kNpyHeaderBytes, ' ');
    in.read(text.data(), static_cast<std::streamsize>(text.size()));
    constexpr std::string_view kShape = "'shape': (";
    const size_t shape = text.find(kShape);
    if (!in || shape == std::string::npos) return internal_error(messages::kFractionsWithoutShape);
    std::array<int64_t, 4> sizes{};
    const char* at = text.c_str() + shape + kShape.size();
    for (int64_t& size : sizes) {
        char* end = nullptr;
        size = std::strtol(at, &end, 10);
        at = end + (*end == ',' ? 1 : 0);
    }
    if (sizes[3] != static_cast<int64_t>(stack.materials.size()) ||
        *std::min_element(sizes.begin(), sizes.end()) < 1)
        return internal_error(messages::kFractionsOfOtherShape);
    for (size_t axis = 0; axis < 3; ++axis)
        stack.size[axis] = static_cast<int32_t>(sizes[2 - axis]);
    stack.data_at = raster::kNpyHeaderBytes;
    stack.used.assign(stack.materials.size(), false);
    const Result<void> seen = each_slice(stack, [&](int32_t, std::span<const float> values) {
        for (size_t i = 0; i < values.size(); ++i) {
            if (values[i] > 0) stack.used[i % stack.materials.size()] = true;
        }
        return Result<void>();
    });
    if (!seen) return seen.error();
    return stack;
}

Result<void> make_sheets(const FractionStack& stack, const TakeSheet& take) {
    const auto columns = static_cast<size_t>(stack.size[0]);
    const size_t materials = stack.materials.size();
    raster::PngImage image;
    image.width = stack.size[0];
    image.height = stack.size[1];
    image.color = raster::PngColor::kGrey;
    image.bits = 16;
    return each_slice(stack, [&](int32_t z, std::span<const float> values) -> Result<void> {
        const auto sheet = [&](int32_t material) {
            // The first row of a sheet is the highest y.
            std::vector<uint8_t> rows;
            rows.reserve(static_cast<size_t>(image.height) * (2 * columns + 1));
            for (int32_t y = image.height - 1; y >= 0; --y) {
                rows.push_back(0);
                for (size_t x = 0; x < columns; ++x) {
                    const float* at = &values[(static_cast<size_t>(y) * columns + x) * materials];
                    float share = 0;
                    for (size_t m = 0; m < materials; ++m) {
                        if (material < 0 || static_cast<size_t>(material) == m) share += at[m];
                    }
                    const auto grey = static_cast<uint32_t>(
                        std::floor(std::clamp(share, 0.0F, 1.0F) * kWhite + 0.5F));
                    rows.push_back(static_cast<uint8_t>(grey >> 8));
                    rows.push_back(static_cast<uint8_t>(grey & 255));
                }
            }
            image.rows = rows;
            constexpr int kLevel = 6;
            const std::vector<uint8_t> png = raster::encode_png(image, kLevel);
            if (png.empty()) return Result<void>(outside_error(messages::kOutOfMemory));
            return take(z, material, png);
        };
        if (Result<void> done = sheet(-1); !done) return done;
        for (size_t m = 0; m < materials; ++m) {
            if (!stack.used[m]) continue;
            if (Result<void> done = sheet(static_cast<int32_t>(m)); !done) return done;
        }
        return {};
    });
}

}  // namespace openfab::tools
