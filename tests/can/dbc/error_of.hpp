#pragma once
/// What opening a bus says when it fails.

#include <string>

#include "can/bus.hpp"

namespace servohil::can {

template <typename Error>
std::string ErrorOf(const std::string& url) {
  try {
    OpenBus(url, BusOptions{});
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

}  // namespace servohil::can
