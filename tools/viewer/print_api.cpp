// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/viewer/print_api.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "backends/job/record.h"
#include "backends/ofr/format.h"
#include "base/text.h"
#include "tools/viewer/difference.h"
#include "tools/viewer/messages.h"
#include "tools/viewer/opening.h"
#include "tools/viewer/parameters.h"

namespace openfab::viewer {

namespace {

enum Which { kFirst, kSecond, kDifference };

constexpr int32_t kMostSide = ofr::kMaxSide;

std::string color_text(const std::array<uint8_t, 4>& rgba, bool alpha) {
    std::string text = fmt::format("#{:02x}{:02x}{:02x}", rgba[0], rgba[1], rgba[2]);
    return alpha ? text + fmt::format("{:02x}", rgba[3]) : text;
}

Answer failure(const Error& error) {
    return refusal(error.code == ErrorCode::kUserInput ? 422 : 500, error.text());
}

void vector_member(JsonText* out, const char* name, const Vec3d& v) {
    out->key(name).begin_array().value(v.x).value(v.y).value(v.z).end_array();
}

void vector_member(JsonText* out, const char* name, const Vec3i& v) {
    out->key(name).begin_array().value(v.x).value(v.y).value(v.z).end_array();
}

/// What the record beside the print tells of its making, the last event last.
void describe_story(const prints::PrintFile& file,
                    const std::optional<pipeline::PrintTotals>& totals, JsonText* out) {
    const std::optional<JsonValue> record =
        job::record_of(file.path(), totals ? std::optional(totals->hash) : std::nullopt);
    out->key("story").begin_array();
    if (record) {
        for (const std::string& line : job::story_lines(*record, file.path()))
            out->value(printable(line));
    }
    out->end_array();
}

void describe_print(ViewedPrint& print, JsonText* out) {
    const pipeline::PrintInfo& info = print.file().info();
    const std::optional<pipeline::PrintTotals> totals = print.file().totals();
    out->begin_object();
    out->member("name", print.name()).member("title", info.title).member("printer", info.printer);
    vector_member(out, "size", info.size);
    vector_member(out, "pitch_mm", info.pitch_mm);
    vector_member(out, "origin_mm", info.origin_mm);
    out->member("slice_begin", info.slice_begin).member("slice_end", info.slice_end);
    out->member("whole", print.file().whole_slices()).member("complete", totals.has_value());
    out->key("solid");
    if (totals) {
        out->value(totals->voxels_solid).member("hash", fmt::format("{:016x}", totals->hash));
    } else {
        out->null();
    }
    describe_story(print.file(), totals, out);
    out->key("materials").begin_array();
    for (size_t m = 0; m < info.materials.size(); ++m) {
        const pipeline::SliceMaterial& material = info.materials[m];
        out->begin_object().member("name", material.name);
        out->member("key", color_text(material.key, false));
        out->member("preview", color_text(material.preview, true));
        out->member("channel", material.channel);
        out->member("density_g_cm3", material.density_g_cm3).key("voxels");
        totals ? out->value(totals->voxels_by_code[m + 1]) : out->null();
        out->end_object();
    }
    out->end_array().key("provenance").begin_array();
    for (const auto& [name, value] : info.provenance)
        out->begin_array().value(name).value(value).end_array();
    out->end_array().key("volume").begin_object();
    vector_member(out, "cells", volume_cells(info));
    out->member("steps", volume_steps(info)).end_object();
    out->end_object();
}

/// What all requests name: a print, or the difference of both.
struct Chosen {
    Which which = kFirst;
    ViewedPrint* print = nullptr;  ///< the first of a difference
    ViewedPrint* other = nullptr;  ///< of a difference
};

std::optional<Answer> choose(const Session::Prints& prints, Parameters* in, Chosen* chosen) {
    const int32_t generation = in->whole("generation", 0, INT32_MAX);
    chosen->which = static_cast<Which>(in->one_of("print", "0|1|diff"));
    if (!in->failed().empty()) return refusal(400, in->failed());
    if (generation != prints.generation) return refusal(409, messages::kOtherPrintShown);
    const size_t needed = chosen->which == kFirst ? 1 : 2;
    if (prints.list.size() < needed) return refusal(404, messages::kNoSuchPrint);
    chosen->print = prints.list[chosen->which == kSecond ? 1 : 0].get();
    if (chosen->which != kDifference) return {};
    chosen->other = prints.list[1].get();
    const std::string why =
        why_not_compared(chosen->print->file().info(), chosen->other->file().info());
    if (!why.empty()) return refusal(422, why);
    return {};
}

/// The rows of one print in a plane, with what keeps them.
struct Rows {
    std::shared_ptr<const Slice> slice;
    std::shared_ptr<Cut> cut;
    size_t row_bytes = 0;

