// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A file of another program's format, with the error of the first write that failed.

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "backends/common/part_file.h"

namespace openfab::mechanics {

class TextFile {
  public:
    static Result<std::unique_ptr<TextFile>> create(const std::filesystem::path& path) {
        Result<std::unique_ptr<backends::PartFile>> file = backends::PartFile::create(path);
        if (!file) return file.error();
        std::unique_ptr<TextFile> out(new TextFile);
        out->file_ = std::move(*file);
        return out;
    }
    void put(const std::string& text) {
        put_bytes({reinterpret_cast<const uint8_t*>(text.data()), text.size()});
    }
    template <typename T>
    void put_values(const std::vector<T>& values) {
        put_bytes({reinterpret_cast<const uint8_t*>(values.data()), values.size() * sizeof(T)});
    }
    template <typename T>
    void put_value(const T& value) {
        put_bytes({reinterpret_cast<const uint8_t*>(&value), sizeof(T)});
    }
    void put_bytes(std::span<const uint8_t> bytes) {
        if (!status_) return;
        written_ += static_cast<int64_t>(bytes.size());
        status_ = file_->write(bytes);
    }
    int64_t written() const { return written_; }
    /// The file appears; or the first error.
    Result<void> keep() { return status_ ? file_->keep() : status_; }

  private:
    TextFile() = default;
    std::unique_ptr<backends::PartFile> file_;
    Result<void> status_;
    int64_t written_ = 0;
};

}  // namespace openfab::mechanics
