// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mechanics/model/voxels.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <span>
#include <unordered_map>

#include "backends/raster/npy.h"
#include "base/check.h"
#include "base/input_file.h"
#include "base/json.h"
#include "mechanics/messages.h"

namespace openfab::mechanics {

namespace {

constexpr int32_t kMostNodes = 4096;

Result<std::array<double, 3>> three(const JsonValue& json, const char* key,
                                    const std::filesystem::path& file) {
    const JsonMember* m = json.find(key);
    if (!m || m->value.items.size() != 3)
        return user_error(fmt::format(messages::kNotThreeNumbersIn, file.string(), key));
    std::array<double, 3> out;
    for (size_t a = 0; a < 3; ++a) {
        out[a] = m->value.items[a].number;
        if (!m->value.items[a].is(JsonValue::Kind::kNumber) || !std::isfinite(out[a]))
            return user_error(fmt::format(messages::kNotThreeNumbers, file.string(), key));
    }
    return out;
}

}  // namespace

Result<VoxelFile> open_voxels(const std::filesystem::path& file) {
    const std::filesystem::path beside = file.string() + ".json";
    constexpr size_t kMostBytes = 4 << 20;
    const Result<std::string> text = read_text_file(beside, kMostBytes);
    if (!text) return text.error();
    const Result<JsonValue> json = parse_json(*text, beside.string());
    if (!json) return json.error();
    VoxelFile out;
    out.file = file;
    const auto pitch = three(*json, "pitch_mm", beside);
    const auto origin = three(*json, "origin_mm", beside);
    if (!pitch) return pitch.error();
    if (!origin) return origin.error();
    for (const double h : *pitch)
        if (!(h > 0)) return user_error(fmt::format(messages::kBadPitch, beside.string(), h));
    out.pitch_mm = *pitch;
    out.origin_mm = *origin;
    const JsonMember* materials = json->find("materials");
    if (!materials) return user_error(fmt::format(messages::kNoMaterialsIn, beside.string()));
    for (const JsonValue& one : materials->value.items) {
        const JsonMember* name = one.find("name");
        out.materials.push_back(one.is(JsonValue::Kind::kString) ? one.text
                                : name                           ? name->value.text
                                                                 : std::string());
    }
    // The shape stands in the array's own header.
    const Result<InputFile> opened = InputFile::open(file);
    if (!opened) return with_context(opened.error(), fmt::format("{}: ", file.string()));
    std::string header(raster::kNpyHeaderBytes, ' ');
    const Result<size_t> got = opened->read(0, header.data(), header.size());
    if (!got) return got.error();
    const size_t shape = header.find("'shape': (");
    if (*got != header.size() || shape == std::string::npos)
        return user_error(fmt::format(messages::kNotOurArray, file.string()));
    out.codes = header.find("u1'") != std::string::npos;
    std::array<int64_t, 4> sizes{};
    size_t count = 0;
    const char* at = header.c_str() + shape + 10;
    while (count < 4 && *at != ')' && *at != 0) {
        char* end = nullptr;
        sizes[count] = std::strtoll(at, &end, 10);
        if (end == at) break;
        ++count;
        at = end;
        while (*at == ',' || *at == ' ')
            ++at;
    }
    if (count < 3 || (!out.codes && count != 4))
        return user_error(fmt::format(messages::kArrayAxes, file.string(), count));
    for (size_t a = 0; a < 3; ++a) {
        if (sizes[2 - a] < 1 || sizes[2 - a] >= kMostNodes)
            return user_error(fmt::format(messages::kTooManyVoxels, file.string(), sizes[2 - a]),
                              fmt::format(messages::kTooManyVoxelsHelp, kMostNodes));
        out.size[a] = static_cast<int32_t>(sizes[2 - a]);
    }
    // What is claimed is there, before memory is asked for.
    const auto materials_there = static_cast<int64_t>(out.materials.size());
    if (materials_there == 0 || (!out.codes && sizes[3] != materials_there))
        return user_error(fmt::format(messages::kFractionsOfOthers, file.string(), sizes[3],
                                      beside.string(), materials_there));
    const int64_t voxel = out.codes ? 1 : materials_there * int64_t{sizeof(float)};
    const int64_t wanted =
        int64_t{raster::kNpyHeaderBytes} + int64_t{out.size[0]} * out.size[1] * out.size[2] * voxel;
    if (opened->bytes() < wanted)
        return user_error(
            fmt::format(messages::kFileBytes, file.string(), opened->bytes(), wanted));
    return out;
}

namespace {

/// Calls f with the bytes of each slice.
template <typename F>
Result<void> each_slice(const VoxelFile& file, const F& f) {
    const Result<InputFile> opened = InputFile::open(file.file);
    if (!opened) return opened.error();
    const size_t plane = static_cast<size_t>(file.size[0]) * static_cast<size_t>(file.size[1]);
    std::vector<uint8_t> bytes(plane * (file.codes ? 1 : file.materials.size() * sizeof(float)));
    for (size_t z = 0; z < static_cast<size_t>(file.size[2]); ++z) {
        const Result<size_t> got =
            opened->read(static_cast<int64_t>(raster::kNpyHeaderBytes + z * bytes.size()),
                         bytes.data(), bytes.size());
        if (!got) return got.error();
        if (*got != bytes.size())
            return user_error(fmt::format(messages::kArrayEnds, file.file.string(), z));
        if (Result<void> done = f(z, std::span<const uint8_t>(bytes)); !done) return done;
    }
    return {};
}

}  // namespace

Result<std::vector<uint8_t>> used_materials(const VoxelFile& file) {
    const size_t m = file.materials.size();
    std::vector<uint8_t> out(m);
    const Result<void> done =
        each_slice(file, [&](size_t, std::span<const uint8_t> bytes) -> Result<void> {
            if (file.codes) {
                for (const uint8_t code : bytes)
                    if (code > 0 && code <= m) out[code - 1U] = 1;
                return {};
            }
            for (size_t i = 0; i * sizeof(float) < bytes.size(); ++i) {
                float share;
                std::memcpy(&share, bytes.data() + i * sizeof(float), sizeof share);
                if (share > 0) out[i % m] = 1;
            }
            return {};
        });
    if (!done) return done.error();
    return out;
}

Result<std::vector<uint8_t>> read_codes(const VoxelFile& file) {
    OPENFAB_CHECK(file.codes);
    std::vector<uint8_t> out;
    const Result<void> done =
        each_slice(file, [&](size_t, std::span<const uint8_t> bytes) -> Result<void> {
            out.insert(out.end(), bytes.begin(), bytes.end());
            return {};
        });
    if (!done) return done.error();
    return out;
}

Result<Voxels> read_voxels(const VoxelFile& file, const Mixture& mixture, bool keep_shares) {
    Voxels out;
    out.size = file.size;
    out.pitch_mm = file.pitch_mm;
    out.origin_mm = file.origin_mm;
    out.materials = file.materials;
    const size_t plane = static_cast<size_t>(file.size[0]) * static_cast<size_t>(file.size[1]);
    const size_t n = plane * static_cast<size_t>(file.size[2]);
    const size_t m = file.materials.size();
    out.share.resize(m);
    for (std::vector<float>* all :
         {&out.lambda, &out.mu, &out.strength, &out.density, &out.conductivity, &out.solid})
        all->resize(n);
    out.code.resize(n);
    const size_t voxel = file.codes ? 1 : m * sizeof(float);
    std::vector<float> shares(m), last(m, -1.F);
    ElementProperties p;
    const auto take = [&](size_t z, std::span<const uint8_t> bytes) -> Result<void> {
        for (size_t i = 0; i < plane; ++i) {
            if (file.codes) {
                std::fill(shares.begin(), shares.end(), 0.F);
                const uint8_t code = bytes[i];
                if (code > m)
                    return user_error(
                        fmt::format(messages::kCodeBeyond, file.file.string(), code, m));
                if (code > 0) shares[code - 1] = 1;
            } else {
                std::memcpy(shares.data(), bytes.data() + i * voxel, voxel);
                for (float& s : shares)
                    s = s > 0 && s <= 1.001F ? s : 0;
            }
            if (keep_shares) out.shares.insert(out.shares.end(), shares.begin(), shares.end());
            // Neighbours are often alike.
            if (shares != last) {
                p = mixture.of(shares);
                last = shares;
            }
            const size_t at = z * plane + i;
            out.lambda[at] = static_cast<float>(p.lambda);
            out.mu[at] = static_cast<float>(p.mu);
            out.strength[at] = static_cast<float>(p.strength);
            out.density[at] = static_cast<float>(p.density);
            out.conductivity[at] = static_cast<float>(p.conductivity);
            float solid = 0;
            for (const float share : shares)
                solid += share;
            out.solid[at] = std::min(solid, 1.F);
            size_t largest = 0;
            for (size_t k = 0; k < m; ++k) {
                out.share[k] += static_cast<double>(shares[k]);
                if (shares[k] > shares[largest]) largest = k;
            }
            out.code[at] = p.mu > 0 ? static_cast<uint8_t>(largest + 1) : uint8_t{0};
        }
        return {};
    };
    if (const Result<void> done = each_slice(file, take); !done) return done.error();
    for (double& s : out.share)
        s /= static_cast<double>(n);
    return out;
}

Voxels halved(const Voxels& v) {
    Voxels out;
    out.origin_mm = v.origin_mm;
    out.materials = v.materials;
    out.share = v.share;
    for (size_t a = 0; a < 3; ++a) {
        out.size[a] = 2 * v.size[a];
        out.pitch_mm[a] = v.pitch_mm[a] / 2;
    }
    const auto width = static_cast<size_t>(v.size[0]), height = static_cast<size_t>(v.size[1]);
    out.make_of(v, [&](const auto& from, auto* to) {
        to->reserve(8 * from.size());
        for (size_t z = 0; z < static_cast<size_t>(out.size[2]); ++z)
            for (size_t y = 0; y < 2 * height; ++y)
                for (size_t x = 0; x < 2 * width; ++x)
                    to->push_back(from[(z / 2 * height + y / 2) * width + x / 2]);
    });
    return out;
}

}  // namespace openfab::mechanics
