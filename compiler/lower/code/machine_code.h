// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What an object file of this machine's processor asks of who loads it (load_code.h). Sources: the ABI supplements of ELF for
// x86-64 and for AArch64.

#include <cstddef>
#include <cstdint>

namespace openfab::lower::machine {

#if defined(__x86_64__)
constexpr const char* kName = "x86-64";
constexpr size_t kSlotInStub = 6;
#elif defined(__aarch64__)
constexpr const char* kName = "arm64";
constexpr size_t kSlotInStub = 8;
#else
#error "no code of this processor can be loaded: add it to machine_code.cpp"
#endif

/// Code that jumps to an address anywhere: a call reaches less than this program may be away. The
/// address in it, at kSlotInStub, also serves loads of it. Stubs begin at multiples of their size.
constexpr size_t kStubBytes = 16;
void write_stub(char* at, uint64_t target);

/// e_machine, and the type of sections that tell how to unwind; 0: there is none.
extern const uint16_t kElfMachine;
extern const uint32_t kUnwindSection;

/// What a relocation wants of its symbol.
enum class Wants {
    kUnknown,
    kAddress,  ///< where it is
    kSlot,     ///< memory that holds where it is
};
Wants wants(uint32_t type);
/// Returns how many bytes a known type changes.
size_t width(uint32_t type);
/// Changes the bytes at `at`, which will run at `place`, to refer to `value`. Returns whether it can
/// be reached.
bool relocate(uint32_t type, char* at, uint64_t place, uint64_t value);

/// Code that calls `function` with the first argument that it gets itself, and with `context`.
constexpr size_t kMostCallBytes = 32;
size_t write_call(char* at, uint64_t function, uint64_t context);

/// Lets the processor see code that was written.
void publish(char* begin, char* end);

}  // namespace openfab::lower::machine
