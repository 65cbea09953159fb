// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/lower/code/load_code.h"

#include <elf.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <map>
#include <optional>
#include <system_error>
#include <vector>

#include "compiler/lower/code/machine_code.h"

namespace openfab::lower {

namespace {

using machine::kStubBytes;
constexpr size_t kMostBytes = size_t{1} << 30;

/// The memory of one object: readable and, once `seal` was called, what it is for.
class Mapping {
  public:
    explicit Mapping(size_t bytes) : bytes_(bytes) {
        void* at =
            ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
        if (at != MAP_FAILED) begin_ = static_cast<char*>(at);
    }
    ~Mapping() {
        if (begin_ != nullptr) ::munmap(begin_, bytes_);
    }
    Mapping(const Mapping&) = delete;
    Mapping& operator=(const Mapping&) = delete;

    char* begin() const { return begin_; }
    bool protect(size_t from, size_t to, int protection) {
        return from == to || ::mprotect(begin_ + from, to - from, protection) == 0;
    }

  private:
    size_t bytes_;
    char* begin_ = nullptr;
};

class Loader {
  public:
    explicit Loader(std::string_view object) : object_(object) {}

    std::variant<LoadedKernel, std::string> run(std::string_view function) {
        if (std::string fault = load(); !fault.empty()) return fault;
        const std::optional<uint64_t> address = find(function);
        if (!address) return fmt::format("it has no function `{}`", function);
        return LoadedKernel{mapping_, reinterpret_cast<openfab_kernel_fn>(*address)};
    }

  private:
    std::string load() {
        if (std::string fault = read_headers(); !fault.empty()) return fault;
        if (std::string fault = place(); !fault.empty()) return fault;
        for (const Elf64_Shdr& section : sections_) {
            if (section.sh_type != SHT_RELA || !is_loaded(section.sh_info)) continue;
            if (std::string fault = relocate(section); !fault.empty()) return fault;
        }
        machine::publish(mapping_->begin(), mapping_->begin() + code_end_);
        const bool done = mapping_->protect(0, code_end_, PROT_READ | PROT_EXEC) &&
                          mapping_->protect(code_end_, constant_end_, PROT_READ);
        return done ? "" : std::generic_category().message(errno);
    }

    /// Returns whether an array of T lies in the object.
    template <typename T>
    bool holds(uint64_t offset, uint64_t bytes) const {
        return offset <= object_.size() && bytes <= object_.size() - offset &&
               bytes % sizeof(T) == 0;
    }
    template <typename T>
    std::vector<T> array(uint64_t offset, uint64_t bytes) const {
        std::vector<T> out(bytes / sizeof(T));
        if (bytes > 0) std::memcpy(out.data(), object_.data() + offset, bytes);
        return out;
    }

    std::string read_headers() {
        Elf64_Ehdr header;
        if (object_.size() < sizeof header) return "it is too short";
        std::memcpy(&header, object_.data(), sizeof header);
        if (std::memcmp(header.e_ident, ELFMAG, SELFMAG) != 0 || header.e_type != ET_REL ||
            header.e_machine != machine::kElfMachine || header.e_shentsize != sizeof(Elf64_Shdr))
            return fmt::format("it is no object file for {}", machine::kName);
        const uint64_t bytes = uint64_t{header.e_shnum} * sizeof(Elf64_Shdr);
        if (!holds<Elf64_Shdr>(header.e_shoff, bytes)) return "it is cut off";
        sections_ = array<Elf64_Shdr>(header.e_shoff, bytes);
        if (header.e_shstrndx >= sections_.size()) return "its sections have no names";
        for (const Elf64_Shdr& section : sections_) {
            const bool in_file = section.sh_type != SHT_NOBITS && section.sh_type != SHT_NULL;
            if (in_file && !holds<char>(section.sh_offset, section.sh_size)) return "it is cut off";
            if (&section == &sections_[header.e_shstrndx])
                section_names_ = object_.substr(section.sh_offset, section.sh_size);
            if (section.sh_type != SHT_SYMTAB) continue;
            if (!holds<Elf64_Sym>(section.sh_offset, section.sh_size) ||
                section.sh_link >= sections_.size())
                return "its symbols are cut off";
            symbols_ = array<Elf64_Sym>(section.sh_offset, section.sh_size);
            const Elf64_Shdr& names = sections_[section.sh_link];
            if (names.sh_type != SHT_STRTAB) return "its symbols have no names";
            names_ = object_.substr(names.sh_offset, names.sh_size);
        }
        return "";
    }

