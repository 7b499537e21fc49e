#include "can/slcan/slcan_serial.hpp"

#include <fcntl.h>
#include <termios.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <memory>
#include <system_error>

#include "base/error.hpp"
#include "can/realtime_clock.hpp"
#include "can/slcan/slcan_codec.hpp"
#include "can/socketcan/interface_state.hpp"

namespace servohil::can {
namespace {

constexpr std::array<std::uint32_t, 9> kBitRateOfCode{10'000,  20'000,  50'000,  100'000,  125'000,
                                                      250'000, 500'000, 800'000, 1'000'000};

constexpr std::string_view kTerminals = "/dev/pts/";
constexpr std::chrono::milliseconds kTryEvery{100};  ///< while the device is gone

std::string BitRateCommand(std::uint32_t bit_rate_bit_s) {
  std::string known;
  for (std::size_t code = 0; code < kBitRateOfCode.size(); ++code) {
    if (kBitRateOfCode[code] == bit_rate_bit_s) return {'S', static_cast<char>('0' + code), '\r'};
    if (code > 0) known += ", ";
    known += std::to_string(kBitRateOfCode[code]);
  }
  throw base::UsageError("a serial CAN adapter has no code for " + std::to_string(bit_rate_bit_s) +
                         " bit/s; it knows " + known);
}

[[noreturn]] void FailToOpen(const std::string& device, int error) {
  std::string hint;
  if (error == ENOENT || error == ENXIO || error == ENODEV) {
    hint = ": is the adapter plugged in? This lists them: ls /dev/serial/by-id /dev/ttyACM* /dev/ttyUSB*";
  } else if (error == EACCES) {
    hint = ": your user must be in its group: sudo usermod -aG dialout $USER, then log in again";
  }
  throw base::EnvironmentError("cannot open " + device + ": " + std::generic_category().message(error) +
                               hint);
}

FileDescriptor OpenRaw(const std::string& device) {
  FileDescriptor fd(::open(device.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
  if (!fd) FailToOpen(device, errno);
  termios settings{};
  if (::tcgetattr(fd.Get(), &settings) != 0) {
    throw base::EnvironmentError(device + " is not a serial device");
  }
  ::cfmakeraw(&settings);
  settings.c_cflag |= static_cast<tcflag_t>(CLOCAL) | static_cast<tcflag_t>(CREAD);
  settings.c_cflag &= ~static_cast<tcflag_t>(CRTSCTS);
  ::cfsetspeed(&settings, B115200);  // USB adapters ignore it; the default of true serial ones
  if (::tcsetattr(fd.Get(), TCSANOW, &settings) != 0) {
    throw base::EnvironmentError("cannot set up " + device + ": " + std::generic_category().message(errno));
  }
  ::tcflush(fd.Get(), TCIOFLUSH);
  return fd;
}

/// @return bytes taken; -1 when the device is gone
ssize_t WriteSome(int fd, std::string_view text) noexcept {
  ssize_t size = 0;
  do {
    size = ::write(fd, text.data(), text.size());
  } while (size < 0 && errno == EINTR);
  return size < 0 && errno == EAGAIN ? 0 : size;
}

}  // namespace

bool IsTerminalOfAProgram(const std::string& device) noexcept {
  const std::unique_ptr<char, void (*)(void*)> path(::realpath(device.c_str(), nullptr), std::free);
  return path && std::string_view(path.get()).rfind(kTerminals, 0) == 0;
}

SlcanSerial::SlcanSerial(const std::string& device, const BusOptions& options)
    : path_(device),
      name_("slcan:" + device),
      bit_rate_bit_s_(options.bit_rate_bit_s),
      // CR first: ends whatever line the adapter was left in. Its refusal to close what is closed is no harm.
      begin_("\r\rC\r" + BitRateCommand(options.bit_rate_bit_s) + "O\r") {
  if (!options.allow_physical && ::access(device.c_str(), F_OK) == 0 && !IsTerminalOfAProgram(device))
    throw base::UsageError(PhysicalRefusal(name_));
  device_ = OpenRaw(device);
  if (WriteSome(device_.Get(), begin_) != static_cast<ssize_t>(begin_.size())) {
    throw base::EnvironmentError(device + " does not take commands");
  }
}

/// While somebody holds the device that is gone, the kernel gives another name to the one that comes back.
void SlcanSerial::LetGo() noexcept {
  const FileDescriptor nothing(::open("/dev/null", O_RDWR | O_CLOEXEC));
  let_go_ = nothing && ::dup3(nothing.Get(), device_.Get(), O_CLOEXEC) >= 0;
}

/// @return whether the device is there again
bool SlcanSerial::Reopen() noexcept {
  // The number of a pseudo-terminal may be another program's by now: only a link's name tells that it is
  // ours.
  if (!let_go_) LetGo();
  const auto now = std::chrono::steady_clock::now();
  if (now < next_try_ || path_.rfind(kTerminals, 0) == 0) return false;
  next_try_ = now + kTryEvery;
  try {
    const FileDescriptor device = OpenRaw(path_);
    if (::dup3(device.Get(), device_.Get(), O_CLOEXEC) < 0) return false;
  } catch (const std::exception&) {
    return false;
  }
  if (WriteSome(device_.Get(), begin_) != static_cast<ssize_t>(begin_.size())) return false;
  assembler_.Clear();
  input_at_ = input_size_ = 0;
  let_go_ = false;
  gone_ = false;
  return true;
}

SlcanSerial::~SlcanSerial() {
  if (!gone_) WriteSome(device_.Get(), "\rC\r");
}

std::string SlcanSerial::State() const {
  if (gone_) return "device gone";
  const std::string bit_rate = std::to_string(bit_rate_bit_s_) + " bit/s";
  if (!answered_) return bit_rate + ", no answer from the adapter yet";
  const std::uint64_t refusals = refusals_;
  return refusals == 0 ? bit_rate : bit_rate + ", commands refused: " + std::to_string(refusals);
}

bool SlcanSerial::HandleLine(const slcan::Line& line, Frame& frame) noexcept {
  answered_ = answered_ || line.kind != slcan::LineKind::kGarbage;
  if (line.kind == slcan::LineKind::kText) {
    // Acknowledgements: CR, "z", "Z", or a "z"/"Z" in front of a frame, as some adapters send it.
    std::string_view text = line.text;
    while (!text.empty() && (text.front() == 'z' || text.front() == 'Z')) text.remove_prefix(1);
    if (text.empty()) return false;
    if (const std::optional<Frame> parsed = slcan::ParseFrame(text, slcan::Timestamp::kAllowed)) {
      frame = *parsed;
      frame.receive_time_ns = RealTimeNs();
      Counters::Add(counters_.received);
      return true;
    }
  } else if (line.kind == slcan::LineKind::kBell) {
    ++refusals_;
  }
  Counters::Add(counters_.malformed);
  return false;
}

std::optional<Frame> SlcanSerial::NextBufferedFrame() noexcept {
  Frame frame;
  while (input_at_ < input_size_) {
    const std::optional<slcan::Line> line = assembler_.Push(input_[input_at_++]);
    if (line && HandleLine(*line, frame)) return frame;
  }
  return std::nullopt;
}

std::optional<Frame> SlcanSerial::Receive() noexcept {
  if (gone_ && !Reopen()) return std::nullopt;
  constexpr int kMaxReads = 16;  // a babbling device does not keep the caller here
  for (int i = 0; i < kMaxReads && !gone_; ++i) {
    if (const std::optional<Frame> frame = NextBufferedFrame()) return frame;
    ssize_t size = 0;
    do {
      size = ::read(device_.Get(), input_.data(), input_.size());
    } while (size < 0 && errno == EINTR);
    if (size < 0 && errno == EAGAIN) return std::nullopt;
    if (size <= 0) {  // 0: hung up
      gone_ = true;
      return std::nullopt;
    }
    input_at_ = 0;
    input_size_ = static_cast<std::size_t>(size);
  }
  return std::nullopt;
}

bool SlcanSerial::WritePending() noexcept {
  if (pending_.empty()) return true;
  const ssize_t size = WriteSome(device_.Get(), pending_);
  if (size < 0) gone_ = true;
  if (size > 0) pending_.erase(0, static_cast<std::size_t>(size));
  return pending_.empty();
}

SendResult SlcanSerial::Send(const Frame& frame) noexcept {
  if (gone_) {
    pending_.clear();
    return counters_.Count(SendResult::kDisconnected);
  }
  if (!WritePending()) return counters_.Count(gone_ ? SendResult::kDisconnected : SendResult::kQueueFull);
  const slcan::LineText line = slcan::FormatFrame(frame, std::nullopt);
  const ssize_t size = WriteSome(device_.Get(), line.View());
  if (size < 0) {
    gone_ = true;
    return counters_.Count(SendResult::kDisconnected);
  }
  if (size == 0) return counters_.Count(SendResult::kQueueFull);
  pending_ = line.View().substr(static_cast<std::size_t>(size));
  return counters_.Count(SendResult::kSent);
}

}  // namespace servohil::can
