#pragma once
/// Reader of candump logs (can-utils `candump -l`, python-can, SavvyCAN, our own bus.log):
///   (1436509052.249713) vcan0 044#2A366C2BBA

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "can/frame.hpp"

namespace servohil::run {

/// A frame, and where it stands.
struct LoggedFrame {
  can::Frame frame;
  std::string interface;
  int line = 0;  ///< of the file, from 1
};

/// Frames in the order of the file; `receive_time_ns` is what the log says. Error frames are left out.
/// @throws UsageError "FILE:LINE: ..." for what is no such line
std::vector<LoggedFrame> ReadCandump(const std::filesystem::path& file);

}  // namespace servohil::run
