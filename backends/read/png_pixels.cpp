// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "backends/read/png_pixels.h"

#include <fmt/format.h>
#include <png.h>

#include <csetjmp>
#include <cstring>

#include "backends/read/messages.h"

namespace openfab::prints {

namespace {

struct Source {
    std::string_view rest;
};

void take_bytes(png_structp png, png_bytep to, size_t count) {
    auto* const source = static_cast<Source*>(png_get_io_ptr(png));
    if (source->rest.size() < count) png_error(png, "cut short");
    std::memcpy(to, source->rest.data(), count);
    source->rest.remove_prefix(count);
}

[[noreturn]] void fail(png_structp png, png_const_charp) {
    std::longjmp(png_jmpbuf(png), 1);  // NOLINT(cert-err52-cpp): as the library's own does
}
void say_nothing(png_structp, png_const_charp) {}

struct Header {
    uint32_t width = 0, height = 0;
    int bits = 0;
    bool has_alpha = false;
};

// What longjmp leaves has no destructors: pictures are given by who calls.

bool read_header(png_structp png, png_infop info, Header* header) {
    if (setjmp(png_jmpbuf(png)) != 0) return false;  // NOLINT(cert-err52-cpp)
    png_read_info(png, info);
    header->width = png_get_image_width(png, info);
    header->height = png_get_image_height(png, info);
    header->bits = png_get_bit_depth(png, info);
    header->has_alpha = (png_get_color_type(png, info) & PNG_COLOR_MASK_ALPHA) != 0 ||
                        png_get_valid(png, info, PNG_INFO_tRNS) != 0;
    return true;
}

bool read_rows(png_structp png, png_infop info, size_t row_bytes, png_bytepp rows) {
    if (setjmp(png_jmpbuf(png)) != 0) return false;  // NOLINT(cert-err52-cpp)
    constexpr int kOpaque = 0xff;
    png_set_expand(png);
    png_set_gray_to_rgb(png);
    png_set_add_alpha(png, kOpaque, PNG_FILLER_AFTER);
    png_set_interlace_handling(png);
    png_read_update_info(png, info);
    if (png_get_rowbytes(png, info) != row_bytes) return false;
    png_read_image(png, rows);
    png_read_end(png, nullptr);
    return true;
}

}  // namespace

Result<PngPixels> read_png_pixels(std::string_view bytes, const Vec2<int32_t>& size) {
    Source source{bytes};
    png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, nullptr, fail, say_nothing);
    png_infop info = png == nullptr ? nullptr : png_create_info_struct(png);
    struct Closer {
        png_structpp png;
        png_infopp info;
        ~Closer() { png_destroy_read_struct(png, info, nullptr); }
    } const closer{&png, &info};
    if (info == nullptr) return outside_error(messages::kNoPng);
    png_set_read_fn(png, &source, take_bytes);
    Header header;
    if (!read_header(png, info, &header)) return user_error(messages::kNoPng);
    if (header.width != static_cast<uint32_t>(size.x) ||
        header.height != static_cast<uint32_t>(size.y))
        return user_error(fmt::format(messages::kPictureOfOtherSize, header.width, header.height,
                                      size.x, size.y));
    if (header.bits > 8) return user_error(messages::kPngOfSixteenBits);
    const size_t row_bytes = size_t{4} * header.width;
    PngPixels pixels;
    pixels.has_alpha = header.has_alpha;
    pixels.rgba.resize(row_bytes * header.height);
    std::vector<png_bytep> rows(header.height);
    for (size_t y = 0; y < rows.size(); ++y)
        rows[y] = pixels.rgba.data() + y * row_bytes;
    if (!read_rows(png, info, row_bytes, rows.data())) return user_error(messages::kNoPng);
    return pixels;
}

}  // namespace openfab::prints
