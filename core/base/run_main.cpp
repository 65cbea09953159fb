// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "base/run_main.h"

#include <fmt/format.h>

#include <cstdio>
#include <exception>
#include <new>
#include <string>
#include <system_error>

#include "base/clean_exit.h"
#include "base/messages.h"
#include "base/result.h"
#include "base/system_reason.h"

namespace openfab {

int run_main(int (*program)(int argc, char** argv), int argc, char** argv) noexcept {
    const int code = run_guarded([&] { return program(argc, argv); });
    wait_if_ending();
    return code;
}

void run_thread(const std::function<void()>& body) noexcept {
    const int code = run_guarded([&] {
        body();
        return 0;
    });
    if (code != 0) end_cleanly(code);
}

int run_guarded(const std::function<int()>& body) noexcept {
    try {
        return body();
    } catch (const std::bad_alloc&) {
        // Without memory for a message that is put together.
        (void)std::fprintf(stderr, "error: %s\n", messages::kMemoryRanOut);
        return exit_code(ErrorCode::kOutside);
    } catch (const std::system_error& error) {
        // As of a thread that the system does not start.
        const std::string reason = system_reason(error.code().value());
        const std::string said = fmt::format(messages::kSystemRefuses, reason);
        // Not fmt::print, which throws where nothing can be written.
        (void)std::fprintf(stderr, "error: %s\n", said.c_str());
        return exit_code(ErrorCode::kOutside);
    } catch (const std::exception& exception) {
        (void)std::fprintf(stderr, "error: internal error: %s\n", exception.what());
        return exit_code(ErrorCode::kInternal);
    } catch (...) {
        (void)std::fputs("error: internal error\n", stderr);
        return exit_code(ErrorCode::kInternal);
    }
}

}  // namespace openfab
