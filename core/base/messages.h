// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the foundation says of files, JSON, XML, numbers, folders and programs: OPENFAB_MESSAGE(name, "text"), by file,
// each remedy behind what it is for. Tests name rows, so wording is changed here alone.

#include "base/message.h"

// clang-format off
namespace openfab::messages {

// command_line
OPENFAB_MESSAGE(kNoSuchArgument, "there is no {} `{}`")
OPENFAB_MESSAGE(kTooManyArguments, "`{}` is one argument too many")
OPENFAB_MESSAGE(kHelpLists, "`{} --help` lists the {}")

// input_file
OPENFAB_MESSAGE(kKindFolder, "a folder")
OPENFAB_MESSAGE(kKindPipe, "a pipe")
OPENFAB_MESSAGE(kKindSocket, "a socket")
OPENFAB_MESSAGE(kKindDevice, "a device")
OPENFAB_MESSAGE(kNotAFile, "it is not a file")
OPENFAB_MESSAGE(kKindNotAFile, "it is {}, not a file")
OPENFAB_MESSAGE(kPlaceUnknown, "the system does not say where it is: {}")
OPENFAB_MESSAGE(kNotBelow, "it is `{}`, which is not below `{}`")
OPENFAB_MESSAGE(kLargerThan, "it is larger than {}")

// jail
OPENFAB_MESSAGE(kCannotMakePipe, "cannot make a pipe: ")
OPENFAB_MESSAGE(kCannotStartProcess, "cannot start a process: ")
OPENFAB_MESSAGE(kWithinFile, "`, at `{}")
OPENFAB_MESSAGE(kReaderCrashed, "the reader of `{}` ended with signal {} ({})")
OPENFAB_MESSAGE(kReaderCrashedHelp, "the file is damaged, or was made to do harm; save it again with the program that it is from")
OPENFAB_MESSAGE(kReaderTakesLong, "the reader of `{}` took more than {} s of the processor")
OPENFAB_MESSAGE(kReaderTakesLongHelp, "no sound file of its size takes as long")
OPENFAB_MESSAGE(kReaderTakesMemory, "the reader of `{}` took far more memory than the {} that it may take")
OPENFAB_MESSAGE(kReaderTakesMemoryHelp, "if the file is sound, allow more, as with `--memory 4GB`")
OPENFAB_MESSAGE(kReaderStandsStill, "the reader of `{}` stands still")
OPENFAB_MESSAGE(kReaderEnded, "the reader of `{}` ended without an answer")
OPENFAB_MESSAGE(kReaderNonsense, "what was read of `{}` contradicts itself")

// json
OPENFAB_MESSAGE(kDuplicateKey, "duplicate key `{}`")
OPENFAB_MESSAGE(kDuplicateKeyHelp, "it is first given at line {}")
OPENFAB_MESSAGE(kTooManyValues, "more than {} values")
OPENFAB_MESSAGE(kValuesTakeTooMuch, "more than {} values, which take more memory than is allowed")
OPENFAB_MESSAGE(kAllowMoreMemory, "allow more, as with `--memory 4GB`")
OPENFAB_MESSAGE(kNotJson, "not valid JSON")
OPENFAB_MESSAGE(kLeadingZero, "a number has a leading zero")
OPENFAB_MESSAGE(kNotANumber, "`{}` is not a number")
OPENFAB_MESSAGE(kLargestNumber, "at most 1.8e308 is possible")
OPENFAB_MESSAGE(kNumberTooLarge, "the number `{}{}` is too large")
OPENFAB_MESSAGE(kNestedTooDeep, "nested more than {} levels deep")
OPENFAB_MESSAGE(kExpectedKey, "a key in double quotes")
OPENFAB_MESSAGE(kExpectedMemberEnd, "`,` or `}`")
OPENFAB_MESSAGE(kExpectedItemEnd, "`,` or `]`")
OPENFAB_MESSAGE(kExpectedValue, "a value")
OPENFAB_MESSAGE(kExpectedFileEnd, "the end of the file")
OPENFAB_MESSAGE(kNoClosingQuote, "the string has no closing quote")
OPENFAB_MESSAGE(kInString, "in a string: {}")
OPENFAB_MESSAGE(kNotUtf8InString, "ill-formed UTF-8 byte")
OPENFAB_MESSAGE(kControlInString, "the control character {0:#04x} is written as `\\u{0:04x}`")
OPENFAB_MESSAGE(kEscapeInString, "after a backslash stands one of `\"\\/bfnrt`, or `u` and a code point in four hexadecimal digits")
OPENFAB_MESSAGE(kCommaAtEnd, "a comma before `{}` must not follow the last element; delete it")
OPENFAB_MESSAGE(kNotJsonComments, "JSON has no comments")
OPENFAB_MESSAGE(kNotJsonCommentsHelp, "delete this one")
OPENFAB_MESSAGE(kDoubleQuotes, "strings are written in double quotes")
OPENFAB_MESSAGE(kFileEndsBefore, "the file ends where {} should be")
OPENFAB_MESSAGE(kOtherExpected, "`{}` where {} should be")
OPENFAB_MESSAGE(kKindBoolean, "a boolean")
OPENFAB_MESSAGE(kKindNumber, "a number")
OPENFAB_MESSAGE(kKindString, "a string")
OPENFAB_MESSAGE(kKindArray, "an array")
OPENFAB_MESSAGE(kKindObject, "an object")
OPENFAB_MESSAGE(kZeroByte, "a zero byte")
OPENFAB_MESSAGE(kZeroByteHelp, "the file is not text")
OPENFAB_MESSAGE(kCannotRead, "cannot read {}: ")

// near_miss
OPENFAB_MESSAGE(kThereAreNone, "there are none")
OPENFAB_MESSAGE(kDidYouMean, "did you mean `{}`?")
OPENFAB_MESSAGE(kKnownNames, "known: {}")
OPENFAB_MESSAGE(kAndMore, " and {} more")

// own_folder
OPENFAB_MESSAGE(kCannotBeMade, "it cannot be created: {}")
OPENFAB_MESSAGE(kItself, "it")
OPENFAB_MESSAGE(kFolderAbove, "`{}` above it")
OPENFAB_MESSAGE(kNotAFolder, "{} is not a folder")
OPENFAB_MESSAGE(kOthersFolder, "{} belongs to another user ({})")
OPENFAB_MESSAGE(kOthersCanWrite, "others can write to {} (mode {:o}); run `chmod go-w` on it")
OPENFAB_MESSAGE(kCannotBeWrittenTo, "it cannot be written to: {}")
OPENFAB_MESSAGE(kNoTemporaryFolder, "there is no folder for temporary files: {}; set TMPDIR to one")
OPENFAB_MESSAGE(kCannotMakeFolder, "cannot create a folder in `{}`: {}")
OPENFAB_MESSAGE(kCannotOpenFolder, "cannot open a folder in `{}`: {}")

// plain_text
OPENFAB_MESSAGE(kWideText, "the file is text in {}")
OPENFAB_MESSAGE(kWideTextHelp, "save it as UTF-8")

// polar
OPENFAB_MESSAGE(kTransformNotFinite, "the transform has a value that is not finite")
OPENFAB_MESSAGE(kTransformFlattens, "the transform flattens the object: its determinant is {:.3g}")
OPENFAB_MESSAGE(kTransformFlattensHelp, "no scale may be 0 or close to it")

// replace_file
OPENFAB_MESSAGE(kCannotWrite, "cannot write `{}`: {}")
OPENFAB_MESSAGE(kCannotCopy, "cannot copy `{}` to `{}`: {}")
OPENFAB_MESSAGE(kOutputIsNoFile, "`{}` is {}; the output must be a file")

// run_main
OPENFAB_MESSAGE(kMemoryRanOut, "memory ran out")
OPENFAB_MESSAGE(kSystemRefuses, "the system refuses a resource: {}")

// say
OPENFAB_MESSAGE(kCannotWriteOut, "cannot write to standard output")
OPENFAB_MESSAGE(kCannotWriteOutBecause, "cannot write to standard output: {}")

// scan_number
OPENFAB_MESSAGE(kNotFinite, "`{}` is not finite or too large")
OPENFAB_MESSAGE(kNotWholeNumber, "`{}` is not a whole number from {} to {}")

// system_reason
OPENFAB_MESSAGE(kAllowMoreFiles, "; allow more (`ulimit -n`)")
OPENFAB_MESSAGE(kFileSizeLimited, "; perhaps `ulimit -f` limits it")
OPENFAB_MESSAGE(kAllowMoreAddresses, "; allow more (`ulimit -v`), or free some")
OPENFAB_MESSAGE(kAllowMoreThreads, "; allow more memory (`ulimit -v`), or processes and threads (`ulimit -u`)")
OPENFAB_MESSAGE(kAllowMoreProcesses, "; allow more processes and threads (`ulimit -u`)")

// start_program
OPENFAB_MESSAGE(kNoOwnFolder, "cannot find the program's own folder: ")

// talking_program
OPENFAB_MESSAGE(kTheGenerator, "the generator")
OPENFAB_MESSAGE(kOtherProcess, "the world names a generator of another process")
OPENFAB_MESSAGE(kOtherProcessHelp, "a world with functions of Python prints only in the process that made it")
OPENFAB_MESSAGE(kNoLine, "cannot create a line to `{}`: {}")
OPENFAB_MESSAGE(kDoesNotStart, "`{}` does not start: {}")
OPENFAB_MESSAGE(kDoesNotStartHelp, "its first word must be a program on the PATH, or a path from the world's folder that begins with `./`")
OPENFAB_MESSAGE(kHasEnded, "has ended")
OPENFAB_MESSAGE(kEndedBySignal, "was ended by signal {} ({})")
OPENFAB_MESSAGE(kEndedWithCode, "has ended with exit code {}")
OPENFAB_MESSAGE(kClosedOutput, "has closed its output")
OPENFAB_MESSAGE(kEndedBeforeAnswer, "`{}` {} before it answered `{}`")
OPENFAB_MESSAGE(kEndedBeforeAnswerHelp, "it must answer lines until its input ends")
OPENFAB_MESSAGE(kFailedBefore, "`{}` has failed before")
OPENFAB_MESSAGE(kWroteUnasked, "`{}` wrote `{}` before it was asked `{}`")
OPENFAB_MESSAGE(kWroteUnaskedHelp, "let it write to its standard output only to answer, and end each answer with one line `done`")
OPENFAB_MESSAGE(kInterrupted, "interrupted")
OPENFAB_MESSAGE(kNoAnswerInTime, "`{}` has not answered `{}` within {:g} s")
OPENFAB_MESSAGE(kNoAnswerInTimeHelp, "let it write less at a time and flush its output after the line `done`, or give it more `answer_s`")
OPENFAB_MESSAGE(kWroteAfterDone, "`{}` wrote more after the `done` of `{}`")
OPENFAB_MESSAGE(kWroteAfterDoneHelp, "it must answer one line at a time, with one `done` each")
OPENFAB_MESSAGE(kAnswerTooLong, "`{}` wrote more than {} MB to answer `{}`")
OPENFAB_MESSAGE(kAnswerTooLongHelp, "let it hand on parts of the answer with lines `more`, or give it more `answer_mb`")

// units
OPENFAB_MESSAGE(kNotAQuantity, "`{}` is not {}; write it as `{}`")
OPENFAB_MESSAGE(kNoUnit, "`{}` has no unit; write `{}`")
OPENFAB_MESSAGE(kWrongUnit, "`{}` has the unknown unit `{}`; write `{}`, or another of {}")
OPENFAB_MESSAGE(kALength, "a length")
OPENFAB_MESSAGE(kASize, "a size")
OPENFAB_MESSAGE(kNotAMemorySize, "`{}` is not a usable memory size")
OPENFAB_MESSAGE(kATime, "a time")
OPENFAB_MESSAGE(kMemoryOption, "`--memory`: {}")

// xml
OPENFAB_MESSAGE(kNestedElements, "elements are nested too deep")
OPENFAB_MESSAGE(kDocumentType, "a document type declaration is not allowed")
OPENFAB_MESSAGE(kEntityDeclaration, "a declaration of an entity is not allowed")
OPENFAB_MESSAGE(kAttributeDeclaration, "a declaration of attributes is not allowed")
OPENFAB_MESSAGE(kUnknownEntity, "the entity `{}` is unknown")
OPENFAB_MESSAGE(kOutOfMemory, "out of memory")
OPENFAB_MESSAGE(kLongToken, "a tag or comment is longer than {} MB")

// conditions
OPENFAB_MESSAGE(kTemperatureWanted, "{} was measured at {:g} to {:g} C; which temperature is meant?")
OPENFAB_MESSAGE(kTemperatureWantedHelp, "give it, such as `--temperature 23C`")
OPENFAB_MESSAGE(kRateWanted, "{} was measured at rates of {:.3g} to {:.3g}/s; which is meant?")
OPENFAB_MESSAGE(kRateWantedHelp, "give it, such as `--rate 0.01/s`, or the time in which the load is applied, `--rate 100s`")
OPENFAB_MESSAGE(kConditionOutside, "{} was not measured at {}, and is not extrapolated")
OPENFAB_MESSAGE(kConditionOutsideHelp, "it was from {:g} to {:g} C and from {:.3g} to {:.3g}/s, perhaps not at each rate at each temperature")
OPENFAB_MESSAGE(kConditionRows, "{}: a list has from 1 to {} rows")
OPENFAB_MESSAGE(kConditionRow, "a row is an object of three numbers: `T_C`, and `rate_1_s` and `value` above 0")
OPENFAB_MESSAGE(kConditionTwice, "{:g} C and {:g}/s are there twice")
OPENFAB_MESSAGE(kTemperatureText, "`{}` is no temperature; write it as `23C`")
OPENFAB_MESSAGE(kRateText, "`{}` is no rate; write it as `0.01/s`, `1Hz`, or as the time of a load, `100s`")
OPENFAB_MESSAGE(kNumberOrList, "{} must be a number, or a list of rows with `T_C`, `rate_1_s` and `value`")
OPENFAB_MESSAGE(kNumberNotAboveZero, "{} is {}, not above 0")

}  // namespace openfab::messages
