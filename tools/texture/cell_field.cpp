// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/texture/cell_field.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include "tools/texture/check_memory.h"
#include "tools/texture/messages.h"

namespace openfab::tools {

namespace {

constexpr size_t kMostCorners = 8;

/// Shape functions and their derivatives at a point of the reference cell.
struct Shape {
    std::array<double, kMostCorners> value{};
    std::array<Vec3d, kMostCorners> gradient{};
};

Shape tetrahedron(const Vec3d& r) {
    Shape s;
    s.value = {1 - r.x - r.y - r.z, r.x, r.y, r.z};
    s.gradient = {Vec3d{-1, -1, -1}, Vec3d{1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0, 0, 1}};
    return s;
}

/// Bit a of `places[i]` says at which end of axis a corner i lies.
Shape trilinear(const Vec3d& r, const std::array<unsigned, 8>& places) {
    Shape s;
    for (size_t i = 0; i < 8; ++i) {
        std::array<double, 3> f{}, d{};
        for (unsigned a = 0; a < 3; ++a) {
            const bool high = (places[i] >> a & 1) != 0;
            f[a] = high ? r[static_cast<int>(a)] : 1 - r[static_cast<int>(a)];
            d[a] = high ? 1 : -1;
        }
        s.value[i] = f[0] * f[1] * f[2];
        s.gradient[i] = {d[0] * f[1] * f[2], f[0] * d[1] * f[2], f[0] * f[1] * d[2]};
    }
    return s;
}

Shape wedge(const Vec3d& r) {
    const std::array<double, 3> plane{1 - r.x - r.y, r.x, r.y};
    constexpr std::array<double, 3> kAlongX{-1, 1, 0}, kAlongY{-1, 0, 1};
    Shape s;
    for (size_t i = 0; i < 6; ++i) {
        const double height = i < 3 ? 1 - r.z : r.z;
        const size_t k = i % 3;
        s.value[i] = plane[k] * height;
        s.gradient[i] = {kAlongX[k] * height, kAlongY[k] * height, i < 3 ? -plane[k] : plane[k]};
    }
    return s;
}

Shape shape(CellType type, const Vec3d& r) {
    constexpr std::array<unsigned, 8> kHexahedron{0, 1, 3, 2, 4, 5, 7, 6};
    constexpr std::array<unsigned, 8> kVoxel{0, 1, 2, 3, 4, 5, 6, 7};
    switch (type) {
        case CellType::kTetrahedron:
            return tetrahedron(r);
        case CellType::kVoxel:
            return trilinear(r, kVoxel);
        case CellType::kHexahedron:
            return trilinear(r, kHexahedron);
        case CellType::kWedge:
            break;
    }
    return wedge(r);
}

Vec3d middle(CellType type) {
    switch (type) {
        case CellType::kTetrahedron:
            return {0.25, 0.25, 0.25};
        case CellType::kWedge:
            return {1.0 / 3, 1.0 / 3, 0.5};
        case CellType::kVoxel:
        case CellType::kHexahedron:
            break;
    }
    return {0.5, 0.5, 0.5};
}

/// A point of the reference cell near `r`; `r` itself where it lies in the cell.
Vec3d inside_of(CellType type, const Vec3d& r) {
    Vec3d out{std::clamp(r.x, 0.0, 1.0), std::clamp(r.y, 0.0, 1.0), std::clamp(r.z, 0.0, 1.0)};
    const bool flat = type == CellType::kWedge;
    if (!flat && type != CellType::kTetrahedron) return out;
    const double sum = out.x + out.y + (flat ? 0 : out.z);
    if (sum <= 1) return out;
    out = {out.x / sum, out.y / sum, flat ? out.z : out.z / sum};
    return out;
}

/// One cell with its corners at hand.
struct Cell {
    CellType type = CellType::kTetrahedron;
    size_t count = 0;
    std::array<Vec3d, kMostCorners> at{};
    Box3d box;

