#pragma once

#include "servohil/can/dbc.hpp"

namespace servohil::can {

/// `message` may join those of `database`: its id has 11 or 29 bits, neither name nor id is there already,
/// its signals have different names, lie inside it and (multiplexed ones apart) do not overlap.
/// @throws UsageError "FILE:LINE: ..."
void CheckNewMessage(const Database& database, const Message& message);

}  // namespace servohil::can
