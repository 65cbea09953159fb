// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mesh/read/ply.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>

#include "base/large_pages.h"
#include "base/plain_text.h"
#include "base/scan_number.h"
#include "base/text.h"
#include "mesh/model/mesh_memory.h"
#include "mesh/model/messages.h"
#include "mesh/model/polygon.h"
#include "mesh/read/beside_files.h"
#include "mesh/read/messages.h"
#include "mesh/read/ply_columns.h"
#include "mesh/read/ply_header.h"
#include "mesh/read/ply_looks.h"
#include "mesh/read/ply_values.h"

namespace openfab::mesh {
namespace {

constexpr int64_t kMaxCorners = 4096;
constexpr size_t kMaxTriangles = 200'000'000;

class PlyReader {
  public:
    PlyReader(const PlyHeader& header, std::string_view bytes, const std::string& file,
              int64_t memory_bytes)
        : header_(header), values_(bytes, header), file_(file), memory_bytes_(memory_bytes) {
        out_.origin.file = file;
    }

    Result<MeshSource> read() {
        const auto has = [&](const char* name) {
            return std::any_of(header_.elements.begin(), header_.elements.end(),
                               [&](const PlyElement& e) { return e.name == name; });
        };
        const bool has_faces = has("face") || has("tristrips");
        if (!has("vertex") || !has_faces)
            return user_error(
                fmt::format(messages::kNoSuchElement, file_, has_faces ? "vertex" : "face"));
        for (const PlyElement& element : header_.elements) {
            if (element.properties.empty()) continue;
            const bool strips = element.name == "tristrips" && !has("face");
            const bool is_used = element.name == "vertex" || element.name == "face" || strips;
            const Result<void> done = element.name == "vertex" ? vertices(element)
                                      : element.name == "face" ? faces(element)
                                      : strips                 ? read_strips(element)
                                                               : skip(element);
            if (!done) return done.error();
            if (is_used || element.count == 0) continue;
            out_.left_out.push_back(
                {fmt::format("elements `{}`", printable(element.name.substr(0, 40))), file_,
                 messages::kOtherElementsHelp, element.count});
        }
        if (Result<void> fine = check_corners(); !fine) return fine.error();
        if (Result<void> done = triangulate_faces(); !done) return done.error();
        add_ply_looks(header_, &out_);
        return std::move(out_);
    }

  private:
    /// Returns the bytes read so far, before they become triangles.
    int64_t read_bytes() const {
        constexpr size_t kFace = sizeof(size_t) + sizeof(int32_t);
        size_t bytes = out_.mesh.positions.size() * sizeof(Vec3d) + face_ends_.size() * kFace +
                       face_corners_.size() * sizeof(int64_t) +
                       (list_.size() + strip_.size()) * sizeof(double) +
                       uv_corners_.size() * sizeof(int32_t) + uvs_.size() * sizeof(float);
        for (const std::vector<PlyColumn>* columns : {&vertex_columns_, &face_columns_}) {
            for (const PlyColumn& column : *columns)
                bytes += column.values.size() * sizeof(double);
        }
        return static_cast<int64_t>(bytes);
    }

    /// Checked now and then: a few more elements do not matter.
    Result<void> check_memory(int64_t element) const {
        if (element % 1024 != 0) return Ok{};
        const int64_t needed = growing_bytes(read_bytes());
        if (needed <= memory_bytes_) return Ok{};
        return too_large_to_read(file_, static_cast<int64_t>(face_ends_.size()), needed,
                                 memory_bytes_);
    }