    Vec3d map(const Shape& s) const {
        Vec3d out{};
        for (size_t i = 0; i < count; ++i)
            out = out + at[i] * s.value[i];
        return out;
    }

    /// Finds the point of the reference cell that lies at `p`, by Newton's method; one step where the
    /// cell's map is affine. Returns false where it does not converge.
    bool find(const Vec3d& p, Vec3d* r) const {
        constexpr int kMostSteps = 30;
        constexpr double kDone = 1e-13, kFar = 100;
        const bool is_affine = type == CellType::kTetrahedron || type == CellType::kVoxel;
        *r = middle(type);
        for (int step = 0; step < kMostSteps; ++step) {
            const Shape s = shape(type, *r);
            std::array<Vec3d, 3> along{};
            for (size_t i = 0; i < count; ++i) {
                along[0] = along[0] + at[i] * s.gradient[i].x;
                along[1] = along[1] + at[i] * s.gradient[i].y;
                along[2] = along[2] + at[i] * s.gradient[i].z;
            }
            const Vec3d off = p - map(s);
            const double volume = dot(along[0], cross(along[1], along[2]));
            const Vec3d by =
                Vec3d{dot(off, cross(along[1], along[2])), dot(off, cross(along[2], along[0])),
                      dot(off, cross(along[0], along[1]))} *
                (1 / volume);
            *r = *r + by;
            const double most = std::max({std::abs(by.x), std::abs(by.y), std::abs(by.z)});
            const double reach = std::max({std::abs(r->x), std::abs(r->y), std::abs(r->z)});
            if (!(most < kFar && reach < kFar)) return false;  // or not a number: it is flat here
            if (is_affine || most <= kDone * (1 + reach)) return true;
        }
        return false;
    }
};

class CellReader final : public VolumeReader {
  public:
    CellMesh mesh;
    ResampledBox box;
    float outside = 0;

    /// Finds where each cell's corners begin, and the order of cells by their lowest slices.
    void prepare() {
        begins_.resize(mesh.types.size());
        std::vector<int32_t> first(mesh.types.size());
        int64_t at = 0;
        for (size_t i = 0; i < mesh.types.size(); ++i) {
            begins_[i] = at;
            at += corner_count(static_cast<int>(mesh.types[i]));
            first[i] = slices(cell(i).box)[0];
        }
        order_.resize(mesh.types.size());
        std::iota(order_.begin(), order_.end(), 0);
        std::stable_sort(order_.begin(), order_.end(), [&](int32_t a, int32_t b) {
            return first[static_cast<size_t>(a)] < first[static_cast<size_t>(b)];
        });
        lows_.assign(static_cast<size_t>(channels), std::numeric_limits<float>::max());
        highs_.assign(static_cast<size_t>(channels), std::numeric_limits<float>::lowest());
        for (size_t i = 0; i < mesh.values.size(); ++i) {
            const size_t c = i % static_cast<size_t>(channels);
            lows_[c] = std::min(lows_[c], mesh.values[i]);
            highs_[c] = std::max(highs_[c], mesh.values[i]);
        }
    }

    Result<void> read_slice(int32_t z, float* out, const Wrote& wrote) override {
        const int64_t texels = int64_t{size.x} * size.y;
        owners_.assign(static_cast<size_t>(texels), Owner{});
        std::fill_n(out, slice_floats(), outside);
        for (; next_ < order_.size() && slices(cell(at_order(next_)).box)[0] <= z; ++next_)
            active_.push_back(order_[next_]);
        std::erase_if(active_,
                      [&](int32_t i) { return slices(cell(static_cast<size_t>(i)).box)[1] < z; });
        // First what lies in a cell, most of all texels: about the others the cells are asked again.
        for (const int32_t i : active_)
            fill(i, z, kOwn, out);
        for (const int32_t i : active_)
            fill(i, z, kReach, out);
        wrote(4 * slice_floats());
        return {};
    }

