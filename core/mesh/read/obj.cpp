// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mesh/read/obj.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <unordered_set>

#include "base/large_pages.h"
#include "base/own_threads.h"
#include "base/plain_text.h"
#include "mesh/model/mesh_memory.h"
#include "mesh/model/messages.h"
#include "mesh/model/polygon.h"
#include "mesh/read/beside_files.h"
#include "mesh/read/messages.h"
#include "mesh/read/obj_attributes.h"
#include "mesh/read/obj_lines.h"
#include "mesh/read/obj_names.h"
#include "mesh/read/obj_piece.h"

namespace openfab::mesh {
namespace {

/// Text that a thread reads at a time, and pieces that are read before they are joined: what these
/// take beside the mesh is a few times their text.
constexpr size_t kPartBytes = 1 << 18;
constexpr size_t kPartsAtOnce = 16;

/// Joins the pieces of a text in order.
class ObjReader {
  public:
    ObjReader(std::string_view text, const std::string& file, int64_t memory_bytes)
        : text_(text),
          file_(file),
          memory_bytes_(memory_bytes),
          names_(file, memory_bytes / 4, &out_) {}

    Result<MeshSource> read() {
        const std::vector<ObjPart> parts = divide_obj(text_, kPartBytes);
        if (!parts.empty()) {
            ObjCounts all = parts.back().before;
            all.add(parts.back().inside);
            reserve(all);
        }
        std::vector<ObjPiece> pieces;
        for (size_t first = 0; first < parts.size() && !error_; first += kPartsAtOnce) {
            pieces.clear();
            pieces.resize(std::min(kPartsAtOnce, parts.size() - first));
            on_own_threads(pieces.size(), [&](size_t i) {
                pieces[i] = read_obj_piece(text_, parts[first + i], file_);
            });
            for (size_t i = 0; i < pieces.size() && !error_; ++i)
                add(pieces[i]);
        }
        if (error_) return *error_;
        add_attributes();
        out_.mesh = std::move(mesh_);
        out_.origin = {file_, std::move(lines_)};
        if (!out_.mesh.triangles.empty()) names_.finish();
        if (!add_looks()) return *error_;
        tell_left_out();
        if (out_.mesh.triangles.empty() && found(ObjLeftOut::kSurfaces).count > 0) {
            return error_at({file_, found(ObjLeftOut::kSurfaces).line, 1}, messages::kOnlyFreeForm,
                            messages::kOnlyFreeFormHelp);
        }
        return std::move(out_);
    }

  private:
    MeshCounts counts() const {
        MeshCounts out;
        // A quad's diagonal, as a key of a set.
        constexpr size_t kDiagonalVertices = 2;
        out.vertices =
            static_cast<int64_t>(mesh_.positions.size() + diagonals_.size() * kDiagonalVertices);
        out.triangles = static_cast<int64_t>(mesh_.triangles.size());
        out.values = static_cast<int64_t>(uv_.size() + normals_.size() + colors_.size());
        out.attributes = 3;
        out.group_bytes = out_.group_bytes() + names_.bytes();
        return out;
    }

    bool fits(const MeshCounts& counts) {
        const int64_t needed = growing_bytes(mesh_bytes(counts));
        if (needed > memory_bytes_)
            error_ = too_large_to_read(file_, counts.triangles, needed, memory_bytes_);
        return !error_;
    }

    /// A face is a triangle, or more.
    void reserve(const ObjCounts& all) {
        MeshCounts counts;
        counts.vertices = static_cast<int64_t>(all.vertices);
        counts.triangles = static_cast<int64_t>(all.faces);
        counts.values = static_cast<int64_t>(all.uv * 2 + all.normals * 3);
        counts.attributes = 3;
        if (!fits(counts)) return;
        reserve_large(&mesh_.positions, all.vertices);
        reserve_large(&uv_, all.uv * 2);
        reserve_large(&normals_, all.normals * 3);
        reserve_large(&mesh_.triangles, all.faces);
        reserve_large(&uv_corners_, all.faces);
        reserve_large(&normal_corners_, all.faces);
        reserve_large(&lines_, all.faces);
        reserve_large(&out_.face_groups, all.faces);
    }

    template <typename T>
    static void append(const std::vector<T>& from, std::vector<T>* to) {
        to->insert(to->end(), from.begin(), from.end());
    }

