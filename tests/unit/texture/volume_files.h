// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What tests of volumes share: arrays of NumPy and slices that they write, and what comes of a file.

#include <OpenImageIO/imageio.h>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <stdlib.h>

#include <bit>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "tests/support/meshes/temp_folder.h"
#include "tests/support/places/places.h"
#include "texture/volume.h"
#include "tools/texture/convert_volume.h"
#include "tools/texture/messages.h"

namespace openfab::tools {

using texture::Pyramid;
using texture::VolumeOptions;

template <typename T>
std::string bytes_of(const std::vector<T>& values) {
    return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

inline std::string npy(const std::string& descr, const std::string& order, const std::string& shape,
                       const std::string& data) {
    std::string header =
        "{'descr': '" + descr + "', 'fortran_order': " + order + ", 'shape': " + shape + ", }\n";
    const auto n = static_cast<uint16_t>(header.size());
    std::string out = "\x93NUMPY";
    out += '\x01';
    out += '\x00';
    out += static_cast<char>(n & 0xff);
    out += static_cast<char>(n >> 8);
    return out + header + data;
}

class VolumeTest : public ::testing::Test {
  protected:
    VolumeTest() {
        ::setenv("OPENFAB_CACHE", (folder_.path() / "cache").c_str(), 1);
        ::setenv("OPENFAB_HELPER", testing::test_program("texture_test_helper").c_str(), 1);
        ::setenv("PATH", "/nonexistent", 1);
    }

    std::shared_ptr<const Pyramid> converted(const std::filesystem::path& file,
                                             const VolumeOptions& options = {}) {
        const std::filesystem::path out = folder_.path() / "out.oftx";
        const Result<void> made = make_volume_file(file, out, options);
        EXPECT_TRUE(made) << made.error().text();
        const auto opened = Pyramid::open(out, 1, 0);
        EXPECT_TRUE(opened) << opened.error().text();
        return opened ? *opened : nullptr;
    }
    std::string trouble(const std::filesystem::path& file, const VolumeOptions& options = {}) {
        const Result<void> made = make_volume_file(file, folder_.path() / "out.oftx", options);
        if (made) return "no error";
        const std::string start = fmt::format(messages::kCannotReadBefore, file.string());
        return made.error().text().starts_with(start) ? made.error().text().substr(start.size())
                                                      : made.error().text();
    }
    static Vec3i size(const Pyramid& p) { return {p.info()[15], p.info()[16], p.info()[17]}; }
    static std::vector<float> level0(const Pyramid& p) {
        const Vec3i s = size(p);
        return {p.texels().begin(), p.texels().begin() + s.x * s.y * s.z * p.channels()};
    }
    /// Origin, then extent.
    static std::vector<float> domain(const Pyramid& p) {
        std::vector<float> out;
        for (size_t k = 8; k < 14; ++k)
            out.push_back(std::bit_cast<float>(p.info()[k]));
        return out;
    }
    /// Rows from the top.
    void picture(const std::string& name, int width, int height, int channels,
                 const std::vector<uint8_t>& data) {
        const std::string file = (folder_.path() / name).string();
        const auto out = OIIO::ImageOutput::create(file);
        ASSERT_TRUE(
            out->open(file, OIIO::ImageSpec(width, height, channels, OIIO::TypeDesc::UINT8)));
        ASSERT_TRUE(out->write_image(OIIO::TypeDesc::UINT8, data.data()));
        out->close();
    }

    testing::TempFolder folder_;
};

}  // namespace openfab::tools
