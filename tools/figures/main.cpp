// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// openfab-figures FOLDER: writes the gallery's meshes and pictures. Unchanged files are not
// touched.

#include <fmt/format.h>

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include "backends/common/output_file.h"
#include "backends/raster/png_encode.h"
#include "tools/figures/figures.h"
#include "tools/figures/paint.h"
#include "tools/figures/polygonise.h"

namespace {

using namespace openfab;
using namespace openfab::figures;

std::string read_whole(const std::filesystem::path& path) {
    std::ifstream in(path, std::ios::binary);
    std::ostringstream text;
    text << in.rdbuf();
    return text.str();
}

/// Returns false, with a message on stderr, if the file cannot be written.
bool write(const std::filesystem::path& path, const std::string& bytes) {
    if (read_whole(path) == bytes) return true;
    const Result<void> written = backends::write_whole_file(path, bytes);
    if (!written) fmt::print(stderr, "openfab-figures: {}\n", written.error().text());
    return static_cast<bool>(written);
}

std::string png_of(const Painting& painting) {
    std::vector<uint8_t> rows;
    const auto stride =
        static_cast<size_t>(painting.width) * static_cast<size_t>(painting.channels);
    for (size_t y = 0; y < static_cast<size_t>(painting.height); ++y) {
        rows.push_back(0);
        const auto row = painting.pixels.begin() + static_cast<std::ptrdiff_t>(y * stride);
        rows.insert(rows.end(), row, row + static_cast<std::ptrdiff_t>(stride));
    }
    raster::PngImage image;
    image.width = painting.width;
    image.height = painting.height;
    image.color = painting.channels == 1 ? raster::PngColor::kGrey : raster::PngColor::kRgb;
    image.rows = rows;
    image.text = "openfab-figures";
    const std::vector<uint8_t> png = raster::encode_png(image, 6);
    return {png.begin(), png.end()};
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 2 || std::string(argv[1]).starts_with("-")) {
        fmt::print(
            stderr,
            "usage: openfab-figures FOLDER\nWrites the gallery's meshes and pictures there.\n");
        return 2;
    }
    const std::filesystem::path folder = argv[1];
    std::error_code status;
    std::filesystem::create_directories(folder, status);
    if (status) {
        fmt::print(stderr, "openfab-figures: cannot create {}: {}\n", folder.string(),
                   status.message());
        return 3;
    }
    bool good = true;
    for (const Figure& figure : all_figures()) {
        const TriangleMesh mesh = polygonise(figure.shape, figure.box, figure.cell_mm);
        good =
            write(folder / (figure.name + ".obj"), write_obj(mesh, figure.name, figure.cell_mm)) &&
            good;
    }
    for (const Painting& painting : all_paintings())
        good = write(folder / (painting.name + ".png"), png_of(painting)) && good;
    return good ? 0 : 3;
}
