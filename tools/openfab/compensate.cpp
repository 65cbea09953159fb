// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/openfab/compensate.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

#include "backends/common/output_file.h"
#include "backends/raster/npy.h"
#include "base/json.h"
#include "base/say.h"
#include "base/text.h"
#include "base/units.h"
#include "deformation/field.h"
#include "deformation/fit_field.h"
#include "deformation/refine.h"
#include "mesh/load/load_mesh.h"
#include "program/messages.h"
#include "tools/openfab/messages.h"

namespace openfab::tools {

namespace {

namespace fs = std::filesystem;

using deformation::Field;
using deformation::Pair;

constexpr int64_t kMostNodes = 4'000'000;
constexpr size_t kMostTriangles = 5'000'000;

bool is_points(const std::string& file) {
    return file.ends_with(".csv") || file.ends_with(".txt");
}

/// Reads lines of six numbers: where it should be, and where it was found. Those that begin with # or a letter
/// are none.
Result<std::vector<Pair>> read_points(const std::string& file) {
    constexpr int64_t kLargest = 500'000'000;
    const Result<std::string> text = read_text_file(file, kLargest);
    if (!text) return text.error();
    std::vector<Pair> out;
    size_t begin = 0;
    for (int32_t line = 1; begin < text->size(); ++line) {
        const size_t end = std::min(text->find('\n', begin), text->size());
        const char* at = text->data() + begin;
        const char* const stop = text->data() + end;
        begin = end + 1;
        std::array<double, 6> numbers{};
        size_t count = 0;
        bool fine = true;
        const auto is_gap = [](char c) {
            return c == ' ' || c == ',' || c == ';' || c == '\t' || c == '\r';
        };
        while (at < stop && is_gap(*at))
            ++at;
        if (at == stop || *at == '#' || std::isalpha(static_cast<unsigned char>(*at)) != 0)
            continue;
        while (at < stop && fine) {
            double number = 0;
            const auto read = std::from_chars(at, stop, number);
            fine = read.ec == std::errc() && count < 6 && std::isfinite(number) &&
                   std::fabs(number) < 1e6;
            if (fine) numbers[count++] = number;
            at = read.ptr;
            while (at < stop && is_gap(*at))
                ++at;
        }
        if (!fine || count != 6) {
            Error error = user_error(messages::kNotSixNumbers);
            error.location = {file, line, 1};
            return error;
        }
        out.push_back({{numbers[0], numbers[1], numbers[2]}, {numbers[3], numbers[4], numbers[5]}});
    }
    return out;
}

Result<mesh::Mesh> read_mesh(const std::string& file, int64_t memory) {
    mesh::MeshOptions options;
    options.name = fs::path(file).stem().string();
    options.memory_bytes = memory;
    Result<mesh::LoadedMesh> loaded = mesh::load_mesh(file, options);
    if (!loaded) return loaded.error();
    return std::move(loaded->mesh);
}

Vec3d cross(const Vec3d& a, const Vec3d& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

double dot(const Vec3d& a, const Vec3d& b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

/// The measured surface, as places with normals in boxes of a grid.
class Found {
  public:
    Found(const deformation::Surface& surface, double box_mm)
        : positions_(surface.positions), normals_(surface.positions.size()), box_mm_(box_mm) {
        for (const auto& t : surface.triangles) {
            const Vec3d& a = positions_[static_cast<size_t>(t[0])];
            const Vec3d n = cross(positions_[static_cast<size_t>(t[1])] - a,
                                  positions_[static_cast<size_t>(t[2])] - a);
            for (const int32_t corner : t)
                normals_[static_cast<size_t>(corner)] = normals_[static_cast<size_t>(corner)] + n;
        }
        for (size_t i = 0; i < positions_.size(); ++i)
            boxes_[key(box_of(positions_[i]))].push_back(i);
    }

    /// Returns the place on the surface that belongs to `p` with the normal `n`, within two boxes: the
    /// nearest whose normal agrees, along its normal.
    std::optional<Vec3d> near(const Vec3d& p, const Vec3d& n) const {
        const Vec3i box = box_of(p);
        double least = 4 * box_mm_ * box_mm_;
        std::optional<size_t> best;
        for (int32_t z = box.z - 2; z <= box.z + 2; ++z) {
            for (int32_t y = box.y - 2; y <= box.y + 2; ++y) {
                for (int32_t x = box.x - 2; x <= box.x + 2; ++x) {
                    const auto here = boxes_.find(key({x, y, z}));
                    if (here == boxes_.end()) continue;
                    for (const size_t i : here->second) {
                        const Vec3d d = positions_[i] - p;
                        if (dot(d, d) >= least) continue;
                        const double agree = dot(normals_[i], n);
                        if (agree < 0.7 * std::sqrt(dot(normals_[i], normals_[i]) * dot(n, n)))
                            continue;
                        least = dot(d, d);
                        best = i;
                    }
                }
            }
        }
        if (!best) return std::nullopt;
        const Vec3d& m = normals_[*best];
        return p + m * (dot(positions_[*best] - p, m) / dot(m, m));
    }

  private:
    Vec3i box_of(const Vec3d& p) const {
        return {static_cast<int32_t>(std::floor(p.x / box_mm_)),
                static_cast<int32_t>(std::floor(p.y / box_mm_)),
                static_cast<int32_t>(std::floor(p.z / box_mm_))};
    }
    static uint64_t key(const Vec3i& box) {
        constexpr uint64_t kMask = (1 << 21) - 1;
        return (static_cast<uint64_t>(box.x) & kMask) << 42 |
               (static_cast<uint64_t>(box.y) & kMask) << 21 |
               (static_cast<uint64_t>(box.z) & kMask);
    }

    const std::vector<Vec3d>& positions_;
    std::vector<Vec3d> normals_;  ///< times twice the areas of their triangles
    double box_mm_;
    std::unordered_map<uint64_t, std::vector<size_t>> boxes_;
};

Result<std::vector<Pair>> pairs_of_meshes(const mesh::Mesh& nominal, const mesh::Mesh& measured,
                                          double cell_mm) {
    std::vector<Pair> out;
    if (nominal.positions.size() == measured.positions.size() &&
        nominal.triangles == measured.triangles) {
        for (size_t i = 0; i < nominal.positions.size(); ++i)
            out.push_back({nominal.positions[i], measured.positions[i]});
        return out;
    }
    constexpr double kFine = 1.0 / 12;
    deformation::Surface wanted{nominal.positions, nominal.triangles, {}};
    deformation::Surface got{measured.positions, measured.triangles, {}};
    if (!deformation::refine(cell_mm / 4, kMostTriangles, &wanted) ||
        !deformation::refine(cell_mm * kFine, kMostTriangles, &got)) {
        return user_error(fmt::format(messages::kMeshesTooLargeForCells, cell_mm),
                          messages::kGiveLargerCell);
    }
    const Found found(got, cell_mm / 2);
    size_t lost = 0;
    for (const auto& t : wanted.triangles) {
        const Vec3d &a = wanted.positions[static_cast<size_t>(t[0])],
                    &b = wanted.positions[static_cast<size_t>(t[1])],
                    &c = wanted.positions[static_cast<size_t>(t[2])];
        const Vec3d middle = (a + b + c) * (1.0 / 3);
        const std::optional<Vec3d> place = found.near(middle, cross(b - a, c - a));
        if (place)
            out.push_back({middle, *place});
        else
            ++lost;
    }
    note(fmt::format(messages::kMeshesDiffer, out.size(), out.size() + lost));
    return out;
}

/// Sets nodes around the pairs, half a cell beyond them.
Result<Field> grid_around(const std::vector<Pair>& pairs, double cell_mm) {
    Box3d box;
    for (const Pair& pair : pairs)
        box.add(pair.nominal_mm);
    Field field;
    int64_t nodes = 1;
    for (int axis = 0; axis < 3; ++axis) {
        const double cells = std::ceil((box.hi[axis] - box.lo[axis]) / cell_mm);
        field.nodes[axis] = static_cast<int32_t>(std::min(cells, 1e6)) + 2;
        const double size = (field.nodes[axis] - 1) * cell_mm;
        field.origin_mm[axis] = 0.5 * (box.hi[axis] + box.lo[axis] - size);
        nodes = std::min(nodes * field.nodes[axis], kMostNodes + 1);
    }
    if (nodes > kMostNodes) {
        return user_error(fmt::format(messages::kTooManyFieldNodes, cell_mm, kMostNodes),
                          messages::kGiveLargerCell);
    }
    field.spacing_mm = {cell_mm, cell_mm, cell_mm};
    return field;
}

Result<void> write_field(const Field& field, const std::string& output) {
    const fs::path file(output);
    std::string stem = file.filename().string();
    stem = stem.substr(0, stem.size() - std::string(".json").size());
    const std::array<int64_t, 4> shape{field.nodes.z, field.nodes.y, field.nodes.x, 3};
    std::vector<uint8_t> bytes = raster::npy_header("<f4", shape);
    for (const Vec3d& u : field.u_mm) {
        for (int axis = 0; axis < 3; ++axis) {
            const auto value = static_cast<float>(u[axis]);
            const auto* raw = reinterpret_cast<const uint8_t*>(&value);
            bytes.insert(bytes.end(), raw, raw + sizeof value);
        }
    }
    const std::string array = stem + ".npy";
    const Result<void> written =
        backends::write_whole_file(fs::path(file).replace_filename(array), bytes);
    if (!written) return written;
    // The corner of the lowest node's cell.
    const Vec3d corner = field.origin_mm - field.spacing_mm * 0.5;
    const Vec3d& cell = field.spacing_mm;
    return backends::write_whole_file(
        file, fmt::format("{{\n    \"file\": \"{}\",\n    \"origin_mm\": [{}, {}, {}],\n    "
                          "\"spacing_mm\": [{}, {}, {}],\n    \"apply\": \"inverse\"\n}}\n",
                          array, corner.x, corner.y, corner.z, cell.x, cell.y, cell.z));
}

}  // namespace

Result<void> run_compensate(const CompensateArguments& arguments) {
    const Result<int64_t> memory = parse_memory_option(arguments.memory);
    if (!memory) return memory.error();
    if (!arguments.output.ends_with(".json"))
        return usage_error(fmt::format(messages::kFieldNameEnds, arguments.output));
    double cell_mm = 0;
    if (!arguments.cell.empty()) {
        const Result<double> cell = parse_length_mm(arguments.cell);
        if (!cell)
            return usage_error(
                fmt::format(program::messages::kOfOption, "--cell", cell.error().text()));
        if (!(*cell > 0))
            return usage_error(fmt::format(messages::kCellNotALength, arguments.cell));
        cell_mm = *cell;
    }
    double smoothness = 1e-3;
    if (!arguments.smoothness.empty()) {
        const std::string& text = arguments.smoothness;
        const auto read = std::from_chars(text.data(), text.data() + text.size(), smoothness);
        if (read.ec != std::errc() || read.ptr != text.data() + text.size() || !(smoothness > 0))
            return usage_error(fmt::format(messages::kSmoothNotANumber, text));
    }
    std::vector<Pair> pairs;
    const auto usual_cell = [&](const Box3d& box) {
        constexpr double kCells = 12;
        const Vec3d size = box.size();
        if (cell_mm == 0) cell_mm = std::max({size.x, size.y, size.z, 1e-3}) / kCells;
    };
    if (arguments.measured.empty()) {
        if (!is_points(arguments.nominal)) {
            return usage_error(
                fmt::format(messages::kMeasurementMissing, printable(arguments.nominal)));
        }
        Result<std::vector<Pair>> read = read_points(arguments.nominal);
        if (!read) return read.error();
        pairs = std::move(*read);
        Box3d box;
        for (const Pair& pair : pairs)
            box.add(pair.nominal_mm);
        if (!pairs.empty()) usual_cell(box);
    } else {
        const Result<mesh::Mesh> nominal = read_mesh(arguments.nominal, *memory / 2);
        if (!nominal) return nominal.error();
        const Result<mesh::Mesh> measured = read_mesh(arguments.measured, *memory / 2);
        if (!measured) return measured.error();
        Box3d box;
        for (const Vec3d& p : nominal->positions)
            box.add(p);
        usual_cell(box);
        Result<std::vector<Pair>> made = pairs_of_meshes(*nominal, *measured, cell_mm);
        if (!made) return made.error();
        pairs = std::move(*made);
    }
    constexpr size_t kFewest = 4;
    if (pairs.size() < kFewest) {
        return user_error(fmt::format(messages::kTooFewPlaces, pairs.size(), kFewest));
    }
    Result<Field> field = grid_around(pairs, cell_mm);
    if (!field) return field.error();
    double before = 0, largest = 0;
    for (const Pair& pair : pairs) {
        const Vec3d d = pair.measured_mm - pair.nominal_mm;
        before += dot(d, d);
        largest = std::max(largest, std::sqrt(dot(d, d)));
    }
    before = std::sqrt(before / static_cast<double>(pairs.size()));
    const double left = deformation::fit_field(pairs, smoothness, &*field);
    show(fmt::format(messages::kFieldMade, pairs.size(), before, largest, field->nodes.x,
                     field->nodes.y, field->nodes.z, left));
    if (left > 0.5 * before) note(messages::kFieldExplainsLittle);
    return write_field(*field, arguments.output);
}

}  // namespace openfab::tools
