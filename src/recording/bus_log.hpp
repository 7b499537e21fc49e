#pragma once
/// bus.log: candump's log format, as `candump -l` writes it.
///
///   (1436509052.249713) vcan0 123#DEADBEEF       8 digits of an extended identifier, #R4 a remote frame of 4
///   (1436509052.250000) vcan0 123##1DEADBEEF     CAN FD: ## and a digit of flags, 1: bit rate switch

#include <cstdint>
#include <filesystem>
#include <string>

#include "can/frame.hpp"

namespace servohil::recording {

std::string CandumpLine(std::int64_t time_ns, const std::string& bus, const can::Frame& frame);

/// Holds whole lines only, whatever fails.
class BusLog {
 public:
  /// @throws EnvironmentError when there is such a file, or it cannot be made
  explicit BusLog(const std::filesystem::path& file);
  ~BusLog();
  BusLog(const BusLog&) = delete;
  BusLog& operator=(const BusLog&) = delete;

  void Add(std::int64_t time_ns, const std::string& bus, const can::Frame& frame);
  /// To the system. @throws EnvironmentError
  void Flush();

 private:
  std::string file_;
  int fd_;
  std::int64_t size_bytes_ = 0;
  std::string pending_;
};

}  // namespace servohil::recording