    /// Checks that triangles and attributes fit in memory besides what was read.
    Result<void> check_mesh_memory() const {
        MeshCounts counts;
        counts.vertices = static_cast<int64_t>(out_.mesh.positions.size());
        counts.triangles = static_cast<int64_t>(out_.mesh.triangles.size() + face_corners_.size() -
                                                2 * face_ends_.size());
        const auto faces = static_cast<int64_t>(face_ends_.size());
        counts.values = static_cast<int64_t>(uvs_.size()) +
                        static_cast<int64_t>(vertex_columns_.size()) * counts.vertices +
                        static_cast<int64_t>(face_columns_.size()) * (faces + counts.triangles);
        counts.attributes = static_cast<int64_t>(vertex_columns_.size() + face_columns_.size()) + 2;
        const int64_t needed = read_bytes() + growing_bytes(mesh_bytes(counts));
        if (needed <= memory_bytes_) return Ok{};
        return too_large_to_read(file_, counts.triangles, needed, memory_bytes_);
    }

    Error error(const PlyElement& element, int64_t index, const Complaint& wrong) const {
        return header_.ascii
                   ? wrong.at({file_, values_.line(), 1})
                   : wrong.at({fmt::format("{}: {} {}", file_, element.name, index), 0, 0});
    }

    Error face_error(size_t face, const Complaint& wrong) const {
        return header_.ascii ? wrong.at({file_, face_lines_[face], 1})
                             : wrong.at({fmt::format("{}: face {}", file_, face), 0, 0});
    }

    /// Reads a list of at most `most` values.
    Complaint list(const PlyProperty& property, int64_t most, std::vector<double>* out) {
        double length = 0;
        if (Complaint wrong = values_.next(property.count_type, &length); !wrong.empty())
            return wrong;
        const std::string name = property.name.substr(0, 40);
        if (length < 0 || length > static_cast<double>(most)) {
            return fmt::format(messages::kListLength, name, length, most);
        }
        if (length > static_cast<double>(values_.most_left(property.type))) {
            return fmt::format(messages::kListPastEnd, length, name);
        }
        // Twice, since growing copies the list.
        if (2 * length * sizeof(double) > static_cast<double>(memory_bytes_))
            return fmt::format(messages::kListTakesTooMuch, name, length);
        out->resize(static_cast<size_t>(length));
        for (double& value : *out) {
            if (Complaint wrong = values_.next(property.type, &value); !wrong.empty()) return wrong;
        }
        return {};
    }

    /// Reads a property that nothing here uses.
    Complaint pass_over(const PlyProperty& property) {
        if (property.is_list) return list(property, INT32_MAX, &list_);
        double ignored = 0;
        return values_.next(property.type, &ignored);
    }

    Result<void> skip(const PlyElement& element) {
        for (int64_t i = 0; i < element.count; ++i) {
            for (const PlyProperty& property : element.properties) {
                if (const Complaint wrong = pass_over(property); !wrong.empty())
                    return error(element, i, wrong);
            }
        }
        return Ok{};
    }

    Complaint scalar(PlyColumn* column) {
        double value = 0;
        Complaint wrong = values_.next(column->property->type, &value);
        if (!is_position(value, 0, 0)) {
            if (column->odd < 0) column->odd = static_cast<int64_t>(column->values.size());
            value = 0;
        }
        column->values.push_back(value);
        return wrong;
    }

    static std::vector<PlyColumn> columns_of(const PlyElement& element) {
        std::vector<PlyColumn> columns;
        for (const PlyProperty& property : element.properties) {
            const bool position =
                element.name == "vertex" &&
                (property.name == "x" || property.name == "y" || property.name == "z");
            if (!property.is_list && !position) columns.push_back({&property, {}, -1});
        }
        return columns;
    }

    Result<void> vertices(const PlyElement& element) {
        vertex_columns_ = columns_of(element);
        int axes = 0;
        for (const PlyProperty& property : element.properties) {
            if (property.name.size() == 1 && property.name[0] >= 'x' && property.name[0] <= 'z')
                axes += !property.is_list;
        }
        if (axes != 3) return user_error(fmt::format(messages::kVerticesWithoutPositions, file_));
        if (is_plain(element)) return plain_vertices(element);
        for (int64_t i = 0; i < element.count; ++i) {
            Vec3d p;
            size_t column = 0;
            for (const PlyProperty& property : element.properties) {
                Complaint wrong;
                if (property.is_list) {
                    wrong = pass_over(property);
                } else if (column < vertex_columns_.size() &&
                           vertex_columns_[column].property == &property) {
                    wrong = scalar(&vertex_columns_[column++]);
                } else {
                    wrong = values_.next(property.type, &p[property.name[0] - 'x']);
                }
                if (!wrong.empty()) return error(element, i, wrong);
            }
            if (Result<void> fits = check_memory(i); !fits) return fits;
            if (!is_position(p.x, p.y, p.z)) return error(element, i, messages::kPositionTooLarge);
            out_.mesh.positions.push_back(p);
        }
        return Ok{};
    }

