// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/texture/jpeg_inks.h"

#include <csetjmp>
#include <cstdio>
#include <string>
#include <vector>

#include <jpeglib.h>  // after what declares FILE

#include <jerror.h>  // after it

#include "tools/texture/check_memory.h"
#include "tools/texture/messages.h"

namespace openfab::tools {

namespace {

constexpr size_t kInks = 4;

struct Errors {
    jpeg_error_mgr manager{};  ///< first: the library knows it alone
    std::jmp_buf back{};
};

[[noreturn]] void fail(j_common_ptr jpeg) {
    // NOLINTNEXTLINE(cert-err52-cpp): as the library's own example does
    std::longjmp(reinterpret_cast<Errors*>(jpeg->err)->back, 1);
}

/// Warnings have a level below 0: data that is damaged or missing, for which the library puts grey.
void count_warnings(j_common_ptr jpeg, int level) {
    if (level < 0 && jpeg->err->msg_code != JWRN_EXTRANEOUS_DATA) ++jpeg->err->num_warnings;
}

}  // namespace

struct JpegInks::Handle {
    std::string bytes;
    Errors errors;
    jpeg_decompress_struct jpeg{};
    std::vector<uint8_t> row;

    // What longjmp leaves has no destructors.
    bool create() {
        if (setjmp(errors.back) != 0) return false;  // NOLINT(cert-err52-cpp)
        jpeg_create_decompress(&jpeg);
        return true;
    }
    bool read_header() {
        if (setjmp(errors.back) != 0) return false;  // NOLINT(cert-err52-cpp)
        jpeg_abort_decompress(&jpeg);
        jpeg_mem_src(&jpeg, reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size());
        if (jpeg_read_header(&jpeg, TRUE) != JPEG_HEADER_OK) return false;
        jpeg.out_color_space = JCS_CMYK;
        return jpeg.num_components == static_cast<int>(kInks);
    }
    bool start() {
        if (setjmp(errors.back) != 0) return false;  // NOLINT(cert-err52-cpp)
        return jpeg_start_decompress(&jpeg) != FALSE && errors.manager.num_warnings == 0;
    }
    bool read_row() {
        if (setjmp(errors.back) != 0) return false;  // NOLINT(cert-err52-cpp)
        JSAMPROW to = row.data();
        return jpeg_read_scanlines(&jpeg, &to, 1) == 1 && errors.manager.num_warnings == 0;
    }
};

JpegInks::JpegInks() : handle_(std::make_unique<Handle>()) {}

JpegInks::~JpegInks() {
    jpeg_destroy_decompress(&handle_->jpeg);
}

Result<std::unique_ptr<JpegInks>> JpegInks::open(const InputFile& file, int64_t memory_bytes) {
    Result<std::string> bytes = file.read_all(memory_bytes / 2);
    if (!bytes) return bytes.error();
    std::unique_ptr<JpegInks> inks(new JpegInks);
    Handle& handle = *inks->handle_;
    handle.bytes = std::move(*bytes);
    handle.jpeg.err = jpeg_std_error(&handle.errors.manager);
    handle.errors.manager.error_exit = fail;
    handle.errors.manager.emit_message = count_warnings;
    if (!handle.create() || !handle.read_header()) return user_error(messages::kPictureDamaged);
    if (!handle.jpeg.saw_Adobe_marker)
        return user_error(messages::kInksOfUnknownSense, messages::kInksOfUnknownSenseHelp);
    // Progressive ones are coefficients of 2 bytes first.
    const int64_t pixels = int64_t{handle.jpeg.image_width} * handle.jpeg.image_height;
    const int64_t needed = static_cast<int64_t>(handle.bytes.size()) + pixels * int64_t{kInks} * 2;
    if (Result<void> fine = check_memory(2 * needed, memory_bytes); !fine) return fine.error();
    handle.row.resize(kInks * handle.jpeg.image_width);
    return inks;
}

Result<void> JpegInks::each_row(const std::function<Result<void>(int y, const float* row)>& use) {
    Handle& handle = *handle_;
    if (!handle.read_header() || !handle.start()) return user_error(messages::kPictureDamaged);
    std::vector<float> row(handle.row.size());
    constexpr float kWhole = 255;
    const auto height = static_cast<int>(handle.jpeg.image_height);
    for (int y = 0; y < height; ++y) {
        if (!handle.read_row()) return user_error(messages::kPictureDamaged);
        for (size_t i = 0; i < row.size(); ++i)
            row[i] = (kWhole - static_cast<float>(handle.row[i])) / kWhole;
        if (Result<void> used = use(y, row.data()); !used) return used;
    }
    return {};
}

}  // namespace openfab::tools
