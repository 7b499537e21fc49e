#pragma once

#include "can/dbc/dbc.hpp"

namespace servohil::can {

/// `message` may join those of `database`: its id has 11 or 29 bits, neither name nor id is there already,
/// its signals have different names, lie inside it, and those that a frame can have together do not overlap
/// (extended multiplexing: not looked at).
/// @throws UsageError "FILE:LINE: ..."
void CheckNewMessage(const Database& database, const Message& message);

/// The codec can read and write `message`: at most 64 bytes, no extended multiplexing, IEEE 754 numbers of 32
/// or 64 bits.
/// @throws UsageError "FILE:LINE: ..."
void CheckUsable(const Database& database, const Message& message);

}  // namespace servohil::can