    /// Vertices of x, y, z as floats and nothing else, as most large files have them.
    bool is_plain(const PlyElement& element) const {
        if (element.properties.size() != 3) return false;
        for (size_t a = 0; a < 3; ++a) {
            const PlyProperty& p = element.properties[a];
            if (p.name != std::string(1, static_cast<char>('x' + a)) || p.type != PlyType::kFloat32)
                return false;
        }
        return values_.look(static_cast<size_t>(element.count), 12) != nullptr;
    }

    Result<void> plain_vertices(const PlyElement& element) {
        const auto count = static_cast<size_t>(element.count);
        const char* from = values_.look(count, 12);
        values_.pass(count * 12);
        if (static_cast<int64_t>(count * sizeof(Vec3d)) > memory_bytes_) {
            return too_large_to_read(file_, 0, static_cast<int64_t>(count * sizeof(Vec3d)),
                                     memory_bytes_);
        }
        reserve_large(&out_.mesh.positions, count);
        out_.mesh.positions.resize(count);
        for (size_t i = 0; i < count; ++i) {
            float p[3];
            std::memcpy(p, from + 12 * i, sizeof p);
            if (!is_position(p[0], p[1], p[2]))
                return error(element, static_cast<int64_t>(i), messages::kPositionTooLarge);
            out_.mesh.positions[i] = {p[0], p[1], p[2]};
        }
        return Ok{};
    }

    /// Reads faces that are plain triangles, without further properties; returns false, having read
    /// nothing, if they are not.
    bool plain_triangles(const PlyElement& element) {
        const PlyProperty& p = element.properties[0];
        if (element.properties.size() != 1 || p.count_type != PlyType::kUint8 ||
            (p.type != PlyType::kInt32 && p.type != PlyType::kUint32))
            return false;
        const auto count = static_cast<size_t>(element.count);
        const char* from = values_.look(count, 13);
        if (from == nullptr || count > kMaxTriangles) return false;
        if (static_cast<int64_t>(count * sizeof(std::array<int32_t, 3>)) > memory_bytes_)
            return false;  // reported by the general path, which checks the memory
        std::vector<std::array<int32_t, 3>> triangles = large_vector<std::array<int32_t, 3>>(count);
        bool plain = true;
        for (size_t i = 0; i < count && plain; ++i) {
            std::memcpy(triangles[i].data(), from + 13 * i + 1, 12);
            const auto& t = triangles[i];
            // Numbers above INT_MAX or below 0 are reported by the general path.
            plain = from[13 * i] == 3 && (t[0] | t[1] | t[2]) >= 0;
        }
        if (!plain) return false;
        values_.pass(count * 13);
        out_.mesh.triangles = std::move(triangles);
        return true;
    }