    void add(const ObjPiece& piece) {
        if (out_.unit_mm == 0) out_.unit_mm = piece.unit_mm;
        if (!piece.colors.empty()) colors_.resize(mesh_.positions.size() * 3, NAN);
        append(piece.positions, &mesh_.positions);
        append(piece.uv, &uv_);
        append(piece.normals, &normals_);
        append(piece.colors, &colors_);
        for (size_t i = 0; i < left_out_.size(); ++i) {
            if (left_out_[i].count == 0) left_out_[i].line = piece.left_out[i].line;
            left_out_[i].count += piece.left_out[i].count;
        }
        size_t triangles = 0, corners = 0;
        for (const ObjCut& cut : piece.cuts) {
            add_triangles(piece, triangles, cut.triangles);
            triangles = cut.triangles;
            if (error_) return;
            if (cut.corners > 0) {
                add_polygon(cut, &piece.corners[corners]);
                corners += cut.corners;
            } else {
                set_names(cut);
            }
            if (error_ || !fits(counts())) return;
        }
        add_triangles(piece, triangles, piece.triangles.size());
        if (!error_ && fits(counts())) error_ = piece.error;
    }

    void add_triangles(const ObjPiece& piece, size_t begin, size_t end) {
        if (begin == end) return;
        const size_t left = kMaxObjElements - mesh_.triangles.size();
        if (end - begin > left) {
            error_ = error_at({file_, piece.lines[begin + left], 1}, messages::kTooManyFaces);
            return;
        }
        const auto add = [&](const auto& from, auto* to) {
            const auto first = from.begin() + static_cast<std::ptrdiff_t>(begin);
            to->insert(to->end(), first, first + static_cast<std::ptrdiff_t>(end - begin));
        };
        add(piece.triangles, &mesh_.triangles);
        add(piece.uv_corners, &uv_corners_);
        add(piece.normal_corners, &normal_corners_);
        add(piece.lines, &lines_);
        out_.face_groups.insert(out_.face_groups.end(), end - begin, names_.group());
    }

    void fail(const ObjCut& cut, const std::string& what, const std::string& help = {}) {
        ObjLines lines = line_of(cut);
        error_ = error_at(lines.location(lines.tokens()[0], file_), what, help);
    }

    /// The statement of a cut.
    ObjLines line_of(const ObjCut& cut) const {
        ObjLines lines(text_, cut.start, text_.size(), cut.line);
        lines.next();
        return lines;
    }

    void set_names(const ObjCut& cut) {
        const ObjLines line = line_of(cut);
        const std::string_view word = line.tokens()[0];
        const std::string_view rest = line.rest_of_line(word).substr(word.size());
        const Result<void> taken = names_.take(word, rest, line.tokens(), cut.line);
        if (!taken) error_ = taken.error();
    }

    void add_polygon(const ObjCut& cut, const ObjCorner* corners) {
        if (mesh_.triangles.size() >= kMaxObjElements) return fail(cut, messages::kTooManyFaces);
        corners_.assign(corners, corners + cut.corners);
        // Two quads may share both ends of a diagonal; the second uses its other one, or four
        // triangles would meet there.
        if (cut.corners == 4 && !diagonals_.insert(edge_key(corners_[0].v, corners_[2].v)).second) {
            std::rotate(corners_.begin(), corners_.begin() + 1, corners_.end());
            diagonals_.insert(edge_key(corners_[0].v, corners_[2].v));
        }
        std::vector<Vec3d> points;
        for (const ObjCorner& c : corners_)
            points.push_back(mesh_.positions[c.v]);
        const std::vector<std::array<int32_t, 3>> triangles = triangulate(points, &effort_);
        if (triangles.empty()) return fail(cut, messages::kTooMuchEffort, messages::kSplitPolygons);
        for (const auto& t : triangles) {
            const auto at = [&](size_t i) -> const ObjCorner& { return corners_[t[i]]; };
            mesh_.triangles.push_back({at(0).v, at(1).v, at(2).v});
            uv_corners_.push_back({at(0).vt, at(1).vt, at(2).vt});
            normal_corners_.push_back({at(0).vn, at(1).vn, at(2).vn});
            lines_.push_back(cut.line);
            out_.face_groups.push_back(names_.group());
        }
    }

    static uint64_t edge_key(int32_t a, int32_t b) {
        return static_cast<uint64_t>(std::min(a, b)) << 32 | static_cast<uint64_t>(std::max(a, b));
    }

    void add_float(const char* name, int32_t components, std::vector<float> values,
                   std::vector<std::array<int32_t, 3>> corners) {
        MeshAttribute a;
        a.name = name;
        a.components = components;
        a.values = std::move(values);
        a.corners = std::move(corners);
        mesh_.attributes.push_back(std::move(a));
    }

