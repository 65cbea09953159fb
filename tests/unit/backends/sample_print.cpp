// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/unit/backends/sample_print.h"

#include <gtest/gtest.h>
#include <png.h>

#include <csetjmp>
#include <cstdio>

#include "backends/common/tee_sink.h"
#include "runtime/pipeline/print_hash.h"

namespace openfab::testing {

uint8_t& SamplePrint::at(int32_t x, int32_t y, int32_t z) {
    return codes[(static_cast<size_t>(z) * static_cast<size_t>(info.size.y) +
                  static_cast<size_t>(y)) *
                     static_cast<size_t>(info.size.x) +
                 static_cast<size_t>(x)];
}

std::vector<uint8_t> SamplePrint::rows(int32_t z) const {
    const size_t row_bytes = backends::packed_row_bytes(info.size.x, info.bits);
    std::vector<uint8_t> rows(row_bytes * static_cast<size_t>(info.size.y));
    for (int32_t y = 0; y < info.size.y; ++y) {
        for (int32_t x = 0; x < info.size.x; ++x) {
            const int32_t byte = info.bits == 8 ? x : x / 2;
            const int32_t shift = info.bits == 8 ? 0 : 4 * (x % 2);
            rows[static_cast<size_t>(y) * row_bytes + static_cast<size_t>(byte)] |=
                static_cast<uint8_t>(at(x, y, z) << shift);
        }
    }
    return rows;
}

pipeline::SliceView SamplePrint::view(int32_t z, const std::vector<uint8_t>& rows) const {
    return {z, rows.data(), backends::packed_row_bytes(info.size.x, info.bits), info.size.x,
            info.size.y};
}

pipeline::PrintTotals SamplePrint::totals() const {
    pipeline::PrintTotals totals;
    totals.complete = true;
    totals.voxels_by_code.assign(info.materials.size() + 1, 0);
    for (int32_t z = info.slice_begin; z < info.slice_end; ++z) {
        for (int32_t y = 0; y < info.size.y; ++y) {
            for (int32_t x = 0; x < info.size.x; ++x) {
                const uint8_t code = at(x, y, z);
                ++totals.voxels_by_code[code];
                totals.voxels_solid += code != 0 ? 1 : 0;
            }
        }
        const std::vector<uint8_t> packed = rows(z);
        totals.hash += pipeline::slice_hash(
            z, packed.data(), backends::packed_row_bytes(info.size.x, info.bits), info.size.y);
    }
    totals.tight.lo = {0, 0, info.slice_begin};
    totals.tight.hi = {info.size.x, info.size.y, info.slice_end};
    return totals;
}

Result<void> SamplePrint::send(pipeline::SliceSink* sink, bool complete) const {
    Result<void> done = sink->begin(info);
    for (int32_t z = info.slice_begin; z < info.slice_end && done; ++z) {
        const std::vector<uint8_t> packed = rows(z);
        done = sink->commit(z, sink->encode(view(z, packed)));
    }
    pipeline::PrintTotals all = totals();
    all.complete = complete && done.has_value();
    Result<void> finished = sink->finish(all);
    return done ? finished : done;
}

SamplePrint make_sample(Vec3i size, int32_t bits) {
    SamplePrint print;
    print.info.size = size;
    print.info.pitch_mm = {25.4 / 600, 25.4 / 300, 0.027};
    print.info.origin_mm = {-1.5, 2.25, 0};
    print.info.slice_end = size.z;
    print.info.bits = bits;
    print.info.materials = {{"white", {255, 255, 255, 255}, {244, 242, 236, 255}, 1.18, "A"},
                            {"black", {0, 0, 0, 255}, {22, 22, 22, 255}, 1.2, "B"},
                            {"clear \"x\"", {10, 200, 30, 255}, {200, 220, 255, 128}, 1.1, ""}};
    print.info.printer = "j750";
    print.info.title = "sample";
    print.info.seed = 12345678901234567ULL;
    print.codes.resize(static_cast<size_t>(size.x) * static_cast<size_t>(size.y) *
                       static_cast<size_t>(size.z));
    uint32_t state = 1;
    for (uint8_t& code : print.codes) {
        state = state * 1664525U + 1013904223U;
        code = static_cast<uint8_t>((state >> 24) % 4);
    }
    return print;
}

SamplePrint make_letter_f(int32_t cell, int32_t slices) {
    constexpr const char* kRows[7] = {"#####", "#....", "#....", "###..",
                                      "#....", "#....", "#...."};  // highest y first
    SamplePrint print = make_sample({5 * cell, 7 * cell, slices});
    print.info.pitch_mm = {0.1, 0.1, 0.1};
    for (int32_t z = 0; z < slices; ++z) {
        for (int32_t y = 0; y < print.info.size.y; ++y) {
            for (int32_t x = 0; x < print.info.size.x; ++x) {
                print.at(x, y, z) = kRows[6 - y / cell][x / cell] == '#' ? 1 : 0;
            }
        }
    }
    return print;
}

ReadPng read_png(const std::filesystem::path& file) {
    ReadPng result;
    std::FILE* in = std::fopen(file.c_str(), "rb");
    if (in == nullptr) {
        ADD_FAILURE() << "cannot open " << file;
        return result;
    }
    png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
    png_infop info = png_create_info_struct(png);
    std::vector<png_bytep> rows;
    if (setjmp(png_jmpbuf(png)) != 0) {
        ADD_FAILURE() << "libpng refuses " << file;
        png_destroy_read_struct(&png, &info, nullptr);
        std::fclose(in);
        return {};
    }
    png_init_io(png, in);
    png_read_info(png, info);
    result.width = static_cast<int32_t>(png_get_image_width(png, info));
    result.height = static_cast<int32_t>(png_get_image_height(png, info));
    result.color_type = png_get_color_type(png, info);
    result.bit_depth = png_get_bit_depth(png, info);
    result.pixels_per_metre_x = png_get_x_pixels_per_meter(png, info);
    result.pixels_per_metre_y = png_get_y_pixels_per_meter(png, info);
    png_set_expand(png);
    png_set_gray_to_rgb(png);
    png_set_add_alpha(png, 255, PNG_FILLER_AFTER);
    png_read_update_info(png, info);
    result.rgba.resize(static_cast<size_t>(result.width) * static_cast<size_t>(result.height));
    for (int32_t y = 0; y < result.height; ++y) {
        rows.push_back(reinterpret_cast<png_bytep>(
            result.rgba.data() + static_cast<size_t>(y) * static_cast<size_t>(result.width)));
    }
    png_read_image(png, rows.data());
    png_read_end(png, nullptr);
    png_destroy_read_struct(&png, &info, nullptr);
    std::fclose(in);
    return result;
}

}  // namespace openfab::testing