    Result<void> faces(const PlyElement& element) {
        face_columns_ = columns_of(element);
        const PlyProperty* corners = nullptr;
        const PlyProperty* uvs = nullptr;
        for (const PlyProperty& p : element.properties) {
            if (p.is_list && (p.name == "vertex_indices" || p.name == "vertex_index")) corners = &p;
            if (p.is_list && p.name == "texcoord") uvs = &p;
        }
        if (corners == nullptr || !is_ply_integer(corners->type))
            return user_error(fmt::format(messages::kFacesWithoutIndices, file_));
        if (plain_triangles(element)) return Ok{};
        for (int64_t i = 0; i < element.count; ++i) {
            size_t column = 0;
            std::vector<double> uv;
            for (const PlyProperty& property : element.properties) {
                Complaint wrong;
                if (&property == corners) {
                    wrong = list(property, kMaxCorners, &list_);
                    // The contents of a list that was cut short were never read.
                    if (!wrong.empty()) return error(element, i, wrong);
                    for (double v : list_)
                        face_corners_.push_back(static_cast<int64_t>(v));
                    face_ends_.push_back(face_corners_.size());
                    if (wrong.empty() && list_.size() < 3) wrong = messages::kFaceBelowThreeCorners;
                } else if (&property == uvs) {
                    wrong = list(property, kMaxCorners * 2, &uv);
                } else if (property.is_list) {
                    wrong = pass_over(property);
                } else {
                    wrong = scalar(&face_columns_[column++]);
                }
                if (!wrong.empty()) return error(element, i, wrong);
            }
            face_lines_.push_back(values_.line());
            if (Result<void> fits = check_memory(i); !fits) return fits;
            if (uvs != nullptr) add_face_uvs(uv);
        }
        has_face_uvs_ = uvs != nullptr;
        return Ok{};
    }

    /// Strips of triangles, each of a vertex and the two before it, turned alternately; -1 begins
    /// another strip.
    Result<void> read_strips(const PlyElement& element) {
        for (int64_t i = 0; i < element.count; ++i) {
            for (const PlyProperty& property : element.properties) {
                Complaint wrong = pass_over(property);
                if (!wrong.empty()) return error(element, i, wrong);
                if (!property.is_list || !property.name.starts_with("vertex_ind")) continue;
                std::swap(strip_, list_);
                const std::vector<double>& strip = strip_;
                size_t begin = 0;
                for (size_t at = 0; at < strip.size(); ++at) {
                    if (strip[at] < 0) {
                        begin = at + 1;
                    } else if (at >= begin + 2) {
                        const size_t turned = (at - begin) % 2;
                        for (const size_t corner : {at - 2 + turned, at - 1 - turned, at})
                            face_corners_.push_back(static_cast<int64_t>(strip[corner]));
                        face_ends_.push_back(face_corners_.size());
                        face_lines_.push_back(values_.line());
                    }
                    if (Result<void> fits = check_memory(static_cast<int64_t>(at)); !fits)
                        return fits;
                }
            }
        }
        return Ok{};
    }

    /// Two numbers per corner, or none, stored as -1 in uv_corners_.
    void add_face_uvs(const std::vector<double>& uv) {
        const size_t begin = face_ends_.size() > 1 ? face_ends_[face_ends_.size() - 2] : 0;
        const size_t corners = face_ends_.back() - begin;
        const bool whole =
            uv.size() == corners * 2 &&
            std::all_of(uv.begin(), uv.end(), [](double v) { return is_position(v, 0, 0); });
        for (size_t c = 0; c < corners; ++c) {
            uv_corners_.push_back(whole ? static_cast<int32_t>(uvs_.size() / 2) : -1);
            if (!whole) continue;
            uvs_.push_back(static_cast<float>(uv[c * 2]));
            uvs_.push_back(static_cast<float>(uv[c * 2 + 1]));
        }
    }

    Result<void> check_corners() const {
        if (face_corners_.size() > kMaxTriangles)
            return user_error(fmt::format(messages::kFileOfTooManyFaces, file_));
        const auto count = static_cast<int64_t>(out_.mesh.positions.size());
        for (size_t t = 0; t < out_.mesh.triangles.size(); ++t) {
            for (const int32_t v : out_.mesh.triangles[t]) {
                if (v >= count)
                    return user_error(
                        fmt::format(messages::kFaceNumberOfNoVertex, file_, t, v, count));
            }
        }
        for (size_t f = 0, c = 0; f < face_ends_.size(); ++f) {
            for (; c < face_ends_[f]; ++c) {
                if (face_corners_[c] >= 0 && face_corners_[c] < count) continue;
                return face_error(f,
                                  fmt::format(messages::kFaceOfNoVertex, face_corners_[c], count));
            }
        }
        return Ok{};
    }