  private:
    /// The cell that a texel has its value of: the first that holds its centre, else the nearest.
    struct Owner {
        double distance = std::numeric_limits<double>::infinity();
        int32_t cell = std::numeric_limits<int32_t>::max();
    };
    static constexpr double kReach = 2;  ///< of the values outside, in texels
    static constexpr double kOwn =
        1e-3;  ///< around a cell, for what rounding puts just outside of it

    size_t at_order(size_t i) const { return static_cast<size_t>(order_[i]); }

    Cell cell(size_t i) const {
        Cell out;
        out.type = mesh.types[i];
        out.count = static_cast<size_t>(corner_count(static_cast<int>(out.type)));
        for (size_t k = 0; k < out.count; ++k) {
            const size_t p = 3 * static_cast<size_t>(point(i, k));
            out.at[k] = {mesh.points[p], mesh.points[p + 1], mesh.points[p + 2]};
            out.box.add(out.at[k]);
        }
        return out;
    }
    int32_t point(size_t cell, size_t corner) const {
        return mesh.corners[static_cast<size_t>(begins_[cell]) + corner];
    }

    /// First and last index of texels whose centres lie within `reach` texels of the box.
    std::array<int32_t, 2> range(const Box3d& of, int axis, double reach) const {
        const double low = (of.lo[axis] - box.origin[axis]) / box.pitch_mm - 0.5 - reach;
        const double high = (of.hi[axis] - box.origin[axis]) / box.pitch_mm - 0.5 + reach;
        const double last = box.size[axis] - 1;
        return {static_cast<int32_t>(std::clamp(std::ceil(low), 0.0, last)),
                static_cast<int32_t>(std::clamp(std::floor(high), 0.0, last))};
    }
    std::array<int32_t, 2> slices(const Box3d& of) const { return range(of, 2, kReach); }

    /// Gives a cell the texels of a slice within `reach` of its box, as far as they have no better one.
    void fill(int32_t index, int32_t z, double reach, float* out) {
        const Cell c = cell(static_cast<size_t>(index));
        const std::array<int32_t, 2> zs = range(c.box, 2, reach);
        if (z < zs[0] || z > zs[1]) return;
        const std::array<int32_t, 2> xs = range(c.box, 0, reach), ys = range(c.box, 1, reach);
        for (int32_t y = ys[0]; y <= ys[1]; ++y) {
            for (int32_t x = xs[0]; x <= xs[1]; ++x) {
                const int64_t texel = int64_t{y} * size.x + x;
                Owner& owner = owners_[static_cast<size_t>(texel)];
                if (owner.distance == 0 && owner.cell < index) continue;
                const Vec3d p = box.center(x, y, z);
                Vec3d r;
                if (!c.find(p, &r)) continue;
                const Vec3d near = inside_of(c.type, r), off = r - near;
                constexpr double kOnFace = 1e-9;
                const bool inside =
                    std::max({std::abs(off.x), std::abs(off.y), std::abs(off.z)}) <= kOnFace;
                const double distance =
                    inside ? 0 : length(p - c.map(shape(c.type, near))) / box.pitch_mm;
                if (!(distance < kReach)) continue;
                if (distance > owner.distance || (distance == owner.distance && index > owner.cell))
                    continue;
                owner = {distance, index};
                value(static_cast<size_t>(index), c, r, out + texel * channels);
            }
        }
    }

    void value(size_t index, const Cell& c, const Vec3d& r, float* out) const {
        const Shape s = shape(c.type, r);
        for (int32_t channel = 0; channel < channels; ++channel) {
            double sum = 0;
            if (mesh.of_points) {
                for (size_t k = 0; k < c.count; ++k)
                    sum += s.value[k] * number(static_cast<size_t>(point(index, k)), channel);
            } else {
                sum = number(index, channel);
            }
            const auto at = static_cast<size_t>(channel);
            out[channel] = std::clamp(static_cast<float>(sum), lows_[at], highs_[at]);
        }
    }
    double number(size_t item, int32_t channel) const {
        return static_cast<double>(
            mesh.values[item * static_cast<size_t>(channels) + static_cast<size_t>(channel)]);
    }

