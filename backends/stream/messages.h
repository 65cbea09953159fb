// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What is said of lines to receivers: OPENFAB_MESSAGE(name, "text"), by file, each remedy behind what it is for. Tests
// name rows, so wording is changed here alone.

#include "base/message.h"

// clang-format off
namespace openfab::stream::messages {

// address
OPENFAB_MESSAGE(kCannotFind, "cannot find")
OPENFAB_MESSAGE(kCannotListen, "cannot listen at")
OPENFAB_MESSAGE(kPathTaken, "`{}` is a file; name one that does not exist")
OPENFAB_MESSAGE(kAnotherListens, "another process does")
OPENFAB_MESSAGE(kSocketPathLength, "`{}`: a socket's path has 1 to {} bytes")
OPENFAB_MESSAGE(kNoAddress, "`{}` is not an address; write `tcp://HOST:PORT`, `tls://HOST:PORT` or `unix:PATH`")
OPENFAB_MESSAGE(kCannotConnect, "cannot connect to")
OPENFAB_MESSAGE(kUserNumber, "user {}")
OPENFAB_MESSAGE(kThisMachine, "this machine")
OPENFAB_MESSAGE(kCannotReadBefore, "cannot read `{}`: ")
OPENFAB_MESSAGE(kNoToken, "`{}` holds no token")
OPENFAB_MESSAGE(kTokenLength, "the token has {} bytes; {} are possible")

// message
OPENFAB_MESSAGE(kNoPrint, "this is not a print")
OPENFAB_MESSAGE(kOtherProtocol, "it speaks version {} of the protocol; this is version {}")
OPENFAB_MESSAGE(kFirstMessageDamaged, "its first message is damaged")
OPENFAB_MESSAGE(kAnswerDamaged, "its answer is damaged")
OPENFAB_MESSAGE(kAcknowledgementDamaged, "its acknowledgement is damaged")
OPENFAB_MESSAGE(kMessageTooLong, "a message of {} bytes, where {} are possible")

// stream_sink
OPENFAB_MESSAGE(kSliceDamaged, "a slice came back damaged")
OPENFAB_MESSAGE(kReceiverSays, "{}: the receiver says: {}")
OPENFAB_MESSAGE(kGiveToken, "give it with `--token-file FILE` or in OPENFAB_TOKEN")
OPENFAB_MESSAGE(kLineCut, "{}: the line was cut")
OPENFAB_MESSAGE(kInterruptedComingBack, "interrupted while slices came back")
OPENFAB_MESSAGE(kNoReceiver, ": this is not a receiver of prints")
OPENFAB_MESSAGE(kNoSuchSlice, ": it asks for a slice that does not exist")
OPENFAB_MESSAGE(kNoEventfd, "cannot make an eventfd")
OPENFAB_MESSAGE(kLineCutAtFirst, ": the line was cut before the first slice")
OPENFAB_MESSAGE(kLineCutComingBack, ": the line was cut while slices came back")
OPENFAB_MESSAGE(kNotAllCameBack, ": it did not send back all the slices that it kept")
OPENFAB_MESSAGE(kInterruptedNoRoom, "interrupted while {} had no room for slice {}")
OPENFAB_MESSAGE(kSenderLeaves, "the sender leaves")
OPENFAB_MESSAGE(kLineCutAfter, ": the line was cut")
OPENFAB_MESSAGE(kSlicesLost, "{}: the receiver has lost slices that it had kept: it is at {}, after {}")
OPENFAB_MESSAGE(kNoOtherLine, "{}, and no other could be made for {:.0f} s")

// tls
OPENFAB_MESSAGE(kOtherEndClosed, "the other end closed it")
OPENFAB_MESSAGE(kCannotReadFrom, "cannot read {} from `{}`: {}")
OPENFAB_MESSAGE(kCannotBeginTls, "cannot begin TLS: ")
OPENFAB_MESSAGE(kKeyOfCertificate, "the key of the certificate, without a password,")
OPENFAB_MESSAGE(kACertificate, "a certificate")
OPENFAB_MESSAGE(kCannotBeginTlsWith, "cannot begin TLS with {}: {}")
OPENFAB_MESSAGE(kNoTlsAnswer, "{}: it does not answer as TLS does")
OPENFAB_MESSAGE(kNotTrusted, "{}: its certificate is not trusted: {}")
OPENFAB_MESSAGE(kNotTrustedHelp, "`--tls-ca FILE` names the certificates to trust")
OPENFAB_MESSAGE(kNoTls, "{}: no TLS: {}")

}  // namespace openfab::stream::messages
