// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mesh/read/beams_npz.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "base/at.h"
#include "base/near_miss.h"
#include "mesh/read/messages.h"
#include "mesh/read/npy_array.h"
#include "mesh/read/zip_file.h"

namespace openfab::mesh {

namespace {

constexpr double kFarthest = 1e6;
constexpr size_t kMostAttributes = 64;

class BeamsNpz {
  public:
    BeamsNpz(const ZipFile& zip, std::string file, int64_t memory_bytes)
        : zip_(zip), file_(std::move(file)), memory_left_(memory_bytes) {}

    Result<ReadBeams> read() {
        nodes();
        if (!error_) struts();
        if (!error_) radii();
        if (!error_) attributes();
        if (!error_) warn_of_unused();
        if (error_) return *error_;
        return std::move(out_);
    }

  private:
    Beams& beams() { return out_.beams; }

    void fail(const std::string& array, const std::string& what, const std::string& help = {}) {
        if (!error_)
            error_ = error_at({file_, 0, 0}, fmt::format("array `{}`: {}", array, what), help);
    }

    /// Reads an array into `bytes`, of which `out` is a view.
    bool open(const std::string& name, std::string* bytes, NpyArray* out) {
        if (!zip_.has(name + ".npy")) {
            std::vector<std::string> names;
            for (const std::string& one : zip_.names())
                names.push_back(one.ends_with(".npy") ? one.substr(0, one.size() - 4) : one);
            fail(name, messages::kNotInArchive, suggest(name, names));
            return false;
        }
        Result<std::string> read = zip_.read(name + ".npy", std::max<int64_t>(memory_left_, 0));
        if (!read) {
            error_ = read.error();
            return false;
        }
        *bytes = std::move(*read);
        const Complaint wrong = NpyArray::parse(*bytes, out);
        if (!wrong.empty()) fail(name, wrong.what, wrong.help);
        return wrong.empty();
    }

    bool take(const std::string& name, size_t bytes) {
        memory_left_ -= static_cast<int64_t>(bytes);
        if (memory_left_ < 0)
            fail(name, messages::kMoreMemoryThanAllowed, messages::kAllowMoreMemory);
        return memory_left_ >= 0;
    }

    void nodes() {
        std::string bytes;
        NpyArray array;
        if (!open("nodes", &bytes, &array)) return;
        if (array.shape().size() != 2 || array.shape()[1] != 3 || array.shape()[0] > kMostBeams)
            return fail("nodes", fmt::format(messages::kNodesShape, array.shape_text()),
                        messages::kNodesShapeHelp);
        const int64_t n = array.shape()[0];
        if (!take("nodes", static_cast<size_t>(n) * sizeof(Vec3d))) return;
        beams().nodes.resize(static_cast<size_t>(n));
        for (int64_t i = 0; i < n; ++i) {
            for (int a = 0; a < 3; ++a) {
                const double x = array.at(3 * i + a);
                if (!(std::fabs(x) <= kFarthest))
                    return fail("nodes", fmt::format(messages::kNodeTooFar, i, x, kFarthest));
                at(beams().nodes, i)[a] = x;
            }
        }
    }

    void struts() {
        std::string bytes;
        NpyArray array;
        if (!open("struts", &bytes, &array)) return;
        if (array.shape().size() != 2 || array.shape()[1] != 2 || array.shape()[0] > kMostBeams ||
            array.is_float())
            return fail("struts",
                        fmt::format(messages::kStrutsShape, array.shape_text(),
                                    array.is_float() ? messages::kOfFloats : ""),
                        messages::kOfFloatsHelp);
        const int64_t m = array.shape()[0];
        if (m == 0) return fail("struts", messages::kArrayEmpty);
        if (!take("struts", static_cast<size_t>(m) * sizeof(Beam))) return;
        beams().beams.resize(static_cast<size_t>(m));
        for (int64_t i = 0; i < m; ++i) {
            for (size_t e = 0; e < 2; ++e) {
                const double node = array.at(2 * i + static_cast<int64_t>(e));
                if (!(node >= 0 && node < static_cast<double>(beams().nodes.size())))
                    return fail("struts", fmt::format(messages::kStrutOfUnknownNode, i, node,
                                                      beams().nodes.size()));
                at(beams().beams, i).nodes[e] = static_cast<int32_t>(node);
            }
        }
    }

