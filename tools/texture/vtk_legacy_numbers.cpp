// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// The numbers of VTK's older files (.vtk).

#include <fmt/format.h>

#include <memory>
#include <string>
#include <utility>

#include "tools/texture/check_memory.h"
#include "tools/texture/messages.h"
#include "tools/texture/vtk_file.h"

namespace openfab::tools {

namespace {

/// The numbers of a text that is kept.
class KeptText final : public ArrayNumbers {
  public:
    KeptText(std::string text, double times) : text_(std::move(text)), times_(times) {}
    Result<void> open(int64_t count) {
        Result<std::unique_ptr<ArrayNumbers>> opened = open_array_text(text_, count);
        if (!opened) return opened.error();
        numbers_ = std::move(*opened);
        return {};
    }
    Result<void> next(double* out, size_t count) override {
        Result<void> got = numbers_->next(out, count);
        for (size_t i = 0; i < count && times_ != 1; ++i)
            out[i] *= times_;
        return got;
    }
    bool are_integers() const override { return numbers_->are_integers(); }

  private:
    std::string text_;
    double times_;
    std::unique_ptr<ArrayNumbers> numbers_;
};

/// Of cells that are each a number of corners and its corners: where they end, or the corners.
class CellNumbers final : public ArrayNumbers {
  public:
    CellNumbers(std::unique_ptr<ArrayNumbers> numbers, int64_t total, bool ends)
        : numbers_(std::move(numbers)), left_(total), ends_(ends) {}

    Result<void> next(double* out, size_t count) override {
        for (size_t i = 0; i < count; ++i) {
            if (Result<void> got = ends_ ? end(out++) : corner(out++); !got) return got;
        }
        return {};
    }

  private:
    Result<void> take(double* out) {
        if (--left_ < 0) return user_error(messages::kCornersBeyondCells);
        return numbers_->next(out, 1);
    }
    Result<void> open_cell() {
        double corners = 0;
        if (Result<void> got = take(&corners); !got) return got;
        if (!(corners >= 0 && corners <= static_cast<double>(left_)))
            return user_error(messages::kCornersBeyondCells);
        of_cell_ = static_cast<int64_t>(corners);
        return {};
    }
    Result<void> end(double* out) {
        if (Result<void> got = open_cell(); !got) return got;
        at_ += of_cell_;
        *out = static_cast<double>(at_);
        for (double unused = 0; of_cell_ > 0; --of_cell_) {
            if (Result<void> got = take(&unused); !got) return got;
        }
        return {};
    }
    Result<void> corner(double* out) {
        while (of_cell_ == 0) {
            if (Result<void> got = open_cell(); !got) return got;
        }
        --of_cell_;
        return take(out);
    }

    std::unique_ptr<ArrayNumbers> numbers_;
    int64_t left_;
    bool ends_;
    int64_t of_cell_ = 0, at_ = 0;
};

}  // namespace

Result<std::unique_ptr<ArrayNumbers>> VtkFile::legacy_numbers(const Array& array,
                                                              int64_t count) const {
    if (!array.interleaved && count != array.total - array.skip) {
        return user_error(
            fmt::format(messages::kArrayCount, array.name, array.total - array.skip, count));
    }
    std::unique_ptr<ArrayNumbers> out;
    if (array.coding == Coding::kFileText) {
        // With it lies what is made of it.
        if (Result<void> fits = check_memory(2 * array.bytes, memory_bytes_); !fits)
            return fits.error();
        std::string text(static_cast<size_t>(array.bytes), '\0');
        const Result<size_t> got = file_.read(array.offset, text.data(), text.size());
        if (!got) return got.error();
        text.resize(*got);
        auto kept = std::make_unique<KeptText>(std::move(text), array.times);
        if (Result<void> opened = kept->open(array.total); !opened) return opened.error();
        out = std::move(kept);
    } else {
        ArrayBytes bytes;
        bytes.file = &file_;
        bytes.begin = array.offset;
        bytes.swapped = true;
        bytes.header_bytes = 0;
        Result<std::unique_ptr<ArrayNumbers>> opened =
            open_array_bytes(bytes, array.type, array.total);
        if (!opened) return opened.error();
        out = std::move(*opened);
    }
    double unused = 0;
    for (int64_t i = 0; i < array.skip; ++i) {
        if (Result<void> got = out->next(&unused, 1); !got) return got.error();
    }
    if (array.interleaved)
        out = std::make_unique<CellNumbers>(std::move(out), array.total, array.name == "offsets");
    return out;
}

}  // namespace openfab::tools
