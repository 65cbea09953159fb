// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/source/source_manager.h"

#include <algorithm>
#include <utility>

#include "base/input_file.h"
#include "base/plain_text.h"

namespace openfab::source {

uint32_t SourceManager::add(std::string name, std::string text, std::filesystem::path folder) {
    auto file = std::make_unique<File>();
    file->name = std::move(name);
    file->text = std::move(text);
    file->folder = std::move(folder);
    file->line_starts.push_back(0);
    for (size_t i = 0; i < file->text.size(); ++i) {
        if (file->text[i] == '\n') file->line_starts.push_back(static_cast<uint32_t>(i + 1));
    }
    files_.push_back(std::move(file));
    return static_cast<uint32_t>(files_.size());
}

void SourceManager::replace(const std::filesystem::path& path, std::string text) {
    replaced_[without_links(path)] = std::move(text);
}

std::optional<uint32_t> SourceManager::load(const std::filesystem::path& path, std::string* fault,
                                            const std::vector<std::filesystem::path>& roots) {
    // Undoes as_argument, which callers apply to names that look like options.
    const std::string given = path.string();
    const std::string name = given.starts_with("./") ? given.substr(2) : given;
    const std::filesystem::path folder = path.has_parent_path() ? path.parent_path() : ".";
    if (!replaced_.empty()) {
        const auto text = replaced_.find(without_links(path));
        if (text != replaced_.end()) return add(name, text->second, folder);
    }
    const Result<InputFile> file = InputFile::open(path, roots);
    if (!file) {
        *fault = name + ": cannot be opened: " + file.error().text();
        return std::nullopt;
    }
    if (file->bytes() > static_cast<int64_t>(kMaxFileBytes)) {
        *fault = name + ": is larger than 16 MiB, the limit of a source file";
        return std::nullopt;
    }
    Result<std::string> text = file->read_all(kMaxFileBytes);
    if (!text) {
        *fault = name + ": cannot be read: " + text.error().text();
        return std::nullopt;
    }
    if (const Complaint wide = not_utf8(*text); !wide.empty()) {
        *fault = name + ": " + wide.what + "; " + wide.help;
        return std::nullopt;
    }
    return add(name, PlainText::with_line_feeds(std::move(*text)), folder);
}

const SourceManager::File* SourceManager::file(uint32_t number) const {
    return number == 0 || number > files_.size() ? nullptr : files_[number - 1].get();
}

std::string_view SourceManager::text(uint32_t number) const {
    const File* f = file(number);
    return f == nullptr ? std::string_view{} : std::string_view(f->text);
}

std::string_view SourceManager::text(const Span& span) const {
    const std::string_view all = text(span.file);
    if (span.begin >= all.size() || span.end <= span.begin) return {};
    return all.substr(span.begin, span.end - span.begin);
}

std::string_view SourceManager::name(uint32_t number) const {
    const File* f = file(number);
    return f == nullptr ? std::string_view{} : std::string_view(f->name);
}

std::filesystem::path SourceManager::folder(uint32_t number) const {
    const File* f = file(number);
    return f == nullptr ? std::filesystem::path() : f->folder;
}

std::vector<std::filesystem::path> SourceManager::files() const {
    std::vector<std::filesystem::path> out;
    for (const auto& f : files_) {
        if (!f->folder.empty()) out.emplace_back(f->name);
    }
    return out;
}

uint32_t SourceManager::line_of(const File& f, uint32_t offset) const {
    const auto next = std::upper_bound(f.line_starts.begin(), f.line_starts.end(), offset);
    return static_cast<uint32_t>(next - f.line_starts.begin());
}

Location SourceManager::locate(uint32_t number, uint32_t offset) const {
    const File* f = file(number);
    if (f == nullptr) return {};
    offset = std::min(offset, static_cast<uint32_t>(f->text.size()));
    const uint32_t line = line_of(*f, offset);
    const uint32_t start = f->line_starts[line - 1];
    return {line, 1 + count_code_points(std::string_view(f->text).substr(start, offset - start))};
}

std::string_view SourceManager::line_text(uint32_t number, uint32_t line) const {
    const File* f = file(number);
    if (f == nullptr || line == 0 || line > f->line_starts.size()) return {};
    const uint32_t start = f->line_starts[line - 1];
    std::string_view rest = std::string_view(f->text).substr(start);
    rest = rest.substr(0, rest.find('\n'));
    if (!rest.empty() && rest.back() == '\r') rest.remove_suffix(1);
    return rest;
}

size_t code_point_bytes(std::string_view text, size_t at) {
    const auto lead = static_cast<unsigned char>(text[at]);
    size_t bytes = 1;
    if (lead >= 0xC2 && lead <= 0xDF) bytes = 2;
    if (lead >= 0xE0 && lead <= 0xEF) bytes = 3;
    if (lead >= 0xF0 && lead <= 0xF4) bytes = 4;
    if (at + bytes > text.size()) return 1;
    for (size_t i = 1; i < bytes; ++i) {
        if ((static_cast<unsigned char>(text[at + i]) & 0xC0) != 0x80) return 1;
    }
    return bytes;
}

uint32_t count_code_points(std::string_view text) {
    uint32_t count = 0;
    for (size_t i = 0; i < text.size(); i += code_point_bytes(text, i))
        ++count;
    return count;
}

}  // namespace openfab::source
