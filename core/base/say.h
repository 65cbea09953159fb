// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The only place where programs write messages, to standard error, and results, to standard output.
// Text from outside is made printable, so that they cannot control the terminal (text.h). A message
// that cannot be written is ignored; a result that cannot be written is an error.

#include <string_view>

#include "base/result.h"

namespace openfab {

/// Must be the first call of every main. Opens closed descriptors among 0 to 2, so that no output
/// file gets one of these numbers and receives messages; reading and writing them still fails.
/// Turns SIGPIPE into a failed write.
void prepare_streams();

/// Writes lines to standard error as they are.
void say(std::string_view text);
/// Write one line to standard error: `note: message`, `warning: message`.
void note(std::string_view message);
void warn(std::string_view message);
/// Writes an error, with its source line where it names one (caret.h), and returns the exit code. One without a message
/// has been said before; an interruption is said once (clean_exit.h).
int say_error(const Error& error);

/// Writes a message to standard output; written_out reports failures.
void show(std::string_view text);
/// Writes raw bytes to standard output.
void write_out(std::string_view data);
/// Flushes standard output; fails where anything could not be written.
Result<void> written_out();

}  // namespace openfab