    void radii() {
        std::string bytes;
        NpyArray array;
        if (!open("radii", &bytes, &array)) return;
        const auto n = static_cast<int64_t>(beams().nodes.size());
        const auto m = static_cast<int64_t>(beams().beams.size());
        const std::vector<int64_t>& shape = array.shape();
        const bool one = array.size() == 1 && shape.size() <= 1;
        const bool of_nodes = !one && shape.size() == 1 && shape[0] == n;
        const bool of_ends = shape.size() == 2 && shape[0] == m && shape[1] == 2;
        if (!one && !of_nodes && !of_ends)
            return fail("radii", fmt::format(messages::kNodesShape, array.shape_text()),
                        fmt::format(messages::kRadiiShape, n, m));
        for (int64_t i = 0; i < array.size(); ++i) {
            const double r = array.at(i);
            if (!(r >= 0 && r <= kFarthest))
                return fail("radii", fmt::format(messages::kRadiusWrong, r), messages::kRadiusHelp);
        }
        for (int64_t i = 0; i < m; ++i) {
            Beam& beam = at(beams().beams, i);
            for (size_t e = 0; e < 2; ++e) {
                const int64_t at = one        ? 0
                                   : of_nodes ? beam.nodes[e]
                                              : 2 * i + static_cast<int64_t>(e);
                beam.radii[e] = static_cast<float>(array.at(at));
            }
            if (beam.nodes[0] == beam.nodes[1]) {
                if (beam.radii[0] != beam.radii[1])
                    return fail("radii", fmt::format(messages::kStrutOfTwoRadii, i, beam.nodes[0]));
            }
            if (!(beam.radii[0] > 0 || beam.radii[1] > 0))
                return fail("radii", fmt::format(messages::kStrutWithoutRadius, i));
        }
    }

    void attributes() {
        for (const std::string& entry : zip_.names()) {
            if (!entry.ends_with(".npy")) {
                out_.warnings.push_back(
                    fmt::format(messages::kNoArrayLeftOut, file_, entry.substr(0, 80)));
                continue;
            }
            const std::string name = entry.substr(0, entry.size() - 4);
            if (name == "nodes" || name == "struts" || name == "radii") continue;
            std::string bytes;
            NpyArray array;
            if (!open(name, &bytes, &array)) return;
            attribute(name, array);
            if (error_) return;
        }
    }

    void attribute(const std::string& name, const NpyArray& array) {
        const auto n = static_cast<int64_t>(beams().nodes.size());
        const auto m = static_cast<int64_t>(beams().beams.size());
        const std::vector<int64_t>& shape = array.shape();
        const int64_t components = shape.size() == 2 ? shape[1] : 1;
        const bool of_nodes =
            array.is_float() && !shape.empty() && shape.size() <= 2 && shape[0] == n;
        const bool of_struts = !array.is_float() && shape.size() == 1 && shape[0] == m;
        if ((!of_nodes && !of_struts) || components < 1 || components > 4)
            return fail(name,
                        fmt::format(messages::kAttributeShape, array.shape_text(),
                                    array.is_float() ? "floats" : "integers"),
                        fmt::format(messages::kAttributeShapeHelp, n, n, m));
        if (beams().attributes.size() == kMostAttributes)
            return fail(name, fmt::format(messages::kMoreThanAttributes, kMostAttributes));
        if (!take(name, static_cast<size_t>(array.size()) * sizeof(float))) return;
        BeamAttribute made;
        made.name = name;
        made.is_int = of_struts;
        made.components = static_cast<int32_t>(components);
        for (int64_t i = 0; i < array.size(); ++i) {
            const double value = array.at(i);
            const bool fits =
                of_struts
                    ? std::fabs(value) <= 2147483647.0
                    : std::fabs(value) <= static_cast<double>(std::numeric_limits<float>::max());
            if (!fits) return fail(name, fmt::format(messages::kValueNotFiniteTooLarge, value));
            if (of_struts) {
                made.ints.push_back(static_cast<int32_t>(value));
            } else {
                made.values.push_back(static_cast<float>(value));
            }
        }
        beams().attributes.push_back(std::move(made));
    }

    void warn_of_unused() {
        std::vector<bool> used(beams().nodes.size(), false);
        for (const Beam& beam : beams().beams) {
            for (const int32_t node : beam.nodes)
                used[static_cast<size_t>(node)] = true;
        }
        const auto unused = std::ranges::count(used, false);
        if (unused > 0)
            out_.warnings.push_back(
                fmt::format(messages::kNodesWithoutStrut, file_, unused, used.size()));
    }

    const ZipFile& zip_;
    const std::string file_;
    int64_t memory_left_;
    ReadBeams out_;
    std::optional<Error> error_;
};

}  // namespace

Result<ReadBeams> parse_beams_npz(std::string_view bytes, const std::string& file,
                                  int64_t memory_bytes) {
    const Result<ZipFile> zip = ZipFile::open(bytes, file);
    if (!zip) return zip.error();
    return BeamsNpz(*zip, file, memory_bytes - static_cast<int64_t>(bytes.size())).read();
}

}  // namespace openfab::mesh
