// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/lower/code/machine_code.h"

#include <elf.h>

#include <cstring>

namespace openfab::lower::machine {

namespace {

/// Returns whether a signed number has at most so many bits.
bool fits(int64_t value, int bits) {
    const int64_t limit = int64_t{1} << (bits - 1);
    return value >= -limit && value < limit;
}

}  // namespace

#if defined(__x86_64__)

const uint16_t kElfMachine = EM_X86_64;
const uint32_t kUnwindSection = SHT_X86_64_UNWIND;

void write_stub(char* at, uint64_t target) {
    // ff 25 00 00 00 00   jmp *0(%rip)
    std::memcpy(at, "\xff\x25\0\0\0\0", kSlotInStub);
    std::memcpy(at + kSlotInStub, &target, sizeof target);
}

Wants wants(uint32_t type) {
    switch (type) {
        case R_X86_64_PC32:
        case R_X86_64_PLT32:
        case R_X86_64_64:
            return Wants::kAddress;
        case R_X86_64_GOTPCREL:
        case R_X86_64_GOTPCRELX:
        case R_X86_64_REX_GOTPCRELX:
            return Wants::kSlot;
        default:
            return Wants::kUnknown;
    }
}

size_t width(uint32_t type) {
    return type == R_X86_64_64 ? 8 : 4;
}

bool relocate(uint32_t type, char* at, uint64_t place, uint64_t value) {
    if (width(type) == 4) {
        value -= place;
        if (!fits(static_cast<int64_t>(value), 32)) return false;
    }
    std::memcpy(at, &value, width(type));
    return true;
}

size_t write_call(char* at, uint64_t function, uint64_t context) {
    // The argument arrives in rdi, where it stays:
    //   48 be …   mov $context, %rsi
    //   48 b8 …   mov $function, %rax
    //   ff e0     jmp *%rax
    std::memcpy(at, "\x48\xbe", 2);
    std::memcpy(at + 2, &context, sizeof context);
    std::memcpy(at + 10, "\x48\xb8", 2);
    std::memcpy(at + 12, &function, sizeof function);
    std::memcpy(at + 20, "\xff\xe0", 2);
    return 22;
}

void publish(char* /*begin*/, char* /*end*/) {}

#elif defined(__aarch64__)

const uint16_t kElfMachine = EM_AARCH64;
const uint32_t kUnwindSection = SHT_NULL;

namespace {

/// ldr xTO, #BYTES: from so many bytes after the instruction.
uint32_t load(uint32_t to, uint32_t bytes) {
    return 0x58000000u | bytes / 4 << 5 | to;
}
constexpr uint32_t kJumpToX16 = 0xd61f0200;
constexpr uint32_t kNothing = 0xd503201f;

/// Puts the low bits of `value` into an instruction, from bit `first`.
void set_field(char* at, int first, int bits, uint64_t value) {
    uint32_t word = 0;
    std::memcpy(&word, at, sizeof word);
    const uint32_t mask = (1u << bits) - 1;
    word = (word & ~(mask << first)) | (static_cast<uint32_t>(value) & mask) << first;
    std::memcpy(at, &word, sizeof word);
}

/// By how many bits the offset in its page is shifted where a load or store of a size has it; -1:
/// the type is none of these.
int scale(uint32_t type) {
    switch (type) {
        case R_AARCH64_ADD_ABS_LO12_NC:
        case R_AARCH64_LDST8_ABS_LO12_NC:
            return 0;
        case R_AARCH64_LDST16_ABS_LO12_NC:
            return 1;
        case R_AARCH64_LDST32_ABS_LO12_NC:
            return 2;
        case R_AARCH64_LDST64_ABS_LO12_NC:
        case R_AARCH64_LD64_GOT_LO12_NC:
            return 3;
        case R_AARCH64_LDST128_ABS_LO12_NC:
            return 4;
        default:
            return -1;
    }
}

}  // namespace

void write_stub(char* at, uint64_t target) {
    const uint32_t code[2] = {load(16, kSlotInStub), kJumpToX16};
    std::memcpy(at, code, sizeof code);
    std::memcpy(at + kSlotInStub, &target, sizeof target);
}

Wants wants(uint32_t type) {
    switch (type) {
        case R_AARCH64_ABS64:
        case R_AARCH64_PREL64:
        case R_AARCH64_PREL32:
        case R_AARCH64_ADR_PREL_PG_HI21:
        case R_AARCH64_CALL26:
        case R_AARCH64_JUMP26:
            return Wants::kAddress;
        case R_AARCH64_ADR_GOT_PAGE:
            return Wants::kSlot;
        case R_AARCH64_LD64_GOT_LO12_NC:
            return Wants::kSlot;
        default:
            return scale(type) >= 0 ? Wants::kAddress : Wants::kUnknown;
    }
}

size_t width(uint32_t type) {
    return type == R_AARCH64_ABS64 || type == R_AARCH64_PREL64 ? 8 : 4;
}

bool relocate(uint32_t type, char* at, uint64_t place, uint64_t value) {
    constexpr uint64_t kInPage = 0xfff;
    const auto away = static_cast<int64_t>(value - place);
    switch (type) {
        case R_AARCH64_ABS64:
            std::memcpy(at, &value, 8);
            return true;
        case R_AARCH64_PREL64:
            std::memcpy(at, &away, 8);
            return true;
        case R_AARCH64_PREL32:
            std::memcpy(at, &away, 4);
            return fits(away, 32);
        case R_AARCH64_CALL26:
        case R_AARCH64_JUMP26:
            set_field(at, 0, 26, static_cast<uint64_t>(away >> 2));
            return fits(away, 28);
        case R_AARCH64_ADR_PREL_PG_HI21:
        case R_AARCH64_ADR_GOT_PAGE: {
            const auto pages = static_cast<int64_t>((value & ~kInPage) - (place & ~kInPage)) >> 12;
            set_field(at, 29, 2, static_cast<uint64_t>(pages));
            set_field(at, 5, 19, static_cast<uint64_t>(pages >> 2));
            return fits(pages, 21);
        }
        default:
            set_field(at, 10, 12, (value & kInPage) >> scale(type));
            return true;
    }
}

size_t write_call(char* at, uint64_t function, uint64_t context) {
    // The argument arrives in x0, where it stays; the context goes to x1.
    const uint32_t code[4] = {load(1, 16), load(16, 20), kJumpToX16, kNothing};
    std::memcpy(at, code, sizeof code);
    std::memcpy(at + 16, &context, sizeof context);
    std::memcpy(at + 24, &function, sizeof function);
    return 32;
}

void publish(char* begin, char* end) {
    __builtin___clear_cache(begin, end);
}

#endif

}  // namespace openfab::lower::machine