    std::vector<int64_t> begins_;
    std::vector<int32_t> order_, active_;
    size_t next_ = 0;  ///< in order_
    std::vector<Owner> owners_;
    std::vector<float> lows_, highs_;
};

}  // namespace

int corner_count(int type) {
    switch (type) {
        case static_cast<int>(CellType::kTetrahedron):
            return 4;
        case static_cast<int>(CellType::kVoxel):
        case static_cast<int>(CellType::kHexahedron):
            return 8;
        case static_cast<int>(CellType::kWedge):
            return 6;
        default:
            return 0;
    }
}

void CellMesh::keep_values(const std::vector<int32_t>& cells) {
    const auto width = static_cast<size_t>(channels);
    for (size_t i = 0; i < cells.size(); ++i) {
        const size_t from = static_cast<size_t>(cells[i]) * width;
        std::copy_n(values.begin() + static_cast<std::ptrdiff_t>(from), width,
                    values.begin() + static_cast<std::ptrdiff_t>(i * width));
    }
    values.resize(cells.size() * width);
}

int64_t CellMesh::bytes() const {
    return static_cast<int64_t>(points.size() * sizeof(double) + types.size() +
                                corners.size() * sizeof(int32_t) + values.size() * sizeof(float));
}

Result<void> settle_field_values(std::optional<double> outside, std::vector<float>* values) {
    if (outside) {
        std::replace_if(
            values->begin(), values->end(), [](float v) { return std::isnan(v); },
            static_cast<float>(*outside));
    }
    const bool fine =
        std::all_of(values->begin(), values->end(), [](float v) { return std::isfinite(v); });
    return fine ? Result<void>() : user_error(messages::kValueNotFinite);
}

Result<ResampledBox> cell_box(const Box3d& bounds, double cells,
                              const texture::VolumeOptions& options) {
    const Vec3d sides = bounds.size();
    constexpr double kTexelsOfCell = 3;
    const double usual = std::cbrt(sides.x * sides.y * sides.z / cells);
    const double pitch = options.pitch_mm > 0 ? options.pitch_mm : usual / kTexelsOfCell;
    if (!(pitch > 0)) return user_error(messages::kCellsInAPlane);
    return resampled_box(bounds, pitch);
}

MadeReader open_cell_field(CellMesh mesh, const texture::VolumeOptions& options,
                           const texture::ReadLimits& limits) {
    if (mesh.types.empty()) return user_error(messages::kNoCellsWithVolume);
    if (Result<void> fine = settle_field_values(options.outside, &mesh.values); !fine)
        return fine.error();
    Box3d bounds;
    for (const int32_t point : mesh.corners) {
        const size_t p = 3 * static_cast<size_t>(point);
        const Vec3d at{mesh.points[p], mesh.points[p + 1], mesh.points[p + 2]};
        if (!std::isfinite(at.x) || !std::isfinite(at.y) || !std::isfinite(at.z))
            return user_error(messages::kCornerNotFinite);
        bounds.add(at);
    }
    const Result<ResampledBox> box =
        cell_box(bounds, static_cast<double>(mesh.types.size()), options);
    if (!box) return box.error();
    // Each cell's beginning, its place in the order of slices, and in the slices at hand.
    constexpr int64_t kBytesOfCell = 20;
    const int64_t cells = static_cast<int64_t>(mesh.types.size()) * kBytesOfCell;
    const int64_t slice = int64_t{box->size.x} * box->size.y * 16;
    if (Result<void> fits = check_memory(mesh.bytes() + cells + slice, limits.memory_bytes); !fits)
        return fits.error();
    auto reader = std::make_unique<CellReader>();
    box->place(reader.get());
    reader->box = *box;
    reader->channels = mesh.channels;
    reader->mesh = std::move(mesh);
    reader->outside = static_cast<float>(options.outside.value_or(0));
    reader->prepare();
    return std::unique_ptr<VolumeReader>(std::move(reader));
}

}  // namespace openfab::tools