    /// Frames tell debuggers how to unwind; nothing unwinds kernels.
    bool is_wanted(const Elf64_Shdr& section) const {
        return (section.sh_flags & SHF_ALLOC) != 0 && section.sh_type != SHT_NOTE &&
               section.sh_type != machine::kUnwindSection && section.sh_size > 0 &&
               text_at(section_names_, section.sh_name) != ".eh_frame";
    }
    static std::string_view text_at(std::string_view texts, size_t at) {
        if (at >= texts.size()) return {};
        const std::string_view from = texts.substr(at);
        return from.substr(0, from.find('\0'));
    }

    bool is_loaded(size_t section) const {
        return section < place_.size() && place_[section].has_value();
    }

    /// Code, then the stubs, then constants, then data, each from a page of its own.
    std::string place() {
        place_.resize(sections_.size());
        const size_t page = static_cast<size_t>(::sysconf(_SC_PAGESIZE));
        size_t end = 0;
        const auto up_to = [&](size_t unit) { end = (end + unit - 1) / unit * unit; };
        bool fits = true;
        const auto add = [&](uint64_t wanted) {
            for (size_t k = 0; k < sections_.size(); ++k) {
                const Elf64_Shdr& section = sections_[k];
                const uint64_t use = section.sh_flags & (SHF_EXECINSTR | SHF_WRITE);
                if (!is_wanted(section) || use != wanted) continue;
                if (section.sh_size > kMostBytes || section.sh_addralign > page) fits = false;
                if (!fits) return;
                up_to(std::max<size_t>(section.sh_addralign, 1));
                place_[k] = end;
                end += section.sh_size;
                if (end > kMostBytes) fits = false;
            }
        };
        add(SHF_EXECINSTR);
        up_to(kStubBytes);
        next_stub_ = end;
        end += kStubBytes * symbols_.size();
        up_to(page);
        code_end_ = end;
        add(0);
        up_to(page);
        constant_end_ = end;
        add(SHF_WRITE);
        up_to(page);
        if (!fits || end == 0) return "it is too large";
        for (size_t k = 0; k < sections_.size(); ++k) {
            if (is_wanted(sections_[k]) && !place_[k]) return "it has code that changes";
        }
        mapping_ = std::make_shared<Mapping>(end);
        if (mapping_->begin() == nullptr) return "there is no memory for it";
        for (size_t k = 0; k < sections_.size(); ++k) {
            const Elf64_Shdr& section = sections_[k];
            if (!place_[k] || section.sh_type == SHT_NOBITS) continue;
            std::memcpy(mapping_->begin() + *place_[k], object_.data() + section.sh_offset,
                        section.sh_size);
        }
        return "";
    }

    uint64_t address_of(size_t offset) const {
        return reinterpret_cast<uint64_t>(mapping_->begin() + offset);
    }

    /// The address of something in the object.
    std::optional<uint64_t> local_address(const Elf64_Sym& symbol) const {
        if (!is_loaded(symbol.st_shndx)) return std::nullopt;
        if (symbol.st_value > sections_[symbol.st_shndx].sh_size) return std::nullopt;
        return address_of(*place_[symbol.st_shndx]) + symbol.st_value;
    }

    std::optional<uint64_t> find(std::string_view function) const {
        for (const Elf64_Sym& symbol : symbols_) {
            if (ELF64_ST_TYPE(symbol.st_info) == STT_FUNC &&
                text_at(names_, symbol.st_name) == function)
                return local_address(symbol);
        }
        return std::nullopt;
    }

