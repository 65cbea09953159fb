// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The one place where programs write text for people, to standard error, and results, to standard
// output. Names of others cannot command the terminal (text.h), and a message that nobody can read
// ends nothing: its failure is passed over. A result that cannot be written is an error.

#include <string_view>

#include "base/result.h"

namespace openfab {

/// The first call of every main. Descriptors 0 to 2 that are closed are opened, so that no output
/// takes the number of one and gets messages between its bytes; what is read from or written to
/// them still fails. A closed pipe is an error of the write, not a signal that ends the process.
void prepare_streams();

/// To standard error, lines as they are.
void say(std::string_view text);
/// One line: `note: message`, `warning: message`.
void note(std::string_view message);
void warn(std::string_view message);
/// What Result ends a program with, with its place in a file where it has one (caret.h); the exit
/// code.
int say_error(const Error& error);

/// To standard output, text for people. Whether all of it could be written, written_out tells.
void show(std::string_view text);
/// To standard output, bytes for programs, as they are.
void write_out(std::string_view data);
Result<void> written_out();

}  // namespace openfab
