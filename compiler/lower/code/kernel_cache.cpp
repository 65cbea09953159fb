// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/lower/code/kernel_cache.h"

#include <elf.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <link.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <system_error>
#include <utility>
#include <vector>

#include "base/clean_exit.h"
#include "base/hash.h"
#include "base/input_file.h"
#include "base/own_folder.h"
#include "base/write_all.h"
#include "texture/cache.h"

namespace openfab::lower {

namespace {

namespace fs = std::filesystem;

constexpr std::string_view kSeal = "OFKERNEL";
constexpr size_t kSealBytes = 24;
constexpr std::string_view kSuffix = ".kernel";
constexpr int64_t kLargestEntry = 256 << 20;
constexpr size_t kMemoryBytes = 64 << 20;

/// The note that linkers write into a program or library: a hash of its content. Empty without one.
std::string_view build_id(const dl_phdr_info& object) {
    for (int k = 0; k < object.dlpi_phnum; ++k) {
        const ElfW(Phdr)& segment = object.dlpi_phdr[k];
        if (segment.p_type != PT_NOTE) continue;
        const auto aligned = [&](size_t size) {
            const size_t unit = std::max<size_t>(segment.p_align, 4);
            return (size + unit - 1) / unit * unit;
        };
        const auto* at = reinterpret_cast<const char*>(object.dlpi_addr + segment.p_vaddr);
        for (size_t left = segment.p_memsz; left >= sizeof(ElfW(Nhdr));) {
            ElfW(Nhdr) note;
            std::memcpy(&note, at, sizeof note);
            const size_t content = sizeof note + aligned(note.n_namesz);
            const size_t whole = content + aligned(note.n_descsz);
            if (whole > left) break;
            if (note.n_type == NT_GNU_BUILD_ID && note.n_namesz == sizeof ELF_NOTE_GNU &&
                std::memcmp(at + sizeof note, ELF_NOTE_GNU, sizeof ELF_NOTE_GNU) == 0)
                return {at + content, note.n_descsz};
            at += whole;
            left -= whole;
        }
    }
    return {};
}

struct BuildHash {
    Hasher hash;
    bool is_library = false;  ///< this code is in a library of another program, such as Python
};

bool contains(const dl_phdr_info& object, uintptr_t address) {
    for (const ElfW(Phdr)* header = object.dlpi_phdr;
         header != object.dlpi_phdr + object.dlpi_phnum; ++header) {
        const uintptr_t begin = object.dlpi_addr + header->p_vaddr;
        if (header->p_type == PT_LOAD && address >= begin && address - begin < header->p_memsz)
            return true;
    }
    return false;
}

/// Returns whether a library decides what kernels look like, where the program's others do not.
bool makes_kernels(std::string_view path) {
    const std::string_view file = path.substr(path.rfind('/') + 1);
    return file.starts_with("libHalide") || file.starts_with("libLLVM") ||
           file.starts_with("libm.");
}

/// Adds what tells this program or one of its libraries from every other build of it.
int add_build(dl_phdr_info* object, size_t /*bytes*/, void* build_hash) {
    auto& [hash, is_library] = *static_cast<BuildHash*>(build_hash);
    const std::string_view name = object->dlpi_name;
    const bool is_program = name.empty();
    const bool is_ours = contains(*object, reinterpret_cast<uintptr_t>(&add_build));
    if (is_program) is_library = !is_ours;
    // What else a host has loaded differs from one run to the next.
    if (is_library && !is_ours && !makes_kernels(name)) return 0;
    // Without a path it is the system's own, which computes nothing for us.
    if (!is_program && name.find('/') == std::string_view::npos) return 0;
    if (const std::string_view id = build_id(*object); !id.empty()) {
        hash.add_text(id);
        return 0;
    }
    struct stat status {};
    const std::string path = is_program ? "/proc/self/exe" : std::string(name);
    hash.add_text(name);
    if (::stat(path.c_str(), &status) != 0) return 0;
    hash.add(static_cast<int64_t>(status.st_size));
    hash.add(static_cast<int64_t>(status.st_mtim.tv_sec));
    hash.add(static_cast<int64_t>(status.st_mtim.tv_nsec));
    return 0;
}

/// Hashes OpenFab, Halide, LLVM and the libraries that they compute constants with.
uint64_t compiler_build() {
    static const uint64_t build = [] {
        BuildHash build_hash;
        ::dl_iterate_phdr(add_build, &build_hash);
        Hasher& hash = build_hash.hash;
        // Halide reads these.
        for (const char* name : {"HL_LLVM_ARGS", "HL_PERMIT_FAILED_UNROLL"}) {
            const char* value = std::getenv(name);
            hash.add_text(value != nullptr ? value : "");
        }
        return hash.value();
    }();
    return build;
}

uint64_t hash_of(std::string_view bytes, uint64_t seed) {
    return xxh3({reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size()}, seed);
}

std::string bytes_of(const void* value) {
    return {static_cast<const char*>(value), sizeof(uint64_t)};
}

std::string seal_of(const KernelKey& key, std::string_view code, int64_t stored_bytes) {
    const std::string stored = bytes_of(&stored_bytes);
    const uint64_t hash = hash_of(code, hash_of(key.text() + stored, 0));
    return std::string(kSeal) + stored + bytes_of(&hash);
}

}  // namespace

std::string KernelKey::text() const {
    return fmt::format("{:016x}{:016x}", high, low);
}

KernelKey key_of(const KernelRequest& request) {
    const std::string source = code_source(request);
    return {hash_of(source, compiler_build()), hash_of(source, ~compiler_build())};
}

KernelCache::KernelCache(fs::path folder, int64_t folder_bytes)
    : folder_(std::move(folder)),
      folder_bytes_(folder_bytes),
      memory_(kMemoryBytes, kMemoryBytes) {}

Result<fs::path> KernelCache::own_folder() {
    return texture::cache_folder("kernels");
}

std::shared_ptr<const KernelObject> KernelCache::find(const KernelKey& key) {
    if (auto kept = memory_.find(key.low); kept != nullptr && kept->key == key) return kept;
    if (folder_.empty()) return nullptr;
    std::shared_ptr<const KernelObject> object = read(key);
    if (object != nullptr) memory_.insert(key.low, object);
    return object;
}

void KernelCache::insert(std::shared_ptr<const KernelObject> object) {
    if (!folder_.empty()) write(*object);
    const uint64_t low = object->key.low;
    memory_.insert(low, std::move(object));
}

fs::path KernelCache::entry(const KernelKey& key) const {
    return folder_ / (key.text() + std::string(kSuffix));
}

std::shared_ptr<const KernelObject> KernelCache::read(const KernelKey& key) const {
    const fs::path path = entry(key);
    const Result<InputFile> file = InputFile::open(path);
    if (!file) return nullptr;
    Result<std::string> bytes = file->read_all(kLargestEntry);
    if (!bytes) return nullptr;
    const std::string_view all = *bytes;
    const std::string_view code = all.substr(0, all.size() - std::min(all.size(), kSealBytes));
    const std::string_view seal = all.substr(code.size());
    int64_t stored_bytes = 0;
    if (seal.size() == kSealBytes)
        std::memcpy(&stored_bytes, seal.data() + kSeal.size(), sizeof stored_bytes);
    if (seal != seal_of(key, code, stored_bytes)) {
        ::unlink(path.c_str());
        return nullptr;
    }
    // Now, for `trim`. An older time where that fails does no harm.
    (void)::futimens(file->descriptor(), nullptr);
    auto object = std::make_shared<KernelObject>();
    object->key = key;
    bytes->resize(code.size());
    object->code = std::move(*bytes);
    object->stored_bytes = stored_bytes;
    return object;
}

bool KernelCache::write(const KernelObject& object) const {
    // Written under another name and moved, so that nobody sees half of it. Whoever makes the same
    // kernel at once puts the same in its place.
    fs::path made;
    int descriptor = -1;
    const RemovedAtEnd unfinished([&] {
        descriptor = open_temporary(entry(object.key), &made);
        return descriptor >= 0 ? made : fs::path();
    });
    if (descriptor < 0) return false;
    const bool whole =
        write_all(descriptor, object.code) == 0 &&
        write_all(descriptor, seal_of(object.key, object.code, object.stored_bytes)) == 0 &&
        ::rename(made.c_str(), entry(object.key).c_str()) == 0;
    if (!whole) ::unlink(made.c_str());
    ::close(descriptor);
    return whole;
}

void KernelCache::trim() {
    if (folder_.empty()) return;
    clear_left_over(folder_);
    struct Entry {
        fs::file_time_type used;
        int64_t bytes;
        fs::path path;
    };
    std::vector<Entry> entries;
    int64_t bytes = 0;
    std::error_code status;
    for (fs::directory_iterator at(folder_, status), end; !status && at != end;
         at.increment(status)) {
        std::error_code gone;  // somebody else trims, too
        if (at->path().extension() != kSuffix) continue;
        const Entry found{at->last_write_time(gone), static_cast<int64_t>(at->file_size(gone)),
                          at->path()};
        if (gone) continue;
        entries.push_back(found);
        bytes += found.bytes;
    }
    std::sort(entries.begin(), entries.end(),
              [](const Entry& a, const Entry& b) { return a.used < b.used; });
    for (auto oldest = entries.begin(); bytes > folder_bytes_ && oldest != entries.end();
         ++oldest) {
        ::unlink(oldest->path.c_str());
        bytes -= oldest->bytes;
    }
}

std::variant<MadeKernel, Fault> find_or_compile(const KernelRequest& request, const KernelKey& key,
                                                KernelCache* cache) {
    if (cache != nullptr) {
        if (auto found = cache->find(key)) return MadeKernel{std::move(found), false};
    }
    auto compiled = compile_object(request);
    if (auto* fault = std::get_if<Fault>(&compiled)) return std::move(*fault);
    auto& kernel = std::get<CompiledKernel>(compiled);
    auto object = std::make_shared<const KernelObject>(
        KernelObject{key, std::move(kernel.code), kernel.stored_bytes});
    if (cache != nullptr) cache->insert(object);
    return MadeKernel{std::move(object), true};
}

}  // namespace openfab::lower