    /// The address of what a symbol names: in the object, else a function of this program.
    std::variant<uint64_t, std::string> target_of(uint32_t symbol) const {
        if (symbols_[symbol].st_shndx != SHN_UNDEF) {
            if (const std::optional<uint64_t> local = local_address(symbols_[symbol]))
                return *local;
            return "it refers to what it does not have";
        }
        const std::string_view name = text_at(names_, symbols_[symbol].st_name);
        const void* target = kernel_symbol(name);
        if (target == nullptr) return fmt::format("it calls `{}`, which is not known", name);
        return reinterpret_cast<uint64_t>(target);
    }

    /// The stub that leads there.
    uint64_t stub_of(uint32_t symbol, uint64_t target) {
        if (const auto known = stubs_.find(symbol); known != stubs_.end()) return known->second;
        char* stub = mapping_->begin() + next_stub_;
        machine::write_stub(stub, target);
        const uint64_t address = address_of(next_stub_);
        stubs_.emplace(symbol, address);
        next_stub_ += kStubBytes;
        return address;
    }

    std::string relocate(const Elf64_Shdr& list) {
        if (!holds<Elf64_Rela>(list.sh_offset, list.sh_size)) return "it is cut off";
        const Elf64_Shdr& section = sections_[list.sh_info];
        for (const Elf64_Rela& entry : array<Elf64_Rela>(list.sh_offset, list.sh_size)) {
            const auto symbol = static_cast<uint32_t>(ELF64_R_SYM(entry.r_info));
            const auto type = static_cast<uint32_t>(ELF64_R_TYPE(entry.r_info));
            const size_t width = machine::width(type);
            if (symbol >= symbols_.size() || section.sh_type == SHT_NOBITS ||
                section.sh_size < width || entry.r_offset > section.sh_size - width)
                return "its relocations are damaged";
            const std::variant<uint64_t, std::string> value = value_of(symbol, type);
            if (const auto* fault = std::get_if<std::string>(&value)) return *fault;
            const size_t at = *place_[list.sh_info] + entry.r_offset;
            const uint64_t result =
                std::get<uint64_t>(value) + static_cast<uint64_t>(entry.r_addend);
            if (!machine::relocate(type, mapping_->begin() + at, address_of(at), result))
                return "it is too large";
        }
        return "";
    }

    /// What a relocation refers to.
    std::variant<uint64_t, std::string> value_of(uint32_t symbol, uint32_t type) {
        const machine::Wants wants = machine::wants(type);
        if (wants == machine::Wants::kUnknown)
            return fmt::format("it has a relocation of type {}", type);
        std::variant<uint64_t, std::string> target = target_of(symbol);
        const auto* address = std::get_if<uint64_t>(&target);
        if (address == nullptr) return target;
        if (wants == machine::Wants::kSlot) return stub_of(symbol, *address) + machine::kSlotInStub;
        return symbols_[symbol].st_shndx == SHN_UNDEF ? stub_of(symbol, *address) : *address;
    }

    std::string_view object_;
    std::vector<Elf64_Shdr> sections_;
    std::vector<Elf64_Sym> symbols_;
    std::string_view names_, section_names_;
    std::vector<std::optional<size_t>> place_;  ///< of each section, in the mapping
    std::shared_ptr<Mapping> mapping_;
    std::map<uint32_t, uint64_t> stubs_;  ///< address, by symbol
    size_t next_stub_ = 0;
    size_t code_end_ = 0;
    size_t constant_end_ = 0;
};

}  // namespace

std::variant<LoadedKernel, std::string> load_code(std::string_view object,
                                                  std::string_view function) {
    return Loader(object).run(function);
}

std::variant<LoadedKernel, std::string> bind_code(int (*function)(void** args, void* context),
                                                  void* context) {
    const auto mapping = std::make_shared<Mapping>(machine::kMostCallBytes);
    if (mapping->begin() == nullptr) return "there is no memory for it";
    char* at = mapping->begin();
    const size_t bytes = machine::write_call(at, reinterpret_cast<uint64_t>(function),
                                             reinterpret_cast<uint64_t>(context));
    machine::publish(at, at + bytes);
    if (!mapping->protect(0, bytes, PROT_READ | PROT_EXEC))
        return std::generic_category().message(errno);
    return LoadedKernel{mapping, reinterpret_cast<openfab_kernel_fn>(at)};
}

}  // namespace openfab::lower