    /// Faces that plain_triangles took are triangles already.
    Result<void> triangulate_faces() {
        if (Result<void> fits = check_mesh_memory(); !fits) return fits;
        int64_t effort = kTriangulationEffort;
        std::vector<int32_t> face_of;  // by triangle
        MeshAttribute uv;
        uv.name = "uv";
        uv.components = 2;
        size_t begin = 0;
        std::vector<Vec3d> points;
        for (size_t f = 0; f < face_ends_.size(); ++f) {
            const size_t count = face_ends_[f] - begin;
            points.clear();
            for (size_t c = begin; c < face_ends_[f]; ++c)
                points.push_back(out_.mesh.positions[face_corners_[c]]);
            const auto add = [&](const std::array<int32_t, 3>& t) {
                const auto at = [&](size_t k) { return begin + static_cast<size_t>(t[k]); };
                const auto vertex = [&](size_t k) {
                    return static_cast<int32_t>(face_corners_[at(k)]);
                };
                out_.mesh.triangles.push_back({vertex(0), vertex(1), vertex(2)});
                if (has_face_uvs_)
                    uv.corners.push_back(
                        {uv_corners_[at(0)], uv_corners_[at(1)], uv_corners_[at(2)]});
                face_of.push_back(static_cast<int32_t>(f));
            };
            if (count == 3) {
                add({0, 1, 2});
            } else {
                const std::vector<std::array<int32_t, 3>> triangles = triangulate(points, &effort);
                if (triangles.empty())
                    return face_error(f, {messages::kTooMuchEffort, messages::kSplitPolygons});
                for (const auto& t : triangles)
                    add(t);
            }
            begin = face_ends_[f];
        }
        if (header_.ascii) {
            for (int32_t f : face_of)
                out_.origin.lines.push_back(face_lines_[f]);
        }
        if (has_face_uvs_) {
            uv.values = std::move(uvs_);
            out_.mesh.attributes.push_back(std::move(uv));
        }
        add_ply_attributes(vertex_columns_, "vertex", out_.mesh.triangles, &out_);
        std::vector<std::array<int32_t, 3>> by_face;
        if (!face_columns_.empty()) {
            for (int32_t f : face_of)
                by_face.push_back({f, f, f});
        }
        add_ply_attributes(face_columns_, "face", by_face, &out_);
        tell_ply_transparency(vertex_columns_, &out_);
        tell_ply_transparency(face_columns_, &out_);
        return Ok{};
    }

    const PlyHeader& header_;
    PlyValues values_;
    const std::string& file_;
    int64_t memory_bytes_;
    MeshSource out_;
    std::vector<PlyColumn> vertex_columns_, face_columns_;
    std::vector<int64_t> face_corners_;  ///< of all faces, one after another
    std::vector<size_t> face_ends_;      ///< into face_corners_
    std::vector<int32_t> face_lines_;
    std::vector<int32_t> uv_corners_;  ///< as face_corners_
    std::vector<float> uvs_;
    bool has_face_uvs_ = false;
    std::vector<double> list_, strip_;
};

}  // namespace

Result<MeshSource> parse_ply(std::string_view bytes, const std::string& file,
                             int64_t memory_bytes) {
    if (const Complaint wide = not_utf8(bytes); !wide.empty()) return wide.at({file, 1, 1});
    const Result<PlyHeader> header = parse_ply_header(bytes, file);
    if (!header) return header.error();
    return PlyReader(*header, bytes, file, memory_bytes).read();
}

Result<void> read_ply_pictures(const std::filesystem::path& file,
                               std::span<const std::string> sources, int64_t memory_bytes,
                               const TakePicture& take) {
    read_beside(file, sources, memory_bytes, take);
    return Ok{};
}

}  // namespace openfab::mesh
