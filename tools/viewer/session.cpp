// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/viewer/session.h"

#include <fmt/format.h>

#include <filesystem>
#include <utility>

#include "tools/viewer/messages.h"

namespace openfab::viewer {

ViewedPrint::ViewedPrint(std::unique_ptr<prints::PrintFile> file, std::string name)
    : file_(std::move(file)), name_(std::move(name)), slices_(file_.get()), cuts_(&slices_) {}

Result<std::shared_ptr<ViewedPrint>> ViewedPrint::open(const std::string& path, std::string name,
                                                       int64_t memory_bytes) {
    Result<std::unique_ptr<prints::PrintFile>> file = prints::PrintFile::open(path, memory_bytes);
    if (!file) return file.error();
    return std::shared_ptr<ViewedPrint>(new ViewedPrint(std::move(*file), std::move(name)));
}

Volume& ViewedPrint::volume() {
    const std::lock_guard lock(volume_mutex_);
    if (volume_ == nullptr) volume_ = std::make_unique<Volume>(&slices_);
    return *volume_;
}

Volume& Compared::volume() {
    const std::lock_guard lock(volume_mutex_);
    if (volume_ == nullptr)
        volume_ = std::make_unique<Volume>(&first_->slices(), &second_->slices());
    return *volume_;
}

std::shared_ptr<Compared> Session::begin_generation() {
    ++prints_.generation;
    std::shared_ptr<Compared> made;
    if (prints_.list.size() == 2 &&
        why_not_compared(prints_.list[0]->file().info(), prints_.list[1]->file().info()).empty())
        made = std::make_shared<Compared>(prints_.list[0], prints_.list[1]);
    return std::exchange(prints_.compared, std::move(made));
}

Result<void> Session::open(const std::string& path) {
    Result<std::shared_ptr<ViewedPrint>> print =
        ViewedPrint::open(path, std::filesystem::path(path).filename().string(), memory_bytes_);
    if (!print) return print.error();
    std::shared_ptr<Compared> ended;
    const std::lock_guard lock(mutex_);
    prints_.list.push_back(std::move(*print));
    ended = begin_generation();
    return {};
}

Result<void> Session::show(const std::string& path, const std::string& name) {
    Result<std::shared_ptr<ViewedPrint>> print = ViewedPrint::open(path, name, memory_bytes_);
    if (!print) return print.error();
    std::shared_ptr<ViewedPrint> old;  // both end, with their threads, after the lock
    std::shared_ptr<Compared> ended;
    const std::lock_guard lock(mutex_);
    if (prints_.list.empty()) {
        prints_.list.push_back(std::move(*print));
    } else {
        old = std::exchange(prints_.list.front(), std::move(*print));
    }
    ended = begin_generation();
    return {};
}

Session::Prints Session::prints() const {
    const std::lock_guard lock(mutex_);
    return prints_;
}

void Session::look_again() {
    const Prints before = prints();
    for (size_t i = 0; i < before.list.size(); ++i) {
        ViewedPrint& print = *before.list[i];
        if (!print.file().was_replaced()) {
            print.file().look_again();
            continue;
        }
        // One that is being begun has no whole header yet: the next time, then.
        Result<std::shared_ptr<ViewedPrint>> anew =
            ViewedPrint::open(print.file().path(), print.name(), memory_bytes_);
        if (!anew) continue;
        std::shared_ptr<Compared> ended;
        const std::lock_guard lock(mutex_);
        if (prints_.list[i] != before.list[i]) continue;
        prints_.list[i] = std::move(*anew);
        ended = begin_generation();
    }
}

std::string why_not_compared(const pipeline::PrintInfo& a, const pipeline::PrintInfo& b) {
    if (a.size.x == b.size.x && a.size.y == b.size.y && a.size.z == b.size.z) return {};
    return fmt::format(messages::kGridsDiffer, a.size.x, a.size.y, a.size.z, b.size.x, b.size.y,
                       b.size.z);
}

}  // namespace openfab::viewer