    void add_attributes() {
        if (!uv_.empty()) add_float("uv", 2, std::move(uv_), std::move(uv_corners_));
        if (!normals_.empty()) add_float("n", 3, std::move(normals_), std::move(normal_corners_));
    }

    /// What the looks and the attributes say of each other. The mesh is in out_.
    bool add_looks() {
        MeshCounts all = counts_of(out_);
        all.group_bytes += names_.bytes();
        // Colours beside those as they were read.
        all.values += static_cast<int64_t>(2 * colors_.size());
        all.attributes += colors_.empty() ? 0 : 1;
        if (!fits(all)) return false;
        add_obj_colors(std::move(colors_), file_, &out_);
        constexpr int64_t kMoved = 4 * sizeof(float);  // the values may grow by doubling
        const int64_t left = memory_bytes_ - growing_bytes(mesh_bytes(all));
        if (!move_obj_pictures(names_.materials(), left / kMoved, &out_))
            error_ = too_large_to_read(file_, all.triangles, memory_bytes_ + 1, memory_bytes_);
        drop_plain_look();
        return !error_;
    }

    /// Faces without material and colour have no look.
    void drop_plain_look() {
        for (size_t i = 0; i < out_.looks.size(); ++i) {
            const Look& look = out_.looks[i];
            if (look.is_material || look.vertex_colors) continue;
            const auto at = static_cast<int32_t>(i);
            out_.looks.erase(out_.looks.begin() + at);
            for (FaceGroup& group : out_.groups)
                group.look = group.look == at ? -1 : group.look - (group.look > at ? 1 : 0);
            return;
        }
    }

    const ObjFound& found(ObjLeftOut what) const { return left_out_[static_cast<size_t>(what)]; }

    void tell_left_out() {
        static constexpr struct {
            ObjLeftOut found;
            const char *what, *remedy;
        } kTexts[] = {
            {ObjLeftOut::kNormals, messages::kNormalsMissing, messages::kNormalsMissingHelp},
            {ObjLeftOut::kUv, messages::kCoordinatesMissing, messages::kCoordinatesMissingHelp},
            {ObjLeftOut::kPoints, "points (`p`)", messages::kPointsMadeSolid},
            {ObjLeftOut::kLines, "lines (`l`)", messages::kPointsMadeSolidHelp},
            {ObjLeftOut::kSurfaces, messages::kFreeForm, messages::kFreeFormHelp},
            {ObjLeftOut::kParameters, messages::kPointsOfParameterSpace,
             messages::kExportAsPolygons},
            {ObjLeftOut::kWeights, messages::kWeightsOfVertices, messages::kExportAsPolygons},
            {ObjLeftOut::kMaps, messages::kTextureMapsUsemap, messages::kTextureMapsUsemapHelp},
            {ObjLeftOut::kCalls, messages::kFilesCalled, messages::kFilesCalledHelp},
            {ObjLeftOut::kPolypaint, messages::kLinesOfPolypaint, messages::kLinesOfPolypaintHelp}};
        for (const auto& text : kTexts) {
            const ObjFound& left = found(text.found);
            if (left.count == 0) continue;
            out_.left_out.push_back(
                {text.what, SourceLocation{file_, left.line, 1}.str(), text.remedy, left.count});
        }
    }

    std::string_view text_;
    const std::string& file_;
    int64_t memory_bytes_;
    int64_t effort_ = kTriangulationEffort;
    std::optional<Error> error_;

    MeshSource out_;
    Mesh mesh_;
    std::vector<float> uv_, normals_, colors_;
    std::vector<std::array<int32_t, 3>> uv_corners_, normal_corners_;
    std::vector<int32_t> lines_;  ///< by triangle
    std::vector<ObjCorner> corners_;
    std::unordered_set<uint64_t> diagonals_;  ///< of quads, by their ends
    ObjFindings left_out_;
    ObjNames names_;
};

}  // namespace

Result<MeshSource> parse_obj(std::string_view text, const std::string& file, int64_t memory_bytes) {
    if (const Complaint wide = not_utf8(text); !wide.empty()) return wide.at({file, 1, 1});
    const PlainText plain(text);
    return ObjReader(plain.text(), file, memory_bytes - plain.copied_bytes()).read();
}

Result<void> read_obj_pictures(const std::filesystem::path& file,
                               std::span<const std::string> sources, int64_t memory_bytes,
                               const TakePicture& take) {
    read_beside(file, sources, memory_bytes, take);
    return Ok{};
}

}  // namespace openfab::mesh
