// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// openfab._core.PrintFile: the slices of an `.ofr` file or of a folder, in any order.

#include "backends/read/print_file.h"

#include <fmt/format.h>
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/variant.h>

#include <algorithm>
#include <array>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "backends/common/tee_sink.h"
#include "python/src/bindings.h"

namespace nb = nanobind;
using namespace nb::literals;

namespace openfab::python {

namespace {

using prints::PrintFile;
using Codes = nb::ndarray<nb::numpy, const uint8_t, nb::ndim<2>>;
using Window = std::array<int32_t, 4>;  ///< first and last + 1 along x, then along y

/// Returns the codes of part of a slice, [y][x]. The window lies in the slice.
Result<std::vector<uint8_t>> read_codes(const PrintFile& file, int32_t z, const Window& window) {
    const auto [x0, x1, y0, y1] = window;
    const pipeline::PrintInfo& info = file.info();
    if (x0 < 0 || x1 < x0 || x1 > info.size.x || y0 < 0 || y1 < y0 || y1 > info.size.y)
        return user_error(fmt::format("{}: the window is beyond its slices", file.path()));
    prints::SliceBuffers buffers;
    if (Result<void> read = file.read_slice(z, &buffers); !read) return read.error();
    const pipeline::SliceView slice{z, buffers.rows.data(), file.row_bytes(), info.size.x,
                                    info.size.y};
    std::vector<uint8_t> row(static_cast<size_t>(info.size.x));
    std::vector<uint8_t> codes(static_cast<size_t>(x1 - x0) * static_cast<size_t>(y1 - y0));
    for (int32_t y = y0; y < y1; ++y) {
        backends::unpack_row(slice, y, info.bits, row.data());
        std::copy(row.begin() + x0, row.begin() + x1, codes.begin() + int64_t{x1 - x0} * (y - y0));
    }
    return codes;
}

std::variant<Codes, Error> read(const PrintFile& file, int32_t z, const Window& window) {
    Result<std::vector<uint8_t>> codes{std::vector<uint8_t>()};
    {
        const nb::gil_scoped_release released;
        codes = read_codes(file, z, window);
    }
    if (!codes) return codes.error();
    return array_of<Codes>(std::move(*codes), {static_cast<size_t>(window[3] - window[2]),
                                               static_cast<size_t>(window[1] - window[0])});
}

std::variant<std::shared_ptr<PrintFile>, Error> open(const std::string& path,
                                                     int64_t memory_bytes) {
    Result<std::unique_ptr<PrintFile>> file = PrintFile::open(path, memory_bytes);
    if (!file) return file.error();
    return std::shared_ptr<PrintFile>(std::move(*file));
}

std::optional<std::string> hash_of(const PrintFile& file) {
    const std::optional<pipeline::PrintTotals> totals = file.totals();
    if (!totals) return std::nullopt;
    return fmt::format("{:016x}", totals->hash);
}

}  // namespace

void bind_print_file(nb::module_& m) {
    nb::class_<PrintFile>(m, "PrintFile",
                          "A file or a folder of slices, which are read in any order.")
        .def_prop_ro("info", [](const PrintFile& f) { return info_of(f.info(), 0); })
        .def_prop_ro("whole_slices", &PrintFile::whole_slices,
                     "How many can be read, from the first of info's slices on.")
        .def_prop_ro("hash", &hash_of, "Of the print; None where it is not complete.")
        .def("read", &read, "z"_a, "window"_a,
             "Returns the codes of part of slice z, [y][x]; the window is [x0, x1, y0, y1].");
    m.def("open_print_file", &open, "path"_a, "memory_bytes"_a,
          nb::call_guard<nb::gil_scoped_release>());
}

}  // namespace openfab::python