    const uint8_t* row(int32_t v) const {
        if (cut != nullptr) return cut->row(v);
        return slice->rows.data() + static_cast<size_t>(v) * row_bytes;
    }
};

Result<Rows> rows_of(ViewedPrint* print, int axis, int32_t at, const TilePlace& place) {
    Rows rows;
    rows.row_bytes = print->file().row_bytes();
    if (axis == 2) {
        Result<std::shared_ptr<const Slice>> slice = print->slices().slice(at);
        if (!slice) return slice.error();
        rows.slice = std::move(*slice);
        return rows;
    }
    rows.cut = print->cuts().cut(axis, at);
    const Result<void> fetched =
        rows.cut->fetch(static_cast<int32_t>(place.first_v()),
                        static_cast<int32_t>(place.end_v(print->file().info().size.z)),
                        static_cast<int32_t>(place.rows_a_pixel()));
    if (!fetched) return fetched.error();
    return rows;
}

TilePlace tile_place(Parameters* in) {
    TilePlace place;
    place.level_u = in->whole("lu", 0, kMostLevel);
    place.level_v = in->whole("lv", 0, kMostLevel);
    place.u = in->whole("u", 0, kMostSide / kTilePixels);
    place.v = in->whole("v", 0, kMostSide / kTilePixels);
    place.coarse = in->whole_or("coarse", 1, 1, 64);
    return place;
}

Answer tile(const Session::Prints& prints, const Request& request) {
    Parameters in(request);
    const int axis = in.one_of("axis", "x|y|z");
    const int32_t at = in.whole("at", 0, kMostSide);
    const TilePlace place = tile_place(&in);
    Palette palette = in.palette("colors");
    Chosen chosen;
    if (std::optional<Answer> wrong = choose(prints, &in, &chosen)) return std::move(*wrong);
    const pipeline::PrintInfo& info = chosen.print->file().info();
    if (at >= info.size[axis]) return refusal(404, fmt::format(messages::kNoSuchVoxel, at));
    if (axis == 2 && place.coarse != 1) return refusal(400, messages::kSlicesNeverCoarse);
    Plane plane;
    plane.width = axis == 0 ? info.size.y : info.size.x;
    plane.height = axis == 2 ? info.size.y : info.size.z;
    plane.bits = info.bits;
    plane.sampled = axis != 2;
    if (place.first_u() >= plane.width || place.first_v() >= plane.height)
        return refusal(404, messages::kTileBesidePrint);
    const Result<Rows> rows = rows_of(chosen.print, axis, at, place);
    if (!rows) return failure(rows.error());
    plane.row = [&](int32_t v) { return rows->row(v); };
    std::vector<uint8_t> png;
    if (chosen.which == kDifference) {
        const Result<Rows> others = rows_of(chosen.other, axis, at, place);
        if (!others) return failure(others.error());
        Difference difference(info, chosen.other->file().info(), plane.width);
        plane.row = [&](int32_t v) { return difference.row(rows->row(v), others->row(v)); };
        plane.bits = 8;
        Difference::fade(&palette);
        png = draw_tile(plane, place, palette);
    } else {
        png = draw_tile(plane, place, palette);
    }
    if (png.empty()) return refusal(500, messages::kMemoryRanOut);
    Answer answer{200, "image/png", std::string(png.begin(), png.end())};
    // A cut of an unfinished print grows.
    answer.lasting = axis == 2 || chosen.print->file().totals().has_value();
    return answer;
}

/// Voxels around a place in its slice: half a width, about so much or a voxel.
constexpr double kAroundMm = 0.25;
constexpr int32_t kMostAround = 64;

void describe_around(const pipeline::PrintInfo& info, const Slice& slice, size_t row_bytes,
                     const Vec3i& voxel, JsonText* out) {
    const pipeline::SliceView view{slice.z, slice.rows.data(), row_bytes, info.size.x, info.size.y};
    int32_t low[2], high[2];
    for (int a = 0; a < 2; ++a) {
        const auto half = static_cast<int32_t>(
            std::clamp(std::floor(kAroundMm / info.pitch_mm[a]), 1.0, double{kMostAround}));
        low[a] = std::max(0, voxel[a] - half);
        high[a] = std::min(info.size[a], voxel[a] + half + 1);
    }
    std::array<int64_t, 256> counts{};
    for (int32_t y = low[1]; y < high[1]; ++y) {
        for (int32_t x = low[0]; x < high[0]; ++x)
            ++counts[view.code(x, y, info.bits)];
    }
    const double all = double{1} * (high[0] - low[0]) * (high[1] - low[1]);
    out->key("around_mm").begin_array();
    for (int a = 0; a < 2; ++a)
        out->value((high[a] - low[a]) * info.pitch_mm[a]);
    out->end_array().key("around").begin_array();
    for (size_t code = 0; code < counts.size(); ++code) {
        if (counts[code] == 0) continue;
        out->begin_object().member("code", static_cast<int32_t>(code));
        out->member("share", static_cast<double>(counts[code]) / all).end_object();
    }
    out->end_array();
}

/// The middle of a voxel, in build space.
Vec3d middle_of(const pipeline::PrintInfo& info, const Vec3i& voxel) {
    return {info.origin_mm.x + (voxel.x + 0.5) * info.pitch_mm.x,
            info.origin_mm.y + (voxel.y + 0.5) * info.pitch_mm.y,
            info.origin_mm.z + (voxel.z + 0.5) * info.pitch_mm.z};
}

std::optional<Answer> choose_voxel(const Session::Prints& prints, Parameters* in, Chosen* chosen,
                                   Vec3i* voxel) {
    *voxel = {in->whole("x", 0, kMostSide), in->whole("y", 0, kMostSide),
              in->whole("z", 0, kMostSide)};
    if (std::optional<Answer> wrong = choose(prints, in, chosen)) return wrong;
    for (int a = 0; a < 3; ++a) {
        if ((*voxel)[a] >= chosen->print->file().info().size[a])
            return refusal(404, messages::kVoxelBesidePrint);
    }
    return {};
}

Answer amounts(const Session::Prints& prints, const AmountsAt& amounts_at, const Request& request) {
    Parameters in(request);
    Chosen chosen;
    Vec3i voxel;
    if (std::optional<Answer> wrong = choose_voxel(prints, &in, &chosen, &voxel))
        return std::move(*wrong);
    if (!amounts_at || chosen.which != kFirst) return refusal(404, messages::kWorldNotKnown);
    const pipeline::PrintInfo& info = chosen.print->file().info();
    const Result<std::vector<double>> fractions = amounts_at(info, middle_of(info, voxel));
    if (!fractions) return failure(fractions.error());
    JsonText out;
    out.begin_object().key("fractions").begin_array();
    for (const double fraction : *fractions)
        out.value(fraction);
    out.end_array().end_object();
    return {200, "application/json", out.take()};
}

/// The solid voxel of a slice that is nearest to a place, within `reach` voxels; else that place.
Vec3i nearest_solid(const pipeline::PrintInfo& info, const Slice& slice, size_t row_bytes,
                    const Vec3i& voxel, int32_t reach) {
    const pipeline::SliceView view{slice.z, slice.rows.data(), row_bytes, info.size.x, info.size.y};
    Vec3i nearest = voxel;
    double least = std::numeric_limits<double>::infinity();
    for (int32_t y = std::max(0, voxel.y - reach); y <= std::min(info.size.y - 1, voxel.y + reach);
         ++y) {
        for (int32_t x = std::max(0, voxel.x - reach);
             x <= std::min(info.size.x - 1, voxel.x + reach); ++x) {
            const double away =
                std::hypot((x - voxel.x) * info.pitch_mm.x, (y - voxel.y) * info.pitch_mm.y);
            if (away >= least || view.code(x, y, info.bits) == 0) continue;
            least = away;
            nearest.x = x;
            nearest.y = y;
        }
    }
    return nearest;
}

Answer pick(const Session::Prints& prints, const OfWorld& world, const Request& request) {
    Parameters in(request);
    const int32_t reach = in.whole_or("reach", 0, 0, kMostAround);
    Chosen chosen;
    Vec3i voxel;
    if (std::optional<Answer> wrong = choose_voxel(prints, &in, &chosen, &voxel))
        return std::move(*wrong);
    const prints::PrintFile& file = chosen.print->file();
    const pipeline::PrintInfo& info = file.info();
    const Result<std::shared_ptr<const Slice>> slice = chosen.print->slices().slice(voxel.z);
    if (!slice) return failure(slice.error());
    if (reach > 0) voxel = nearest_solid(info, **slice, file.row_bytes(), voxel, reach);
    const auto code_in = [&](const prints::PrintFile& print, const Slice& rows) {
        return pipeline::SliceView{rows.z, rows.rows.data(), print.row_bytes(), info.size.x,
                                   info.size.y}
            .code(voxel.x, voxel.y, print.info().bits);
    };
    const uint8_t code = code_in(file, **slice);
    JsonText out;
    out.begin_object().member("code", int32_t{code});
    vector_member(&out, "voxel", voxel);
    if (chosen.which == kDifference) {
        const Result<std::shared_ptr<const Slice>> other = chosen.other->slices().slice(voxel.z);
        if (!other) return failure(other.error());
        const Difference difference(info, chosen.other->file().info(), info.size.x);
        out.member("other", int32_t{difference.as_first(code_in(chosen.other->file(), **other))});
    }
    const Vec3d mm = middle_of(info, voxel);
    vector_member(&out, "mm", mm);
    if (world.part_at && chosen.which == kFirst) {
        if (const std::optional<std::string> part = world.part_at(mm)) out.member("part", *part);
    }
    out.member("has_amounts", world.amounts_at && chosen.which == kFirst);
    describe_around(info, **slice, file.row_bytes(), voxel, &out);
    out.end_object();
    return {200, "application/json", out.take()};
}

/// Voxels by code; an odd row's unused half is not one.
std::vector<int64_t> count_codes(const pipeline::PrintInfo& info,
                                 const std::vector<uint8_t>& rows) {
    std::array<int64_t, 256> bytes{};
    for (const uint8_t byte : rows)
        ++bytes[byte];
    std::vector<int64_t> counts(256);
    for (size_t byte = 0; byte < bytes.size(); ++byte) {
        counts[info.bits == 8 ? byte : byte & 15] += bytes[byte];
        if (info.bits == 4) counts[byte >> 4] += bytes[byte];
    }
    if (info.bits == 4 && info.size.x % 2 != 0) counts[0] -= info.size.y;
    counts.resize(info.materials.size() + 1);
    return counts;
}

/// Writes how many voxels differ, and of what material they are in each print.
void write_changes(const std::vector<int64_t>& changes, JsonText* out) {
    out->member("different", std::accumulate(changes.begin(), changes.end(), int64_t{0}));
    out->key("changes").begin_array();
    for (size_t pair = 0; pair < changes.size(); ++pair) {
        if (changes[pair] == 0) continue;
        out->begin_object().member("first", static_cast<int32_t>(pair / 256));
        out->member("second", static_cast<int32_t>(pair % 256)).member("voxels", changes[pair]);
        out->end_object();
    }
    out->end_array();
}

Answer slice(const Session::Prints& prints, const Request& request) {
    Parameters in(request);
    const int32_t z = in.whole("z", 0, kMostSide);
    Chosen chosen;
    if (std::optional<Answer> wrong = choose(prints, &in, &chosen)) return std::move(*wrong);
    const prints::PrintFile& file = chosen.print->file();
    const Result<std::shared_ptr<const Slice>> slice = chosen.print->slices().slice(z);
    if (!slice) return failure(slice.error());
    JsonText out;
    out.begin_object().member("z", z).key("voxels").begin_array();
    for (const int64_t voxels : count_codes(file.info(), (*slice)->rows))
        out.value(voxels);
    out.end_array();
    if (chosen.which == kDifference) {
        const Result<std::shared_ptr<const Slice>> other = chosen.other->slices().slice(z);
        if (!other) return failure(other.error());
        const pipeline::PrintInfo& info = file.info();
        Difference difference(info, chosen.other->file().info(), info.size.x);
        const auto view = [&](const prints::PrintFile& print, const Slice& rows) {
            return pipeline::SliceView{z, rows.rows.data(), print.row_bytes(), info.size.x,
                                       info.size.y};
        };
        const pipeline::SliceView a = view(file, **slice), b = view(chosen.other->file(), **other);
        std::vector<int64_t> changes(256 * 256);  // by the codes of both
        for (int32_t y = 0; y < info.size.y; ++y) {
            const uint8_t* row = difference.row(a.data + static_cast<size_t>(y) * a.row_bytes,
                                                b.data + static_cast<size_t>(y) * b.row_bytes);
            for (int32_t x = 0; x < info.size.x; ++x) {
                if (row[x] != kDifferent) continue;
                ++changes[size_t{256} * a.code(x, y, info.bits) +
                          b.code(x, y, chosen.other->file().info().bits)];
            }
        }
        write_changes(changes, &out);
    }
    out.end_object();
    return {200, "application/json", out.take()};
}

Answer volume(const Session::Prints& prints, const Request& request) {
    Parameters in(request);
    Palette palette = in.palette("colors");
    const int32_t known = in.whole_or("known", 0, 0, INT32_MAX);
    Chosen chosen;
    if (std::optional<Answer> wrong = choose(prints, &in, &chosen)) return std::move(*wrong);
    const bool compares = chosen.which == kDifference;
    Volume& volume = compares ? prints.compared->volume() : chosen.print->volume();
    if (compares) {
        const pipeline::PrintInfo& info = chosen.print->file().info();
        double across_mm = 0;
        for (int a = 0; a < 3; ++a)
            across_mm = std::max(across_mm, info.size[a] * info.pitch_mm[a]);
        Difference::fade_through(&palette, across_mm);
    }
    if (const std::string trouble = volume.trouble(); !trouble.empty())
        return refusal(422, trouble);
    volume.wait_for_more(known);
    const int32_t done = volume.steps_done();
    if (done <= known) return {204, "", ""};
    const std::vector<uint8_t> rgba = volume.colors(palette);
    Answer answer{200, "application/octet-stream", std::string(rgba.begin(), rgba.end())};
    answer.step = done;
    return answer;
}

Answer opening(const Session::Prints& prints, const Request& request) {
    Parameters in(request);
    Chosen chosen;
    if (std::optional<Answer> wrong = choose(prints, &in, &chosen)) return std::move(*wrong);
    JsonText out;
    out.begin_object().member("z", opening_slice(&chosen.print->slices())).end_object();
    return {200, "application/json", out.take()};
}

}  // namespace

Answer refusal(int status, const std::string& why) {
    return {status, "application/json", error_json(why)};
}

void describe_prints(const Session::Prints& prints, JsonText* out) {
    out->member("generation", prints.generation).key("prints").begin_array();
    for (const std::shared_ptr<ViewedPrint>& print : prints.list)
        describe_print(*print, out);
    out->end_array();
    if (prints.list.size() == 2) {
        const pipeline::PrintInfo& first = prints.list[0]->file().info();
        const pipeline::PrintInfo& second = prints.list[1]->file().info();
        out->member("difference", why_not_compared(first, second));
        out->member("difference_steps", volume_steps(first, &second));
    }
}

std::optional<Answer> answer_on_prints(const Session& session, const OfWorld& world,
                                       const Request& request) {
    const Session::Prints prints = session.prints();
    if (request.path == "/api/tile") return tile(prints, request);
    if (request.path == "/api/pick") return pick(prints, world, request);
    if (request.path == "/api/amounts") return amounts(prints, world.amounts_at, request);
    if (request.path == "/api/slice") return slice(prints, request);
    if (request.path == "/api/volume") return volume(prints, request);
    if (request.path == "/api/opening") return opening(prints, request);
    return {};
}

}  // namespace openfab::viewer
